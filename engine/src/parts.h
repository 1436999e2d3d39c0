// From affordances of the default method to handles: each group is fitted again to the points of the cloud and looked
// at slice by slice, so that a handle stands on what was measured and not on what its members claim.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "aligned.h"
#include "cylinder.h"
#include "depth_image.h"
#include "fingers.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "index.h"
#include "tiles.h"

namespace handhold {

class PartSearch {
 public:
  explicit PartSearch(const Options& options) : options_(&options) {}

  /// Finds the handles of the affordances and counts where each affordance ended.
  void run(const std::vector<Affordance>& affordances, const TileStore& tiles, const NeighbourIndex& index,
           const DepthImage& image, std::vector<Handle>& handles, Funnel& funnel);

 private:
  /// Points of the cloud near a cylinder, some of them left out where there are many.
  struct Band {
    std::vector<float> x, y, z;
    std::vector<std::uint32_t> id;  ///< position in the tiles
    double weight = 1;              ///< points that each one stands for
    PointArrays arrays() const { return {x.data(), y.data(), z.data(), id.size()}; }
  };
  struct Slice {
    double count = 0, square = 0;    ///< points; sum of squared distances from the surface
    double low = 10, high = -10;     ///< angles about the axis (rad)
  };

  bool confirm(Cylinder cylinder, double low, double high, Handle& handle);
  void take_points(const Cylinder& cylinder, double low, double high, double tolerance, bool by_normal);
  const float* normal_of(std::uint32_t id, const float* p);
  void remove_overlaps(std::vector<Handle>& handles) const;

  const Options* options_;
  const TileStore* tiles_ = nullptr;
  const NeighbourIndex* index_ = nullptr;
  const DepthImage* image_ = nullptr;
  CandidateList near_, around_;
  Band band_;
  std::vector<std::uint8_t> normal_known_;
  std::vector<float> normals_;
  AlignedArray<float> x_, y_, z_;
  std::vector<Slice> slices_;
};

}  // namespace handhold
