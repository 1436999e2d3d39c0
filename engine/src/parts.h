// From affordances of the default method to handles.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <vector>

#include "aligned.h"
#include "bow_groups.h"
#include "budget.h"
#include "chain.h"
#include "depth_image.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "index.h"
#include "part_check.h"
#include "recycled.h"
#include "resolve.h"
#include "tiles.h"

namespace handhold {

class PartSearch {
 public:
  explicit PartSearch(const Options& options, const Conditions& conditions = {})
      : options_(&options), conditions_(conditions) {}

  /// Finds the handles of the affordances and counts where each affordance ended. False: the budget was spent, and
  /// groups of lesser affordances were left out. `spares`: what handles are made from; what `handles` held before goes
  /// there.
  bool run(const std::vector<Affordance>& affordances, const TileStore& tiles, const NeighbourIndex& index,
           const DepthImage& image, Spares<Handle>& spares, std::vector<Handle>& handles, Funnel& funnel,
           const Budget& budget = {});

  /// Those of the last run's parts that no other one explains, best first: also those that are no handles for want of
  /// confidence.
  const Recycled<PartCandidate>& candidates() const { return kept_; }

 private:
  void make_groups(const std::vector<Affordance>& affordances, const Budget& budget);

  const Options* options_;
  Conditions conditions_;
  Recycled<PartGroup> groups_, bow_groups_;
  Recycled<Bow> bows_;
  BowSearch bow_search_;
  std::vector<const PartGroup*> all_groups_;
  std::vector<std::uint32_t> first_;            ///< groups in the order in which they are looked at
  std::vector<Recycled<PartCandidate>> found_;  ///< of each group
  std::vector<const PartCandidate*> all_;
  Recycled<PartCandidate> kept_;
  Resolver resolver_;
  ChainSearch chains_;
  std::vector<std::uint8_t> fate_;  ///< of each affordance
  // What grouping takes.
  AlignedArray<float> rows_[7];  ///< position, axis and radius of each affordance
  AlignedArray<std::int32_t> near_;
  std::vector<std::uint8_t> uses_;
  std::vector<std::uint32_t> order_;
  std::vector<std::pair<double, std::uint32_t>> members_;
  std::vector<double> radii_, widths_;
  tbb::enumerable_thread_specific<PartCheck> checks_;
};

}  // namespace handhold
