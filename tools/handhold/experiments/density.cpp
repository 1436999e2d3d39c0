// What is still found when there are fewer points on things: clouds with points taken out, and things farther away.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "common.h"
#include "experiments.h"
#include "handhold/localizer.h"
#include "handhold/random_scene.h"
#include "progress.h"
#include "random.h"
#include "scene_choice.h"
#include "shots.h"
#include "text.h"
#include "threads.h"

namespace handhold::experiments {
namespace {

using evaluation::format;

struct Arguments {
  std::string random, families, singles, shares, distances, samples, method;
  CommonArguments common;
};

/// One point of a curve.
struct Outcome {
  double at = 0;  ///< share of the points kept, or distance (m)
  std::size_t scenes = 0;
  double points = 0;  ///< measured ones of a cloud, in the mean
  Counts counts;      ///< over scenes and runs
};

/// A random share of the points is left, the others become NaN. What a smaller share leaves, a larger one leaves, too.
Cloud thinned(Cloud cloud, double share, std::uint64_t seed, std::uint64_t scene) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (CounterRandom(seed, scene, i).uniform() < share) continue;
    std::fill_n(&cloud.xyz[3 * i], 3, std::numeric_limits<float>::quiet_NaN());
  }
  return cloud;
}

/// Searches every cloud `runs` times.
Outcome measure(const std::vector<Shot>& shots, double at, Options options, int runs) {
  Outcome outcome;
  outcome.at = at;
  outcome.scenes = shots.size();
  std::vector<Counts> counts(shots.size());
  const std::uint64_t seed = options.seed;
  tbb::parallel_for(std::size_t{0}, shots.size(), [&](std::size_t i) {
    Options own = options;
    for (int k = 0; k < runs; ++k) {
      own.seed = seed + static_cast<std::uint64_t>(k);
      counts[i] += judge(shots[i], Localizer(own).localize(shots[i].cloud.view()));
    }
  });
  for (const Counts& c : counts) outcome.counts += c;
  for (const Shot& shot : shots) {
    outcome.points += static_cast<double>(finite_points(shot.cloud)) / static_cast<double>(shots.size());
  }
  return outcome;
}

std::vector<Outcome> measure_shares(std::vector<Shot> shots, const std::vector<double>& shares, const Options& options,
                                    int runs, Progress& progress) {
  std::vector<Outcome> outcomes;
  for (const double share : shares) {
    progress.show(format("%g of the points", share));
    std::vector<Shot> thin = shots;
    tbb::parallel_for(std::size_t{0}, thin.size(), [&](std::size_t i) {
      thin[i].cloud = thinned(std::move(thin[i].cloud), share, options.seed, i);
    });
    outcomes.push_back(measure(thin, share, options, runs));
  }
  return outcomes;
}

