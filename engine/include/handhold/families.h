// Families of household objects: parametric closed meshes of real size with their graspable parts, each also as a union
// of convex pieces.
//
//   sensor::Object object = sensor::make_object("hammer", {{"shaft_length", 0.3}});
//   for (const sensor::Family& family : sensor::families()) ...
//
// Metres and radians. Objects stand on z = 0 about the origin, or lie there as their maker finds natural.
//
// Which parts an object has follows from its geometry alone. A part is a stretch of at least 20 mm along a centre line
// whose section
//   - is round or roundish: a circle, an ellipse, or a rectangle whose corners are rounded by at least 0.6 of its
//   smaller
//     half side (a strap), at most six times as wide as it is thick;
//   - is convex, and bounds the solid all around but for what is attached at less than half of it (a mug's handle on
//   its
//     body); hollow things count by their outside;
//   - is at most 41 mm in radius: half of its larger side;
//   - stays along the stretch within 40 % of its mean radius, with ends that differ by at most 0.75 of the length: so
//     much may a bottle's shoulder taper.
// Every such stretch is listed. What one would hold the object by, and what is plainly handle-like, has a confidence of
// 1 and is asked for. Incidental ones (a hammer's face and claw, a chuck, a spout, necks and shafts between two parts)
// have less than 0.5: right when they are found, but not asked for. So have the ends of curved handles, from 10 mm on.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "handhold/sensor.h"

namespace handhold::sensor {

/// Sizes by name (m).
using Sizes = std::map<std::string, double>;

/// One size of a family and how far it may vary (m).
struct SizeRange {
  std::string name;
  double value = 0;  ///< the default; low <= value <= high
  double low = 0, high = 0;
};

enum class FamilyGroup {
  kGraspable,  ///< has parts that an 0.08 m hand can hold
  kPlain,      ///< a thing without any
  kFurniture,  ///< what things stand on and before
};

/// Two disjoint halves, so that what is tuned on one half can be judged on shapes that it has not seen. The twelve
/// objects of the paper's Table 1 are all in kReport.
enum class FamilyHalf { kTuning, kReport, kBoth };

struct Family {
  std::string name;
  FamilyGroup group = FamilyGroup::kGraspable;
  FamilyHalf half = FamilyHalf::kTuning;
  bool stands = true;  ///< as made it rests on z = 0; otherwise it has to be laid down
  std::vector<SizeRange> sizes;
};

/// All families, in a fixed order.
const std::vector<Family>& families();
/// @throws std::invalid_argument for an unknown name, listing the known ones
const Family& family(const std::string& name);

/// An object of a family; sizes that are not given have their defaults. The object's name is the family's.
/// @throws std::invalid_argument for an unknown family or size (listing the known ones) and for a value out of range
Object make_object(const std::string& family, const Sizes& sizes = {});

/// Closed convex meshes whose union is about make_object's solid (hollow and curved things are cut into slices), for
/// programs that know convex shapes only. @throws std::invalid_argument as make_object
std::vector<Mesh> convex_pieces(const std::string& family, const Sizes& sizes = {});

}  // namespace handhold::sensor
