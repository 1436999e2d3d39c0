// Fig. 9 of the paper: how many of the handles that are there each sampling strategy finds.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>

#include "common.h"
#include "experiments.h"
#include "handhold/localizer.h"
#include "handhold/random_scene.h"
#include "progress.h"
#include "shots.h"
#include "statistics.h"
#include "text.h"
#include "threads.h"
#include "usage_error.h"

namespace handhold::experiments {
namespace {

using evaluation::format;

struct Arguments {
  std::string samples, uniform_samples, scenes, method;
  CommonArguments common;
};

/// One bar of the figure.
struct Setting {
  Strategy strategy;
  int samples;
};

struct Outcome {
  Setting setting;
  double mean = 0, std = 0;  ///< needed parts found, over the runs
  double false_mean = 0;     ///< handles on no listed part, or on one already found
  int all_found_runs = 0;    ///< runs that found every needed part
};

struct SceneOutcomes {
  std::string name;
  std::size_t handles = 0;  ///< that are there
  std::vector<Outcome> outcomes;
};

Outcome measure(const Shot& shot, const Setting& setting, Options options, std::uint64_t seed, int runs) {
  options.strategy = setting.strategy;
  options.samples = setting.samples;
  std::vector<Counts> counts(static_cast<std::size_t>(runs));
  tbb::parallel_for(std::size_t{0}, counts.size(), [&](std::size_t i) {
    Options own = options;
    own.seed = seed + i;
    counts[i] = judge(shot, Localizer(own).localize(shot.cloud.view()));
  });
  std::vector<double> found, wrong;
  Outcome outcome;
  outcome.setting = setting;
  for (const Counts& c : counts) {
    found.push_back(static_cast<double>(c.found));
    wrong.push_back(static_cast<double>(c.handles - c.right));
    outcome.all_found_runs += c.found == c.needed;
  }
  outcome.mean = mean(found);
  outcome.std = standard_deviation(found);
  outcome.false_mean = mean(wrong);
  return outcome;
}

std::string name_of(const Setting& setting) {
  return std::string(to_string(setting.strategy)) + " " + std::to_string(setting.samples);
}

std::vector<PlotPanel> panels_of(const std::vector<SceneOutcomes>& scenes) {
  std::vector<PlotPanel> panels;
  std::vector<int> samples;
  for (const Outcome& o : scenes.front().outcomes) {
    if (samples.empty() || samples.back() != o.setting.samples) samples.push_back(o.setting.samples);
  }
  double highest = 0;
  for (const SceneOutcomes& scene : scenes) highest = std::max(highest, 1.15 * static_cast<double>(scene.handles));
  for (const int n : samples) {
    PlotPanel panel;
    panel.title = format("%d samples", n);
    panel.x_label = "scene";
    panel.y_label = "handles found";
    panel.highest = std::max(1.0, highest);
    panel.marks_name = "there";
    for (const SceneOutcomes& scene : scenes) {
      panel.groups.push_back(scene.name.substr(scene.name.find('_') + 1));
      panel.marks.push_back(static_cast<double>(scene.handles));
    }
    for (std::size_t k = 0; k < scenes.front().outcomes.size(); ++k) {
      const Setting& setting = scenes.front().outcomes[k].setting;
      if (setting.samples != n) continue;
      PlotSeries series;
      series.name =
          std::string(setting.strategy == Strategy::kUniform ? "" : "g_") + std::string(to_string(setting.strategy));
      series.color = setting.strategy == Strategy::kUniform ? Color{0.00f, 0.45f, 0.70f}
                     : setting.strategy == Strategy::kSum   ? Color{0.90f, 0.60f, 0.00f}
                                                            : Color{0.00f, 0.62f, 0.45f};
      for (const SceneOutcomes& scene : scenes) {
        series.y.push_back(scene.outcomes[k].mean);
        series.error.push_back(scene.outcomes[k].std);
      }
      panel.series.push_back(series);
    }
    panels.push_back(panel);
  }
  return panels;
}

Report report(const std::vector<SceneOutcomes>& scenes, Method method, std::uint64_t seed, int runs) {
  Report r;
  const std::vector<Outcome>& settings = scenes.front().outcomes;
  r.text = format("handles found, mean and standard deviation of %d runs; method %s\n%-10s %5s", runs,
                  std::string(to_string(method)).c_str(), "scene", "there");
  for (const Outcome& o : settings) r.text += format("  %14s", name_of(o.setting).c_str());
  r.text += "\n";
  std::vector<double> sums(settings.size());
  std::size_t there = 0;
  r.csv = "scene,handles,strategy,samples,runs,mean,std,all_found_runs,false_mean\n";
  r.json = {{"experiment", "fig9"}, {"method", std::string(to_string(method))}, {"runs", runs}, {"seed", seed}};
  r.json["scenes"] = Json::array();
  for (const SceneOutcomes& scene : scenes) {
    there += scene.handles;
    r.text += format("%-10s %5zu", scene.name.c_str(), scene.handles);
    Json results = Json::array();
    for (std::size_t k = 0; k < scene.outcomes.size(); ++k) {
      const Outcome& o = scene.outcomes[k];
      const std::string strategy(to_string(o.setting.strategy));
      sums[k] += o.mean;
      r.text += format("  %7.2f +-%5.2f", o.mean, o.std);
      r.csv += format("%s,%zu,%s,%d,%d,%.4f,%.4f,%d,%.4f\n", scene.name.c_str(), scene.handles, strategy.c_str(),
                      o.setting.samples, runs, o.mean, o.std, o.all_found_runs, o.false_mean);
      results.push_back({{"strategy", strategy},
                         {"samples", o.setting.samples},
                         {"runs", runs},
                         {"mean", o.mean},
                         {"std", o.std},
                         {"all_found_runs", o.all_found_runs},
                         {"false_mean", o.false_mean}});
    }
    r.text += "\n";
    r.json["scenes"].push_back({{"name", scene.name}, {"handles", scene.handles}, {"results", results}});
  }
  r.text += format("%-10s %5zu", "together", there);
  for (const double sum : sums) r.text += format("  %7.2f        ", sum);
  while (r.text.back() == ' ') r.text.pop_back();
  r.text += "\n";
  r.panels = panels_of(scenes);
  return r;
}

/// By number of samples, as the panels of the figure; uniform sampling alone where the others are not asked for.
std::vector<Setting> settings_of(const Arguments& a) {
  const auto samples =
      a.samples.empty() ? std::vector<int>{2000, 5000} : whole_numbers("--samples", a.samples, 1, 10'000'000);
  const int uniform = a.uniform_samples.empty()
                          ? 20'000
                          : static_cast<int>(whole_number("--uniform-samples", a.uniform_samples, 0, 10'000'000));
  std::vector<Setting> settings;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::count(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(i), samples[i])) {
      throw UsageError("--samples = '" + a.samples + "': each number once");
    }
    for (const Strategy strategy : {Strategy::kUniform, Strategy::kSum, Strategy::kMax}) {
      settings.push_back({strategy, samples[i]});
    }
  }
  const bool new_one = std::find(samples.begin(), samples.end(), uniform) == samples.end();
  if (uniform > 0 && new_one) settings.push_back({Strategy::kUniform, uniform});
  return settings;
}