/// Objects alone, spread evenly over the set: the camera looks at each from that far, in the direction from which the
/// set's camera looks.
std::vector<sensor::SceneFile> singles_from(double distance, std::size_t count) {
  const std::vector<sensor::SceneFile> all = sensor::single_object_scenes();
  std::vector<sensor::SceneFile> scenes;
  for (std::size_t i = 0; i < count; ++i) {
    sensor::SceneFile scene = all[i * all.size() / count];
    Vector3 target = scene.objects.back().T_world_object.t;
    target[2] = 0.05;
    const Vector3 back = scene.T_world_camera.direction({0, 0, -1});
    const Vector3 eye = {target[0] + distance * back[0], target[1] + distance * back[1],
                         target[2] + distance * back[2]};
    scene.T_world_camera = sensor::look_at(eye, target);
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

std::string table(const char* title, const std::vector<Outcome>& outcomes) {
  std::string text =
      format("%-22s %7s %8s  recall  found/needed  precision  right/handles\n", title, "scenes", "points");
  for (const Outcome& o : outcomes) {
    text +=
        format("%-22g %7zu %8.0f  %6.3f  %5zu/%-6zu  %9.3f  %5zu/%zu\n", o.at, o.scenes, o.points, o.counts.recall(),
               o.counts.found, o.counts.needed, o.counts.precision(), o.counts.right, o.counts.handles);
  }
  return text;
}

std::string csv_lines(const char* curve, const std::vector<Outcome>& outcomes) {
  std::string text;
  for (const Outcome& o : outcomes) {
    text += format("%s,%g,%zu,%.1f,%zu,%zu,%.4f,%zu,%zu,%.4f\n", curve, o.at, o.scenes, o.points, o.counts.needed,
                   o.counts.found, o.counts.recall(), o.counts.handles, o.counts.right, o.counts.precision());
  }
  return text;
}

Json curve_json(const char* at, const std::vector<Outcome>& outcomes) {
  Json json = Json::array();
  for (const Outcome& o : outcomes) {
    json.push_back({{at, o.at},
                    {"scenes", o.scenes},
                    {"points", o.points},
                    {"needed", o.counts.needed},
                    {"found", o.counts.found},
                    {"recall", o.counts.recall()},
                    {"handles", o.counts.handles},
                    {"right", o.counts.right},
                    {"precision", o.counts.precision()}});
  }
  return json;
}

PlotPanel panel_of(const char* title, const char* x_label, const std::vector<Outcome>& outcomes) {
  PlotPanel panel;
  panel.title = title;
  panel.x_label = x_label;
  panel.y_label = "share";
  panel.highest = 1;
  panel.series = {{"recall", {0.00f, 0.45f, 0.70f}, {}, {}, {}}, {"precision", {0.84f, 0.37f, 0.00f}, {}, {}, {}}};
  std::vector<Outcome> sorted = outcomes;
  std::sort(sorted.begin(), sorted.end(), [](const Outcome& a, const Outcome& b) { return a.at < b.at; });
  for (const Outcome& o : sorted) {
    for (PlotSeries& series : panel.series) series.x.push_back(o.at);
    panel.series[0].y.push_back(o.counts.needed ? o.counts.recall() : std::nan(""));
    panel.series[1].y.push_back(o.counts.handles ? o.counts.precision() : std::nan(""));
  }
  return panel;
}

std::vector<sensor::SceneFile> random_scenes(std::uint64_t count, std::uint64_t seed, const std::string& families,
                                             Progress& progress) {
  const sensor::RandomSceneOptions options = families_named(families);
  std::vector<sensor::SceneFile> scenes;
  for (std::uint64_t i = 0; i < count; ++i) {
    progress.show("making scene " + std::to_string(i + 1) + " of " + std::to_string(count));
    scenes.push_back(sensor::random_scene(seed + i, options));
  }
  return scenes;
}

int run(const Arguments& a) {
  Options options;
  set_name("--method", a.method, options.method);
  if (!a.samples.empty()) options.samples = static_cast<int>(whole_number("--samples", a.samples, 1, 10'000'000));
  options.seed = seed_of(a.common);
  const auto shares =
      a.shares.empty() ? std::vector<double>{1, 0.5, 0.25} : numbers("--shares", a.shares, 0.001, 1, "");
  const auto distances =
      a.distances.empty() ? std::vector<double>{0.5, 0.7, 0.9, 1.2} : numbers("--distances", a.distances, 0.3, 5, "m");
  const std::uint64_t count = a.random.empty() ? 30 : whole_number("--random", a.random, 1, 100'000);
  const std::size_t singles = a.singles.empty() ? 48 : whole_number("--singles", a.singles, 1, 144);
  const int runs = runs_of(a.common, 1), threads = threads_of(a.common);
  families_named(a.families);
  const Outputs outputs(a.common, "density");

  std::vector<Outcome> by_share, by_distance;
  {
    Progress progress;
    with_threads(threads, [&] {
      by_share = measure_shares(shoot(random_scenes(count, options.seed, a.families, progress), progress), shares,
                                options, runs, progress);
      for (const double distance : distances) {
        const std::vector<Shot> shots = shoot(singles_from(distance, singles), progress);
        progress.show(format("objects alone at %g m", distance));
        by_distance.push_back(measure(shots, distance, options, runs));
      }
    });
  }

  const std::string method(to_string(options.method)), families = a.families.empty() ? "all" : a.families;
  Report report;
  report.text = format("method %s, %d samples, runs of each cloud: %d\n", method.c_str(), options.samples, runs) +
                table("share of points kept", by_share) + table("distance (m)", by_distance);
  report.csv = "curve,at,scenes,points,needed,found,recall,handles,right,precision\n" + csv_lines("share", by_share) +
               csv_lines("distance_m", by_distance);
  report.json = {{"experiment", "density"},
                 {"method", method},
                 {"samples", options.samples},
                 {"runs", runs},
                 {"seed", options.seed},
                 {"families", families},
                 {"thinned", curve_json("share", by_share)},
                 {"distances", curve_json("distance_m", by_distance)}};
  report.panels = {panel_of("Random scenes, points taken out", "share of the points kept", by_share),
                   panel_of("Objects alone", "distance (m)", by_distance)};
  outputs.write(report);
  return 0;
}

}  // namespace

Subcommand add_density(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("density", "Recall and precision with fewer points, and from farther away");
  app->allow_extras();
  auto a = std::make_shared<Arguments>();
  const char* what = "What is measured";
  add_text_flag(*app, "--random", a->random, "N", "Random scenes to thin; the first has the seed S [30]", what);
  add_text_flag(*app, "--families", a->families, "LIST", "Of random scenes: all, tuning, report, or names [all]", what);
  add_text_flag(*app, "--shares", a->shares, "LIST", "Shares of the points that are kept, 0.001 to 1 [1,0.5,0.25]",
                what);
  add_text_flag(*app, "--singles", a->singles, "N", "Objects alone, of the 144 of 'simulate --set singles' [48]", what);
  add_text_flag(*app, "--distances", a->distances, "LIST", "From the camera to these objects (m) [0.5,0.7,0.9,1.2]",
                what);
  add_text_flag(*app, "--samples", a->samples, "N", "Neighbourhoods to look at [5000]", what);
  add_method_flag(*app, a->method, "default");
  add_common_flags(*app, a->common, "Runs of each cloud, with seeds S, S + 1, ... [1]");
  return {app, [a] { return run(*a); }};
}

}  // namespace handhold::experiments
