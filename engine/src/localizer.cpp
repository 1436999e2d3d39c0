// Algorithm 1 of the paper, a frame at a time.
#include "handhold/localizer.h"

#include <tbb/global_control.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "budget.h"
#include "conditions.h"
#include "depth_image.h"
#include "device.h"
#include "device_search.h"
#include "handhold/device.h"
#include "handles.h"
#include "index.h"
#include "kernels.h"
#include "layers.h"
#include "localizer_detail.h"
#include "parts.h"
#include "sampler.h"
#include "search.h"
#include "tiles.h"

namespace handhold {
namespace {

using Clock = std::chrono::steady_clock;
double milliseconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

/// What grouping and its checks leave to the end of a frame (ms): choosing between parts, and the result.
constexpr double kFinishing = 0.3;

/// A table-top cloud wider than this (m) was almost certainly given in millimetres.
constexpr float kSuspiciousExtent = 100;

void check(const CloudView& cloud) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument("cloud view: " + what); };
  if (cloud.size() > 0 && !cloud.data) fail("data is null, but width * height = " + std::to_string(cloud.size()));
  if (cloud.point_step < 12 || cloud.point_step % 4 != 0) {
    fail("point_step = " + std::to_string(cloud.point_step) + ": must be a multiple of 4 and at least 12 bytes");
  }
  if (cloud.size() >= std::size_t{1} << 31) fail(std::to_string(cloud.size()) + " points: must be fewer than 2^31");
  if (cloud.viewpoint) {
    for (const double x : *cloud.viewpoint) {
      if (!std::isfinite(x)) fail("viewpoint is not finite");
    }
  }
}

/// What frames run on.
struct ChosenBackend {
  Backend backend = Backend::kCpu;
  std::string reason;  ///< why it is the CPU, where it might have been a GPU
};

/// @throws OptionError
ChosenBackend chosen_backend(const Options& options) {
  if (options.backend == Backend::kCpu) return {};
  std::string reason = why_not_on_device(options);
  if (reason.empty()) return {Backend::kCuda, {}};
  if (options.backend == Backend::kCuda) {
    throw OptionError("backend = cuda: " + reason + "; use 'cpu', or 'auto' to fall back");
  }
  return {Backend::kCpu, std::move(reason)};
}

}  // namespace

struct Localizer::Impl {
  explicit Impl(const Options& o, const Conditions& c = {}) : Impl(o, c, chosen_backend(o), nullptr) {}
  /// On this device instead of one of CUDA's.
  Impl(const Options& o, std::unique_ptr<DeviceFrame> frame)
      : Impl(o, {}, ChosenBackend{Backend::kCuda, {}}, std::move(frame)) {}
  Impl(const Options& o, const Conditions& c, ChosenBackend where, std::unique_ptr<DeviceFrame> frame)
      : options(o),
        conditions(c),
        chosen(std::move(where)),
        index(make_index(o.index)),
        layers(o.index),
        sampler(options),
        search(options, c),
        handle_search(options),
        part_search(options, c),
        rounds(Sampler::rounds(o)) {
    // TBB warns on the console when an arena asks for more than the process allows; the result does not depend on it.
    const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    if (o.threads > 0)
      arena.initialize(static_cast<int>(std::min<std::size_t>(allowed, static_cast<std::size_t>(o.threads))));
    if (chosen.backend == Backend::kCuda) {
      try {
        device = std::make_unique<DeviceSearch>(options, frame ? std::move(frame) : make_cuda_frame());
      } catch (const DeviceError& error) {
        if (options.backend != Backend::kAuto) throw;
        chosen = {Backend::kCpu, error.what()};
      }
    }
  }

  Options options;
  Conditions conditions;
  ChosenBackend chosen;
  std::unique_ptr<DeviceSearch> device;  ///< null: on the CPU
  TileStore tiles;
  std::unique_ptr<NeighbourIndex> index;
  Layers layers;
  Sampler sampler;
  Search search;
  HandleSearch handle_search;
  DepthImage image;
  PartSearch part_search;
  tbb::task_arena arena;
  std::vector<float> samples;      ///< xyz of the last frame's (m)
  bool samples_on_device = false;  ///< they are still there, and not here
  std::vector<Step> steps;         ///< where each of them ended
  std::uint32_t looked_at = 0;     ///< how many of them the last frame had
  std::vector<Vector3> centres;
  Spares<Handle> spares;
  std::vector<int> rounds;  ///< samples of each
  std::atomic<bool> cancelled{false};
  double grouping_ms = 0;  ///< what the last frames' handles took, at most and fading

