// The method written the classic way: PCL searches, dense matrices, LAPACK, a loop over radii, all pairs.
//
// This is what the engine is compared with: the same mathematics and the same decisions for the same samples, one
// thread, one function per stage (stages.h), no allocation that can be avoided and the same compiler flags, but none of
// the engine's ideas: every stage visits its points again, and every sample stands alone.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/options.h"
#include "handhold/result.h"

namespace handhold::baseline {

/// Where neighbours come from.
enum class Search {
  kKdTree,     ///< pcl::KdTreeFLANN; any cloud
  kOrganized,  ///< pcl::search::OrganizedNeighbor; organized clouds whose projection PCL can recover
};

/// Where the curvature is looked at; the median counts.
enum class CurvaturePoints {
  kRandom,  ///< fifty neighbours brought to the surface: the paper's "several", as many as the published code takes
  kFixed,   ///< the engine's nine points, for comparing decisions: a random choice decides otherwise near the limit
};

struct Settings {
  Search search = Search::kKdTree;
  CurvaturePoints curvature_points = CurvaturePoints::kRandom;
  double shell_step = 0.001;  ///< m; of the radius in the search for a gap, above 0
};

/// How a sample ended, in the order of the steps.
enum class Outcome {
  kTooFewPoints,
  kFlat,
  kCurvatureLow,
  kCircleWide,
  kCircleNarrow,
  kNoGap,
  kShellEmpty,
  kAffordance,
};
inline constexpr int kOutcomes = 8;
/// "too_few_points", "flat", ... as the fields of Funnel; "affordance".
std::string_view to_string(Outcome);

struct SampleResult {
  Outcome outcome = Outcome::kTooFewPoints;
  std::int32_t neighbours = 0;  ///< points in the ball
  /// What the steps before the outcome gave: `curvature` from kCurvatureLow on, `axis`, `center` and `radius` from
  /// kCircleWide on, the rest for kAffordance.
  Affordance affordance{};
};

/// Seconds of each stage.
struct StageSeconds {
  double index = 0;       ///< copy into a PCL cloud and construction of the search structure
  double neighbours = 0;  ///< points of each ball
  double fit = 0;         ///< M and N, dggev
  double curvature = 0;
  double circle = 0;
  double shell = 0;  ///< its own search included
  double handles = 0;
  double total = 0;  ///< wall clock of the whole call
};

struct Result {
  std::vector<SampleResult> samples;  ///< one for each sample, in their order
  std::vector<Handle> handles;  ///< `affordances` are indices into `samples`; confidence is 0, approach is -normal
  StageSeconds seconds;
};

/// Looks at each sample (x, y, z; metres; cloud frame) with the first of Options::radius, then searches for handles. Of
/// the options, those about samples, method, index and threads have no effect; the axis is always the Taubin one.
/// @throws std::invalid_argument when kOrganized is asked for and PCL finds no projection for the cloud
Result localize(const CloudView& cloud, const Options& options, const std::vector<std::array<float, 3>>& samples,
                const Settings& settings = {});

}  // namespace handhold::baseline
