// From affordances of the default method to handles: each group is fitted again to the points of the cloud and looked
// at slice by slice, so that a handle stands on what was measured and not on what its members claim.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <unordered_map>
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
    double count = 0, square = 0;  ///< points; sum of squared distances from the surface
    double low = 10, high = -10;   ///< angles about the axis (rad)
  };

  /// Affordances that lie on one line, one after the other.
  struct Group {
    Cylinder mean;
    double low, high;  ///< m; along the axis from mean.point
    std::vector<std::uint32_t> members;
  };
  /// One per thread.
  struct Worker {
    CandidateList near, around;
    Band band, run;
    std::vector<std::uint32_t> found;
    std::unordered_map<std::uint32_t, Vector3> normals;
    AlignedArray<float> x, y, z;
    std::vector<Slice> slices;
  };

  void make_groups(const std::vector<Affordance>& affordances, std::vector<Group>& groups) const;
  bool confirm(const Group& group, Worker& worker, Handle& handle) const;
  void take_points(const Cylinder& cylinder, double low, double high, double tolerance, bool by_normal,
                   Worker& worker) const;
  const Vector3& normal_of(std::uint32_t id, const float* p, Worker& worker) const;
  void remove_overlaps(std::vector<Handle>& handles) const;

  const Options* options_;
  const TileStore* tiles_ = nullptr;
  const NeighbourIndex* index_ = nullptr;
  const DepthImage* image_ = nullptr;
  tbb::enumerable_thread_specific<Worker> workers_;
};

}  // namespace handhold