  /// In the caller's arena, or in our own when a number of threads is asked for. Isolated: a thread that waits for our
  /// tasks must not take up another of the caller's, which might call this localizer again.
  template <class F>
  void in_arena(F&& f) {
    if (options.threads > 0) {
      arena.execute([&] { tbb::this_task_arena::isolate(f); });
    } else {
      tbb::this_task_arena::isolate(f);
    }
  }

  /// Whether a cloud can be searched; false: the status says why not.
  bool searchable(std::size_t finite, const float* low, const float* high, Result& result) const {
    result.finite_points = finite;
    if (finite == 0) return result.status = Status::kNoFinitePoints, false;
    if (finite < static_cast<std::size_t>(options.min_neighbours)) return result.status = Status::kTooFewPoints, false;
    for (int k = 0; k < 3; ++k) {
      if (!options.workspace && high[k] - low[k] > kSuspiciousExtent)
        return result.status = Status::kSuspiciousUnits, false;
    }
    return true;
  }

  /// Tiles and index. False, with the status set, when the cloud cannot be searched.
  bool take(const CloudView& cloud, Result& result, const Budget& budget) {
    if (cloud.size() == 0) return result.status = Status::kEmpty, false;
    tiles.build(cloud, budget);
    if (!searchable(tiles.finite_points(), tiles.robust_low(), tiles.robust_high(), result)) return false;
    budget.check();
    index->build(tiles);
    return true;
  }

  /// Everything from the cloud to affordances, on the device.
  void search_on_device(const CloudView& cloud, Result& result) {
    const auto start = Clock::now();
    if (cloud.size() == 0) {
      result.status = Status::kEmpty;
      return;
    }
    device->take(cloud);
    const int n = options.samples;
    steps.resize(static_cast<std::size_t>(n));
    const std::uint32_t finite = device->draw(rounds, steps.data(), result.affordances);
    if (searchable(finite, device->bounds().low, device->bounds().high, result)) {
      looked_at = static_cast<std::uint32_t>(n), samples_on_device = true;
      finish(looked_at, {}, result, &device->aligned());
    } else {
      result.affordances.clear();
    }
    StageTimes& t = result.times_ms;
    device->add_times(t);
    t.total = milliseconds(start, Clock::now());
    // What is left: the way there and back.
    t.index += std::max(0.0, t.total - t.index - t.samples - t.moments - t.fit - t.shell - t.handles);
  }

  void localize(const CloudView& cloud, Result& result, const std::vector<Vector3>& guesses) {
    const auto start = Clock::now();
    const Budget budget(start, options.deadline_ms, &cancelled);
    cancelled.store(false, std::memory_order_relaxed);
    if (search_within(budget, cloud, guesses, result)) return;
    result.status = Status::kDeadline;
    if (budget.cancelled()) {
      result.status = Status::kCancelled;
      spares.take(result.handles);
      result.affordances.clear();
      result.funnel = {};
      looked_at = 0;
    }
    result.times_ms.total = milliseconds(start, Clock::now());
  }

