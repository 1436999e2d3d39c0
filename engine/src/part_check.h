// Is there a part where a group of affordances says so? The group is fitted again to the points of the cloud and looked
// at slice by slice, so that a handle stands on what was measured and not on what its members claim.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "bow.h"
#include "conditions.h"
#include "confidence.h"
#include "cylinder.h"
#include "depth_image.h"
#include "fingers.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "index.h"
#include "part_points.h"
#include "profile.h"
#include "recycled.h"
#include "silhouette.h"
#include "tiles.h"

namespace handhold {

/// Affordances that lie on one line, one after the other.
struct PartGroup {
  Cylinder mean;
  double low, high;  ///< m; along the axis from mean.point
  std::vector<std::uint32_t> members;
  std::size_t straps;        ///< of the members: those that were found by their outline
  const Bow* bow = nullptr;  ///< the curved part that this is the middle of

  void clear() { mean = {}, low = high = 0, members.clear(), straps = 0, bow = nullptr; }
};

/// What may become a handle.
struct PartCandidate {
  Handle handle;
  Evidence evidence;
  /// Towards -axis and +axis: beyond this end the radius jumps, what goes on there is another part.
  bool ends_low = false, ends_high = false;

  /// As if it were new; its vectors keep their memory.
  void clear() {
    std::vector<Vector3> path = std::move(handle.path);
    std::vector<std::uint32_t> affordances = std::move(handle.affordances);
    path.clear(), affordances.clear();
    *this = {};
    handle.path = std::move(path), handle.affordances = std::move(affordances);
  }
};

class PartCheck {
 public:
  void begin(const Options& options, const TileStore& tiles, const NeighbourIndex& index, const DepthImage& image,
             const Conditions& conditions = {}) {
    options_ = &options, image_ = &image, conditions_ = conditions;
    points_.begin(tiles, index, image, conditions.filter_normals);
  }

  /// Appends the parts on the group's line that the points bear out: none, one, or several of different radii.
  void run(const PartGroup& group, const std::vector<Affordance>& affordances, Recycled<PartCandidate>& found);

 private:
  struct Slice {
    double count = 0, square = 0, distance = 0;  ///< points; sums of squared deviation and of distance from the axis
    double low = 10, high = -10;                 ///< angles about the axis (rad)
  };

  /// A slice's outermost points about the axis; turns rise with the angle from -2 to 2.
  struct Turns {
    double low = 10, high = -10;
    std::uint32_t first = 0, last = 0;
  };

  void fill_slices(const Cylinder& c, double low, std::size_t n);
  bool refit(double low, double high, Cylinder& c);
  bool find_pieces(const Cylinder& c, double low, std::size_t n);
  double radius_of(const ProfilePiece& piece) const;
  enum class Kind {
    kWhole,  ///< the cylinder is as fitted
    kPiece,  ///< the fit was to several pieces of different radii
    kStrap,  ///< the outline tells its width, and nothing its roundness
  };
  void find_outline(const Cylinder& c, double low, std::size_t n);
  std::array<double, 2> sum_outline(std::size_t first, std::size_t last, double radius, Evidence& e);
  bool is_strap(std::size_t i, double half_width) const;
  bool measure_strap(const PartGroup& group, const std::vector<Affordance>& affordances, PartCandidate& found);
  bool measure(Cylinder c, double low, double high, Kind kind, const PartGroup& group,
               const std::vector<Affordance>& affordances, PartCandidate& found);
  void follow(const Bow* known, PartCandidate& found);
  static std::pair<std::size_t, std::size_t> longest_run(std::vector<char>& pass);
  double corner_gain(double residual);

  const Options* options_ = nullptr;
  Conditions conditions_;
  const DepthImage* image_ = nullptr;
  double sigma_ = 0;
  PartPoints points_;
  Bow bow_;
  BowScratch bow_scratch_;
  std::vector<Slice> slices_;
  std::vector<Turns> turns_;
  std::vector<double> usual_, others_, free_;
  std::vector<char> candidates_, pass_;  ///< slices that may hold a part; those that the hand can hold
  std::vector<std::array<SilhouetteSide, 2>> outline_;
  std::vector<ProfileSlice> profile_;
  std::vector<ProfilePiece> pieces_;
  ProfileScratch profile_scratch_;
  std::vector<std::array<double, 2>> section_;
  std::vector<std::array<double, 6>> section_sums_;
};

}  // namespace handhold
