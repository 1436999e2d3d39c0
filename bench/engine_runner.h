// The engine's frame on given samples, with everything that a localizer keeps from frame to frame.
#pragma once

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <vector>

#include "handles.h"
#include "index.h"
#include "search.h"

namespace handhold::bench {

/// What Localizer does between taking a cloud and returning handles, but for the drawing of samples.
class EngineRunner {
 public:
  explicit EngineRunner(const Options& options)
      : options_(options),
        index_(make_index(options.index)),
        layers_(options.index),
        search_(options_),
        handles_(options_) {
    if (options.threads > 0) arena_.initialize(options.threads);
  }
  EngineRunner(const EngineRunner&) = delete;

  /// steps[i]: where sample i ended. The cloud must have a finite point. Fills the affordances, handles and times of
  /// `result`; the time that no stage owns is that of sorting and grouping the samples (`times_ms.samples`).
  void run(const CloudView& cloud, const std::vector<std::array<float, 3>>& samples, Result& result,
           std::vector<Step>& steps) {
    arena_.execute([&] { run_here(cloud, samples, result, steps); });
  }

 private:
  using Clock = std::chrono::steady_clock;
  static double milliseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
  }

  void run_here(const CloudView& cloud, const std::vector<std::array<float, 3>>& samples, Result& result,
                std::vector<Step>& steps) {
    const auto start = Clock::now();
    result.affordances.clear();
    spares_.take(result.handles);
    result.funnel = {};
    steps.resize(samples.size());
    tiles_.build(cloud);
    index_->build(tiles_);
    const auto indexed = Clock::now();
    layers_.take(tiles_, *index_);
    search_.begin(layers_, cloud.viewpoint);
    search_.run(samples.front().data(), static_cast<std::uint32_t>(samples.size()), 0, steps.data(),
                result.affordances);
    const auto searched = Clock::now();
    handles_.run(result.affordances, spares_, result.handles, result.funnel);
    const auto end = Clock::now();

    // Stages of the search ran side by side: each gets its share of the section's wall clock.
    const StepSeconds s = search_.seconds();
    const double work = 1e3 * (s.neighbours + s.moments + s.fit + s.shell), wall = milliseconds(indexed, searched);
    const double share = work > 0 ? 1e3 * std::min(1.0, wall / work) : 0;
    StageTimes& t = result.times_ms;
    t = {};
    t.index = milliseconds(start, indexed);
    t.samples = std::max(0.0, wall - work);
    t.neighbours = share * s.neighbours;
    t.moments = share * s.moments;
    t.fit = share * s.fit;
    t.shell = share * s.shell;
    t.handles = milliseconds(searched, end);
    t.total = milliseconds(start, end);
  }

  Options options_;
  TileStore tiles_;
  std::unique_ptr<NeighbourIndex> index_;
  Layers layers_;
  Search search_;
  HandleSearch handles_;
  Spares<Handle> spares_;
  tbb::task_arena arena_;
};

}  // namespace handhold::bench