  /// False: the budget was spent before everything was done.
  bool search_within(const Budget& budget, const CloudView& cloud, const std::vector<Vector3>& guesses,
                     Result& result) {
    const auto start = Clock::now();
    bool done = true;
    result.status = Status::kOk;
    result.points = cloud.size();
    result.finite_points = 0;
    spares.take(result.handles);
    result.affordances.clear();
    result.funnel = {};
    result.times_ms = {};
    looked_at = 0;
    samples_on_device = false;
    image.clear();
    // Elsewhere the CPU draws the samples, and needs the points, too.
    if (device && DeviceSearch::draws(options) && guesses.empty()) {
      // It is not cut: it is over before a look at the clock would end it.
      search_on_device(cloud, result);
      return !budget.cancelled();
    }
    if (device && cloud.size() > 0) device->take(cloud);
    const bool default_method = options.method == Method::kDefault;
    bool taken = false;
    double indexing = 0, seeing = 0;
    // No exception of ours goes through TBB: two at a time from both of these would break it.
    std::atomic<bool> prepared_in_time{true};
    const auto in_time = [&](const auto& work, double& ms) {
      const auto before = Clock::now();
      try {
        work();
      } catch (const Budget::Spent&) {
        prepared_in_time = false;
      }
      ms = milliseconds(before, Clock::now());
    };
    const auto index_points = [&] {
      in_time(
          [&] {
            taken = take(cloud, result, budget);
            if (!taken) return;
            layers.take(tiles, *index);
            if (default_method) layers.thin(cloud, budget);
          },
          indexing);
    };
    const auto see = [&] { in_time([&] { image.build(cloud, conditions, budget); }, seeing); };
    // Side by side: some parts of both take one thread only.
    if (default_method) {
      tbb::parallel_invoke(index_points, see);
    } else {
      index_points();
    }
    if (!prepared_in_time) return false;
    if (!taken) return true;

    double sampling = 0;
    sampler.begin(tiles, *index, conditions.pass_flat ? &image : nullptr);
    const auto prepared = Clock::now();
    // Steps that run side by side share the wall-clock time of their common section as they share its work.
    const double both = milliseconds(start, prepared) / std::max(1e-9, indexing + seeing);
    result.times_ms.index = both * indexing, result.times_ms.visibility = both * seeing;
    if (!device) search.begin(layers, cloud.viewpoint, &image);
    if (sampler.points() == 0) {
      result.status = Status::kTooFewPoints;
    } else {
      std::uint32_t first = 0;
      samples.resize(3 * static_cast<std::size_t>(options.samples));
      steps.resize(static_cast<std::size_t>(options.samples));
      // What was found has to become handles in time, too.
      const Budget searching = options.deadline_ms ? budget.less(time_for_handles(*options.deadline_ms)) : budget;
      for (int round = 0; round < static_cast<int>(rounds.size()) && done; ++round) {
        const int n = rounds[static_cast<std::size_t>(round)];
        const auto before = Clock::now();
        float* xyz = samples.data() + 3 * static_cast<std::size_t>(first);
        try {
          if (round == 0) {
            const int about = guesses.empty() ? 0 : n / 2;
            if (about > 0) {
              sampler.set_centres(guesses);
              sampler.propose(round, about, xyz, searching);
            }
            sampler.uniform(round, n - about, xyz + 3 * static_cast<std::size_t>(about), searching);
          } else {
            centres.clear();
            for (const Affordance& a : result.affordances) centres.push_back(a.center);
            sampler.set_centres(centres);
            sampler.propose(round, n, xyz, searching);
          }
        } catch (const Budget::Spent&) {
          done = false;
          break;
        }
        sampling += milliseconds(before, Clock::now());
        const auto count = static_cast<std::uint32_t>(n);
        if (device) {
          device->run(xyz, count, first, steps.data() + first, result.affordances);
          done = !searching.spent();
        } else {
          done = search.run(xyz, count, first, steps.data() + first, result.affordances, searching);
        }
        first += static_cast<std::uint32_t>(n);
      }
      looked_at = first;
      if (!finish(first, budget.less(kFinishing), result)) done = false;
    }
    // Here, too, the steps share the wall-clock time as they share the work.
    const auto searched = Clock::now();
    StageTimes& t = result.times_ms;
    const StepSeconds s = device ? StepSeconds{} : search.seconds();
    const double work = s.neighbours + s.moments + s.fit + s.shell;
    const double wall = milliseconds(prepared, searched) - sampling - t.handles;
    const double share = work > 0 ? std::min(1.0, wall / (1e3 * work)) * 1e3 : 0;
    t.neighbours = share * s.neighbours, t.moments = share * s.moments, t.fit = share * s.fit,
    t.shell = share * s.shell;
    double rest = wall - share * work;
    if (device) {
      device->add_times(t);
      rest -= t.moments + t.fit + t.shell;
    }
    t.samples = sampling + std::max(0.0, rest);
    t.total = milliseconds(start, searched);
    return done;
  }

  /// Of a frame (ms). Before the first one is known it is a guess.
  double time_for_handles(double deadline) const {
    return std::min(0.5 * deadline, kFinishing + (grouping_ms > 0 ? 1.2 * grouping_ms : 0.3 * deadline));
  }

  /// Funnel and handles, after the last sample. False: the budget was spent, and some were left out. `aligned`: as for
  /// HandleSearch::run.
  bool finish(std::uint32_t n, const Budget& budget, Result& result,
              const std::vector<std::uint32_t>* aligned = nullptr) {
    const auto start = Clock::now();
    bool done = true;
    // Several counts of each: a run of equal steps would wait for itself.
    std::int64_t counts[4][11] = {}, count[11] = {};
    for (std::uint32_t i = 0; i < n; ++i) ++counts[i % 4][static_cast<std::size_t>(steps[i])];
    for (const auto& some : counts)
      for (std::size_t k = 0; k < 11; ++k) count[k] += some[k];
    Funnel& f = result.funnel;
    f.samples = n;
    f.too_few_points = count[static_cast<std::size_t>(Step::kTooFewPoints)];
    f.flat = count[static_cast<std::size_t>(Step::kFlat)];
    f.curvature_low = count[static_cast<std::size_t>(Step::kCurvatureLow)];
    f.concave = count[static_cast<std::size_t>(Step::kConcave)];
    f.poor_fit = count[static_cast<std::size_t>(Step::kPoorFit)];
    f.circle_wide = count[static_cast<std::size_t>(Step::kCircleWide)];
    f.circle_narrow = count[static_cast<std::size_t>(Step::kCircleNarrow)];
    f.no_gap = count[static_cast<std::size_t>(Step::kNoGap)];
    f.shell_empty = count[static_cast<std::size_t>(Step::kShellEmpty)];
    f.affordances = count[static_cast<std::size_t>(Step::kAffordance)];
    f.cut = count[static_cast<std::size_t>(Step::kCut)];
    if (image.empty()) {
      handle_search.run(result.affordances, spares, result.handles, f, aligned);
    } else {
      done = part_search.run(result.affordances, tiles, *index, image, spares, result.handles, f, budget);
    }
    result.times_ms.handles = milliseconds(start, Clock::now());
    if (done) grouping_ms = std::max(result.times_ms.handles, 0.9 * grouping_ms);
    return done;
  }
};

