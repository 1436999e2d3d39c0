// From affordances of the default method to handles.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <vector>

#include "budget.h"
#include "depth_image.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "index.h"
#include "part_check.h"
#include "tiles.h"

namespace handhold {

class PartSearch {
 public:
  explicit PartSearch(const Options& options, const Conditions& conditions = {})
      : options_(&options), conditions_(conditions) {}

  /// Finds the handles of the affordances and counts where each affordance ended. False: the budget was spent, and
  /// groups of lesser affordances were left out.
  bool run(const std::vector<Affordance>& affordances, const TileStore& tiles, const NeighbourIndex& index,
           const DepthImage& image, std::vector<Handle>& handles, Funnel& funnel, const Budget& budget = {});

  /// Those of the last run's parts that no other one explains, best first: also those that are no handles for want of
  /// confidence.
  const std::vector<PartCandidate>& candidates() const { return kept_; }

 private:
  void make_groups(const std::vector<Affordance>& affordances, const Budget& budget);

  const Options* options_;
  Conditions conditions_;
  std::vector<PartGroup> groups_;
  std::vector<Bow> bows_;
  std::vector<std::vector<PartCandidate>> found_;  ///< of each group
  std::vector<PartCandidate> all_, kept_;
  std::vector<PartCandidate> likely_;
  tbb::enumerable_thread_specific<PartCheck> checks_;
};

}  // namespace handhold
