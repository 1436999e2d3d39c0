// The engine against the classic way, on one cloud and the same samples, interleaved in one process.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "agreement.h"
#include "baseline/baseline.h"
#include "engine_runner.h"
#include "handhold/localizer.h"
#include "scene.h"

namespace handhold::bench {
namespace {

using baseline::StageSeconds;

// Stages of the published ROS package (C++, PCL, LAPACK) with 20,000 samples on a 640x480 Kinect frame, one thread.
constexpr int kPublishedSamples = 20000;
constexpr StageSeconds kPublished = {0, 0.24, 0.62, 1.07, 0.04, 0.08, 0.05, 2.10};
// Where a stage of ours is slower than this many times the published one, the published figure counts.
constexpr double kPublishedSlack = 1.25;

// Frames of the engine, with either number of threads, for one of the baseline.
constexpr int kFrames = 10;

struct Stage {
  const char* name;
  std::function<double(const StageSeconds&)> seconds;
};
const std::vector<Stage>& stages() {
  static const std::vector<Stage> list = {
      {"neighbours", [](const StageSeconds& s) { return s.index + s.neighbours; }},
      {"fit", [](const StageSeconds& s) { return s.fit; }},
      {"curvature", [](const StageSeconds& s) { return s.curvature; }},
      {"circle", [](const StageSeconds& s) { return s.circle; }},
      {"shell", [](const StageSeconds& s) { return s.shell; }},
      {"handles", [](const StageSeconds& s) { return s.handles; }},
  };
  return list;
}

double milliseconds(const std::function<void()>& run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

template <class T, class Get>
double median_of(const std::vector<T>& values, Get&& get) {
  std::vector<double> numbers;
  for (const T& value : values) numbers.push_back(get(value));
  return median(std::move(numbers));
}

// The engine's affordances by sample, as the baseline gives its own.
std::vector<baseline::SampleResult> by_sample(const std::vector<Step>& steps, const Result& result) {
  // The steps of the paper's method, which alone is compared; kConcave and kPoorFit are none of them.
  using baseline::Outcome;
  constexpr Outcome kOutcome[] = {
      Outcome::kTooFewPoints, Outcome::kFlat,  Outcome::kCurvatureLow, Outcome::kCurvatureLow, Outcome::kCircleWide,
      Outcome::kCircleNarrow, Outcome::kNoGap, Outcome::kNoGap,        Outcome::kShellEmpty,   Outcome::kAffordance};
  static_assert(std::size(kOutcome) == static_cast<std::size_t>(Step::kAffordance) + 1, "one for each step");
  std::vector<baseline::SampleResult> samples(steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) samples[i].outcome = kOutcome[static_cast<std::size_t>(steps[i])];
  for (const Affordance& affordance : result.affordances) samples.at(affordance.sample).affordance = affordance;
  return samples;
}

struct EngineRuns {
  std::vector<double> ms;  // wall clock
  std::vector<StageTimes> stages;
};

struct Runs {
  EngineRuns engine, other;
  std::vector<StageSeconds> classic;
};

// Of the samples at which only the engine found a gap, how many does the baseline find with steps of 0.01 mm?
void print_finer_steps(const CloudView& cloud, const Options& options, const std::vector<std::array<float, 3>>& samples,
                       const std::vector<baseline::SampleResult>& engine,
                       const std::vector<baseline::SampleResult>& classic, baseline::Settings settings) {
  std::vector<std::array<float, 3>> missed_samples;
  std::vector<baseline::SampleResult> missed;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool no_gap =
        classic[i].outcome == baseline::Outcome::kNoGap || classic[i].outcome == baseline::Outcome::kShellEmpty;
    if (!no_gap || engine[i].outcome != baseline::Outcome::kAffordance) continue;
    missed_samples.push_back(samples[i]);
    missed.push_back(engine[i]);
  }
  if (missed.empty()) return;
  settings.shell_step = 1e-5;
  const Agreement finer = compare(missed, baseline::localize(cloud, options, missed_samples, settings).samples);
  std::printf("  of %zu that the 1 mm steps passed over, steps of 0.01 mm find the same affordance at %zu\n",
              missed.size(), finer.same);
}

void print_agreement(const Agreement& a) {
  std::printf("curvature at the same nine points; of %zu samples %zu ended at the same step (%.2f %%)\n", a.samples,
              a.same_outcome,
              100.0 * static_cast<double>(a.same_outcome) / static_cast<double>(std::max<std::size_t>(1, a.samples)));
  std::printf("affordances by either: %zu; the same by both (axis 1 degree, center and radius 1 mm): %zu = %.2f %%\n",
              a.either, a.same, 100.0 * a.share());
  std::printf("of these with the same shell radius, but for the baseline's 1 mm step: %zu\n", a.same_shell);
  for (const auto& [reason, count] : a.reasons) std::printf("  %5zu  %s\n", count, reason.c_str());
  for (int row = 0; row < baseline::kOutcomes; ++row)
    for (int column = 0; column < baseline::kOutcomes; ++column) {
      const std::size_t count = a.outcomes[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
      const bool affordance = std::max(row, column) == static_cast<int>(baseline::Outcome::kAffordance);
      if (row == column || affordance || !count) continue;
      std::printf("  %5zu  no affordance: baseline says %s, engine %s\n", count,
                  std::string(to_string(static_cast<baseline::Outcome>(row))).c_str(),
                  std::string(to_string(static_cast<baseline::Outcome>(column))).c_str());
    }
}

// Prints the baseline's table; returns the milliseconds that count.
double print_classic(const std::vector<StageSeconds>& runs, int samples, bool published_applies) {
  const double scale = static_cast<double>(samples) / kPublishedSamples;
  std::printf("\nbaseline, 1 thread, ms        here   published%s    counts\n", published_applies ? "" : " (n/a)");
  double own = 0, counted = 0;
  for (const Stage& stage : stages()) {
    const double here = 1e3 * median_of(runs, stage.seconds);
    const double published = 1e3 * scale * stage.seconds(kPublished);
    const bool replaced = published_applies && here > kPublishedSlack * published;
    own += here;
    counted += replaced ? published : here;
    if (published_applies)
      std::printf("  %-22s %9.2f  %9.2f  %9.2f%s\n", stage.name, here, published, replaced ? published : here,
                  replaced ? "  (published: ours is over a quarter slower)" : "");
    else
      std::printf("  %-22s %9.2f          -  %9.2f\n", stage.name, here, here);
  }
  if (published_applies)
    std::printf("  %-22s %9.2f  %9.2f  %9.2f\n", "sum", own, 1e3 * scale * kPublished.total, counted);
  else
    std::printf("  %-22s %9.2f          -  %9.2f\n", "sum", own, counted);
  return counted;
}

void print_engine(const EngineRuns& runs, int threads) {
  std::printf("\nengine, %d thread%s (%s), ms\n", threads, threads > 1 ? "s" : "", Localizer::isa());
  const std::pair<const char*, double StageTimes::*> rows[] = {
      {"index", &StageTimes::index},     {"samples", &StageTimes::samples}, {"neighbours", &StageTimes::neighbours},
      {"moments", &StageTimes::moments}, {"fit", &StageTimes::fit},         {"shell", &StageTimes::shell},
      {"handles", &StageTimes::handles}, {"total", &StageTimes::total}};
  for (const auto& [name, field] : rows)
    std::printf("  %-22s %9.3f\n", name,
                median_of(runs.stages, [field = field](const StageTimes& t) { return t.*field; }));
  std::printf("  %-22s %9.3f\n", "wall clock of the call", median(runs.ms));
}

void compare_on(const std::string& path, int count, int repeat, int threads, baseline::Settings settings) {
  std::string name;
  const Cloud cloud = load_scene(path, &name);
  const std::vector<std::array<float, 3>> samples = draw_samples(cloud.view(), count);
  if (samples.empty()) throw std::runtime_error(name + ": no finite point to take samples from");

  Options options;
  options.method = Method::kPaper;
  options.samples = count;
  Options other = options;
  options.threads = threads;
  other.threads = threads == 1 ? 2 : 1;

  EngineRunner engine(options), other_engine(other);
  Result result;
  std::vector<Step> steps;
  const auto run_engine = [&](EngineRunner& runner, EngineRuns& runs) {
    runs.ms.push_back(milliseconds([&] { runner.run(cloud.view(), samples, result, steps); }));
    runs.stages.push_back(result.times_ms);
  };

  // What both find comes first: being fast at something else would mean nothing. This is the warm-up, too.
  Runs ignored;
  run_engine(other_engine, ignored.other);
  run_engine(engine, ignored.engine);
  baseline::Settings fixed = settings;
  fixed.curvature_points = baseline::CurvaturePoints::kFixed;
  const baseline::Result classic = baseline::localize(cloud.view(), options, samples, fixed);
  std::printf("%s: %zu points, %u x %u, %d samples, radius %.1f mm, baseline by %s\n", name.c_str(), cloud.size(),
              cloud.width, cloud.height, count, 1e3 * options.effective_radius().front(),
              settings.search == baseline::Search::kKdTree ? "pcl kd-tree" : "pcl organized search");
  const std::vector<baseline::SampleResult> found = by_sample(steps, result);
  print_agreement(compare(found, classic.samples));
  print_finer_steps(cloud.view(), options, samples, found, classic.samples, fixed);
  const baseline::Result random = baseline::localize(cloud.view(), options, samples, settings);
  const Agreement across = compare(found, random.samples);
  std::printf("with the median over fifty random points instead of these nine, as timed below: %zu of %zu the same\n",
              across.same, across.either);

  Runs runs;
  for (int i = 0; i < repeat; ++i) {
    runs.classic.push_back(baseline::localize(cloud.view(), options, samples, settings).seconds);
    // A camera sends one frame after the other; a single frame would find its threads asleep and the caches full of the
    // baseline's data.
    for (int frame = 0; frame < kFrames; ++frame) run_engine(engine, runs.engine);
    for (int frame = 0; frame < kFrames; ++frame) run_engine(other_engine, runs.other);
  }
  const bool published_applies = cloud.width == 640 && cloud.height == 480;
  double counted = print_classic(runs.classic, count, published_applies);
  const double wall = 1e3 * median_of(runs.classic, [](const StageSeconds& s) { return s.total; });
  std::printf("  %-22s %9.2f\n", "wall clock of the call", wall);
  print_engine(runs.engine, options.threads);
  print_engine(runs.other, other.threads);
  const double ms = median(runs.engine.ms), other_ms = median(runs.other.ms);
  counted = std::min(counted, wall);
  std::printf(
      "\nbaseline / engine (%d thread%s), medians of %d and %d: %.1f (%.2f ms / %.3f ms); with the baseline as "
      "measured "
      "%.1f\n",
      options.threads, options.threads > 1 ? "s" : "", repeat, repeat * kFrames, counted / ms, counted, ms, wall / ms);
  std::printf("engine with %d / with %d threads: %.2f (%.3f ms / %.3f ms)\n", options.threads, other.threads,
              ms / other_ms, ms, other_ms);
}

}  // namespace
}  // namespace handhold::bench

int main(int argc, char** argv) {
  CLI::App app{"Times the engine and the classic way on the same samples of a cloud, after checking that they agree"};
  std::string path;
  int samples = 20000, repeat = 15, threads = 1;
  std::string search = "kdtree";
  app.add_option("cloud", path, "PCD or PLY file; default: data/table_scene.pcd, or a synthetic frame");
  app.add_option("--samples", samples, "neighbourhoods")->check(CLI::Range(1, 10000000))->capture_default_str();
  app.add_option("--repeat", repeat, "timed runs of each")->check(CLI::Range(1, 100000))->capture_default_str();
  app.add_option("--threads", threads, "threads of the engine; 2 (or 1) are timed beside them")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--search", search, "the baseline's neighbours")->check(CLI::IsMember({"kdtree", "organized"}));
  CLI11_PARSE(app, argc, argv);
  try {
    handhold::bench::compare_on(
        path, samples, repeat, threads,
        {search == "kdtree" ? handhold::baseline::Search::kKdTree : handhold::baseline::Search::kOrganized});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handhold_compare: %s\n", error.what());
    return 1;
  }
}