Localizer::Localizer(const Options& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(options);
}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

Result Localizer::localize(const CloudView& cloud) {
  Result result;
  localize(cloud, result);
  return result;
}

void Localizer::localize(const CloudView& cloud, Result& result) {
  localize(cloud, result, {});
}

void Localizer::localize(const CloudView& cloud, Result& result, const std::vector<Vector3>& guesses) {
  check(cloud);
  for (const Vector3& p : guesses) {
    for (const double x : p) {
      if (!std::isfinite(x)) throw std::invalid_argument("guesses: a place is not finite");
    }
  }
  impl_->in_arena([&] { impl_->localize(cloud, result, guesses); });
}

void Localizer::set_seed(std::uint64_t seed) {
  impl_->options.seed = seed;
}

void Localizer::cancel() noexcept {
  impl_->cancelled.store(true, std::memory_order_relaxed);
}

std::vector<Sample> Localizer::samples() const {
  std::vector<Sample> samples(impl_->looked_at);
  if (impl_->samples_on_device && !samples.empty()) {
    impl_->samples.resize(3 * samples.size());
    impl_->device->positions(impl_->samples.data());
    impl_->samples_on_device = false;
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const float* p = &impl_->samples[3 * i];
    samples[i] = {{p[0], p[1], p[2]}, impl_->steps[i]};
  }
  return samples;
}

const Options& Localizer::options() const {
  return impl_->options;
}
Backend Localizer::backend() const {
  return impl_->chosen.backend;
}
const std::string& Localizer::backend_reason() const {
  return impl_->chosen.reason;
}
const char* Localizer::isa() {
  return kernels::kernels().name;
}

Localizer LocalizerInside::make(const Options& options, const Conditions& conditions) {
  Localizer localizer(options);
  localizer.impl_ = std::make_unique<Localizer::Impl>(options, conditions);
  return localizer;
}
Localizer LocalizerInside::on_device(const Options& options, std::unique_ptr<DeviceFrame> frame) {
  Localizer localizer(options);
  localizer.impl_ = std::make_unique<Localizer::Impl>(options, std::move(frame));
  return localizer;
}
const Recycled<PartCandidate>& LocalizerInside::candidates(const Localizer& localizer) {
  return localizer.impl_->part_search.candidates();
}

void localize_samples(const Options& options, const CloudView& cloud, const std::vector<std::array<float, 3>>& samples,
                      Result& result, std::vector<Step>& steps, std::unique_ptr<DeviceFrame> device) {
  options.validate();
  check(cloud);
  TileStore tiles;
  const std::unique_ptr<NeighbourIndex> index = make_index(options.index);
  Search search(options);
  HandleSearch handles(options);
  result = {};
  result.points = cloud.size();
  steps.assign(samples.size(), Step::kTooFewPoints);
  if (cloud.size() == 0) return;
  tiles.build(cloud);
  result.finite_points = tiles.finite_points();
  if (result.finite_points == 0 || samples.empty()) return;
  const auto n = static_cast<std::uint32_t>(samples.size());
  if (device) {
    DeviceSearch on_device(options, std::move(device));
    on_device.take(cloud);
    on_device.run(samples.front().data(), n, 0, steps.data(), result.affordances);
  } else {
    index->build(tiles);
    Layers layers(options.index);
    layers.take(tiles, *index);
    search.begin(layers, cloud.viewpoint);
    search.run(samples.front().data(), n, 0, steps.data(), result.affordances);
  }
  result.funnel.samples = static_cast<std::int64_t>(samples.size());
  result.funnel.affordances = static_cast<std::int64_t>(result.affordances.size());
  Spares<Handle> spares;
  handles.run(result.affordances, spares, result.handles, result.funnel);
}

}  // namespace handhold
