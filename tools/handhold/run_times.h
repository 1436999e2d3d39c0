// Times of repeated runs.
#pragma once

#include <utility>
#include <vector>

#include "handhold/result.h"

namespace handhold {

/// The stages by the names that JSON and tables give them, in the order of the work; `total` comes last.
inline constexpr std::pair<const char*, double StageTimes::*> kStages[] = {
    {"index", &StageTimes::index},           {"samples", &StageTimes::samples}, {"neighbours", &StageTimes::neighbours},
    {"moments", &StageTimes::moments},       {"fit", &StageTimes::fit},         {"shell", &StageTimes::shell},
    {"visibility", &StageTimes::visibility}, {"handles", &StageTimes::handles}, {"total", &StageTimes::total},
};

struct RunTimes {
  int runs = 0;
  StageTimes median_ms;  ///< of each stage on its own: the stages need not add up to the total
  StageTimes p99_ms;     ///< 99th percentile (nearest rank): of fewer than 100 runs, the slowest
};

/// @param runs  times of one or more runs
RunTimes summarize(const std::vector<StageTimes>& runs);

}  // namespace handhold
