// Fig. 8 of the paper: where the time of a frame goes.
#include <tbb/global_control.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "common.h"
#include "experiments.h"
#include "handhold/io.h"
#include "handhold/localizer.h"
#include "handhold/random_scene.h"
#include "progress.h"
#include "run_times.h"
#include "shots.h"
#include "statistics.h"
#include "text.h"
#include "threads.h"
#include "usage_error.h"

namespace handhold::experiments {
namespace {

using evaluation::format;

struct Arguments {
  std::string cloud, samples, strategy, method;
  CommonArguments common;
};

/// Mean and standard deviation of every stage over the runs (ms).
struct Times {
  int threads = 1;
  StageTimes mean_ms, std_ms;
};

Times measure(const CloudView& cloud, Options options, int threads, int runs, const std::string& name,
              Progress& progress) {
  const auto more_threads = allow_threads(threads);
  options.threads = threads;
  Localizer localizer(options);
  Result result;
  progress.show("warming up");
  localizer.localize(cloud, result);
  if (result.status != Status::kOk) {
    throw std::runtime_error("'" + name + "' cannot be searched: " + std::string(to_string(result.status)) +
                             "; give a cloud in which 'handhold localize' finds something");
  }
  std::vector<StageTimes> all;
  for (int i = 0; i < runs; ++i) {
    progress.show(format("%d %s, run %d of %d", threads, threads == 1 ? "thread" : "threads", i + 1, runs));
    localizer.localize(cloud, result);
    all.push_back(result.times_ms);
  }
  Times times;
  times.threads = threads;
  for (const auto& [stage, time] : kStages) {
    std::vector<double> values;
    for (const StageTimes& t : all) values.push_back(t.*time);
    times.mean_ms.*time = mean(values);
    times.std_ms.*time = standard_deviation(values);
  }
  return times;
}

Json stages_json(const StageTimes& times) {
  Json json = Json::object();
  for (const auto& [name, stage] : kStages) {
    if (stage != &StageTimes::total) json[name] = times.*stage;
  }
  return json;
}

Json times_json(const Times& times) {
  return {{"threads", times.threads},
          {"total_ms", times.mean_ms.total},
          {"total_std_ms", times.std_ms.total},
          {"stages_ms", stages_json(times.mean_ms)},
          {"stages_std_ms", stages_json(times.std_ms)}};
}

Report report(const std::string& name, const Cloud& cloud, const Options& options, int runs,
              const std::vector<Times>& all) {
  const std::size_t finite = finite_points(cloud);
  Report r;
  const std::string method(to_string(options.method)), strategy(to_string(options.strategy));
  r.text =
      format("%s: %zu points, %zu finite; method %s, %d samples, %s; %s kernels\nmean of %d runs (ms)", name.c_str(),
             cloud.size(), finite, method.c_str(), options.samples, strategy.c_str(), Localizer::isa(), runs);
  for (const Times& t : all) r.text += format("  %6d %-7s  std ", t.threads, t.threads == 1 ? "thread" : "threads");
  r.text += "\n";
  for (const auto& [stage, time] : kStages) {
    r.text += format("%-20s ", stage);
    for (const Times& t : all) r.text += format("  %12.2f  %6.2f", t.mean_ms.*time, t.std_ms.*time);
    r.text += "\n";
  }

  r.csv = "threads,stage,mean_ms,std_ms\n";
  for (const Times& t : all) {
    for (const auto& [stage, time] : kStages) {
      r.csv += format("%d,%s,%.4f,%.4f\n", t.threads, stage, t.mean_ms.*time, t.std_ms.*time);
    }
  }

  // What stands at the top is the paper's figure: one thread.
  r.json = {{"experiment", "fig8"},       {"cloud", name},    {"points", cloud.size()},
            {"finite", finite},           {"method", method}, {"strategy", strategy},
            {"samples", options.samples}, {"runs", runs},     {"isa", Localizer::isa()}};
  r.json.update(times_json(all.front()));
  r.json["by_threads"] = Json::array();
  for (const Times& t : all) r.json["by_threads"].push_back(times_json(t));

  PlotPanel panel;
  panel.title = format("%d samples, method %s", options.samples, method.c_str());
  panel.y_label = "ms";
  constexpr Color kColors[] = {{0.00f, 0.45f, 0.70f}, {0.90f, 0.60f, 0.00f}};
  for (std::size_t i = 0; i < all.size(); ++i) {
    panel.series.push_back(
        {format("%d %s", all[i].threads, all[i].threads == 1 ? "thread" : "threads"), kColors[i % 2], {}, {}, {}});
  }
  for (const auto& [stage, time] : kStages) {
    panel.groups.push_back(std::string(stage).substr(0, 6));
    for (std::size_t i = 0; i < all.size(); ++i) {
      panel.series[i].y.push_back(all[i].mean_ms.*time);
      panel.series[i].error.push_back(all[i].std_ms.*time);
    }
  }
  r.panels = {panel};
  return r;
}

int run(const Arguments& a) {
  Options options;
  options.method = Method::kPaper;
  options.strategy = Strategy::kUniform;  // Algorithm 1
  set_name("--method", a.method, options.method);
  set_name("--strategy", a.strategy, options.strategy);
  options.samples = a.samples.empty() ? 20'000 : static_cast<int>(whole_number("--samples", a.samples, 1, 10'000'000));
  options.seed = seed_of(a.common);
  const int runs = runs_of(a.common, 10), threads = threads_of(a.common);
  const Outputs outputs(a.common, "fig8");

  std::string name = a.cloud;
  Cloud cloud;
  std::vector<Times> all;
  {
    Progress progress;
    if (a.cloud.empty()) {
      progress.show("taking a scene");
      Shot shot = shoot(sensor::paper_scenes().front());
      name = shot.name;
      cloud = std::move(shot.cloud);
    } else {
      progress.show("reading " + a.cloud);
      cloud = read_cloud(a.cloud);
    }
    const int most =
        threads > 0 ? threads
                    : static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
    all.push_back(measure(cloud.view(), options, 1, runs, name, progress));
    if (most > 1) all.push_back(measure(cloud.view(), options, most, runs, name, progress));
  }
  outputs.write(report(name, cloud, options, runs, all));
  return 0;
}

}  // namespace

Subcommand add_fig8(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("fig8", "Run time by stage, on one thread and on all (Fig. 8)");
  app->allow_extras();
  auto a = std::make_shared<Arguments>();
  app->add_option("CLOUD", a->cloud, "Point cloud, .pcd or .ply (m) [the first scene of 'simulate --set paper']")
      ->option_text(" ");
  const char* what = "What is measured";
  add_text_flag(*app, "--samples", a->samples, "N", "Neighbourhoods to look at [20000]", what);
  add_text_flag(*app, "--strategy", a->strategy, "NAME", "uniform, sum or max [uniform]", what);
  add_method_flag(*app, a->method, "paper");
  add_common_flags(*app, a->common, "Runs after a warm-up, with the same seed [10]");
  return {app, [a] { return run(*a); }};
}

}  // namespace handhold::experiments
