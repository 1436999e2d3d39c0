// Whole frames: from a cloud to handles, index included. Names: frame/strategy/samples/threads. The counters are the
// shares of the stages in the time of a frame, and what was found.
//
// HANDHOLD_BENCH_CLOUD names the cloud; without it data/table_scene.pcd or a synthetic one.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <exception>
#include <string>

#include "handhold/localizer.h"
#include "scene.h"

namespace handhold::bench {
namespace {

void run_frame(benchmark::State& state, const Cloud& cloud, const Options& options) {
  Localizer localizer(options);
  Result result;
  localizer.localize(cloud.view(), result);  // scratch memory grows to its size
  if (result.status != Status::kOk) return state.SkipWithError(std::string(to_string(result.status)).c_str());
  StageTimes sum{};
  for (auto _ : state) {
    localizer.localize(cloud.view(), result);
    sum.index += result.times_ms.index;
    sum.samples += result.times_ms.samples;
    sum.neighbours += result.times_ms.neighbours;
    sum.moments += result.times_ms.moments;
    sum.fit += result.times_ms.fit;
    sum.shell += result.times_ms.shell;
    sum.visibility += result.times_ms.visibility;
    sum.handles += result.times_ms.handles;
    sum.total += result.times_ms.total;
  }
  state.counters["index"] = sum.index / sum.total;
  state.counters["samples"] = sum.samples / sum.total;
  state.counters["neighbours"] = sum.neighbours / sum.total;
  state.counters["moments"] = sum.moments / sum.total;
  state.counters["fit"] = sum.fit / sum.total;
  state.counters["shell"] = sum.shell / sum.total;
  state.counters["visibility"] = sum.visibility / sum.total;
  state.counters["handles"] = sum.handles / sum.total;
  state.counters["affordances"] = static_cast<double>(result.affordances.size());
}

void register_all(const Cloud& cloud) {
  for (const Method method : {Method::kPaper, Method::kDefault})
    for (const Strategy strategy : {Strategy::kUniform, Strategy::kMax})
      for (const int samples : {2000, 5000, 20000})
        for (const int threads : {1, 2}) {
          Options options;
          options.method = method;
          options.strategy = strategy;
          options.samples = samples;
          options.threads = threads;
          const std::string name = "frame/" + std::string(to_string(method)) + "/" + std::string(to_string(strategy)) +
                                   "/samples:" + std::to_string(samples) + "/threads:" + std::to_string(threads);
          benchmark::RegisterBenchmark(name.c_str(),
                                       [&cloud, options](benchmark::State& state) { run_frame(state, cloud, options); })
              ->UseRealTime()
              ->Unit(benchmark::kMillisecond);
        }
}

}  // namespace
}  // namespace handhold::bench

int main(int argc, char** argv) try {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  std::string name;
  const handhold::Cloud cloud = handhold::bench::load_scene("", &name);
  benchmark::AddCustomContext("cloud", name + ", " + std::to_string(cloud.size()) + " points");
  benchmark::AddCustomContext("isa", handhold::Localizer::isa());
  handhold::bench::register_all(cloud);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
} catch (const std::exception& error) {
  std::fprintf(stderr, "frame_bench: %s\n", error.what());
  return 1;
}
