#include "run_times.h"

#include <algorithm>

namespace handhold {

RunTimes summarize(const std::vector<StageTimes>& runs) {
  RunTimes times;
  times.runs = static_cast<int>(runs.size());
  std::vector<double> sorted(runs.size());
  for (const auto& [name, stage] : kStages) {
    std::transform(runs.begin(), runs.end(), sorted.begin(), [stage = stage](const StageTimes& t) { return t.*stage; });
    std::sort(sorted.begin(), sorted.end());
    const std::size_t n = sorted.size();
    times.median_ms.*stage = (sorted[(n - 1) / 2] + sorted[n / 2]) / 2;
    times.p99_ms.*stage = sorted[(99 * n + 99) / 100 - 1];
  }
  return times;
}

}  // namespace handhold