std::vector<sensor::SceneFile> scenes_of(const Arguments& a) {
  const std::vector<sensor::SceneFile> all = sensor::paper_scenes();
  if (a.scenes.empty()) return all;
  std::vector<sensor::SceneFile> scenes;
  for (const int number : whole_numbers("--scenes", a.scenes, 1, static_cast<int>(all.size()))) {
    scenes.push_back(all[static_cast<std::size_t>(number - 1)]);
  }
  return scenes;
}

int run(const Arguments& a) {
  Options options;
  set_name("--method", a.method, options.method);
  const std::vector<Setting> settings = settings_of(a);
  const std::vector<sensor::SceneFile> files = scenes_of(a);
  const std::uint64_t seed = seed_of(a.common);
  const int runs = runs_of(a.common, 20), threads = threads_of(a.common);
  const Outputs outputs(a.common, "fig9");

  std::vector<SceneOutcomes> scenes;
  {
    Progress progress;
    with_threads(threads, [&] {
      const std::vector<Shot> shots = shoot(files, progress);
      for (const Shot& shot : shots) {
        SceneOutcomes scene;
        scene.name = shot.name;
        scene.handles = shot.needed();
        for (const Setting& setting : settings) {
          progress.show(shot.name + ": " + name_of(setting) + " samples");
          scene.outcomes.push_back(measure(shot, setting, options, seed, runs));
        }
        scenes.push_back(scene);
      }
    });
  }
  outputs.write(report(scenes, options.method, seed, runs));
  return 0;
}

}  // namespace

Subcommand add_fig9(CLI::App& parent) {
  CLI::App* app =
      parent.add_subcommand("fig9", "Handles found in the seven paper scenes by sampling strategy (Fig. 9)");
  app->allow_extras();
  auto a = std::make_shared<Arguments>();
  const char* what = "What is measured";
  add_text_flag(*app, "--samples", a->samples, "LIST", "Neighbourhoods for uniform, sum and max [2000,5000]", what);
  add_text_flag(*app, "--uniform-samples", a->uniform_samples, "N", "The same for uniform alone; 0: not [20000]", what);
  add_text_flag(*app, "--scenes", a->scenes, "LIST", "Numbers of the scenes [1,2,3,4,5,6,7]", what);
  add_method_flag(*app, a->method, "default");
  add_common_flags(*app, a->common, "Runs of each, with seeds S, S + 1, ... [20]");
  return {app, [a] { return run(*a); }};
}

}  // namespace handhold::experiments
