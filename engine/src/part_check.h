// Is there a part where a group of affordances says so? The group is fitted again to the points of the cloud and looked
// at slice by slice, so that a handle stands on what was measured and not on what its members claim.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "aligned.h"
#include "confidence.h"
#include "cylinder.h"
#include "depth_image.h"
#include "fingers.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "index.h"
#include "profile.h"
#include "tiles.h"

namespace handhold {

/// Affordances that lie on one line, one after the other.
struct PartGroup {
  Cylinder mean;
  double low, high;  ///< m; along the axis from mean.point
  std::vector<std::uint32_t> members;
};

/// What may become a handle.
struct PartCandidate {
  Handle handle;
  Evidence evidence;
};

class PartCheck {
 public:
  void begin(const Options& options, const TileStore& tiles, const NeighbourIndex& index, const DepthImage& image) {
    options_ = &options, tiles_ = &tiles, index_ = &index, image_ = &image;
  }

  /// Appends the parts on the group's line that the points bear out: none, one, or several of different radii.
  void run(const PartGroup& group, const std::vector<Affordance>& affordances, std::vector<PartCandidate>& found);

 private:
  /// Points near the line, and where they are relative to the cylinder: height along its axis, distance from it.
  struct Points {
    std::vector<float> x, y, z;
    std::vector<std::uint32_t> id;  ///< position in the tiles
    std::vector<float> height, distance, side, ahead;
    std::vector<char> on;  ///< lies on the cylinder, with a normal that points away from the axis
    std::size_t size() const { return id.size(); }
    void clear() { x.clear(), y.clear(), z.clear(), id.clear(); }
  };
  struct Slice {
    double count = 0, square = 0, distance = 0;  ///< points; sums of squared deviation and of distance from the axis
    double low = 10, high = -10;                 ///< angles about the axis (rad)
  };
  /// A cylinder's own frame: `ahead` across the axis towards the sensor, `side` across both.
  struct Frame {
    Vector3 ahead, side;
  };

  Frame frame(const Cylinder& c) const;
  void gather(const Cylinder& c, double low, double high);
  const Vector3& normal_of(std::uint32_t id, const float* p);
  void locate(const Cylinder& c);
  void mark(const Cylinder& c, double low, double high);
  std::size_t select(const Cylinder& c, double low, double high);
  void fill_slices(const Cylinder& c, double low, std::size_t n);
  bool measure(Cylinder c, double low, double high, bool cut, const PartGroup& group,
               const std::vector<Affordance>& affordances, PartCandidate& found);
  double corner_gain(double residual);

  const Options* options_ = nullptr;
  const TileStore* tiles_ = nullptr;
  const NeighbourIndex* index_ = nullptr;
  const DepthImage* image_ = nullptr;
  double sigma_ = 0;
  CandidateList near_, around_;
  Points points_;
  std::vector<std::uint32_t> ids_;
  std::unordered_map<std::uint32_t, Vector3> normals_;
  AlignedArray<float> x_, y_, z_;
  std::vector<float> fit_x_, fit_y_, fit_z_;
  std::vector<std::uint32_t> selected_;  ///< positions in points_
  std::vector<Slice> slices_;
  std::vector<double> usual_;
  std::vector<ProfileSlice> profile_;
  std::vector<ProfilePiece> pieces_;
  ProfileScratch profile_scratch_;
  std::vector<std::array<double, 2>> section_;
  std::vector<std::array<double, 6>> section_sums_;
};

}  // namespace handhold
