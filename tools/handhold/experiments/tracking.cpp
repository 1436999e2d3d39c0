// What a tracker is worth: a camera moves around scenes, and each frame is searched with few samples.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <mutex>

#include "common.h"
#include "experiments.h"
#include "handhold/localizer.h"
#include "handhold/random_scene.h"
#include "handhold/tracker.h"
#include "progress.h"
#include "scene_choice.h"
#include "shots.h"
#include "text.h"
#include "threads.h"

namespace handhold::experiments {
namespace {

using evaluation::format;

struct Arguments {
  std::string random, families, frames, sweep, samples, few;
  CommonArguments common;
};

/// A track is a handle of the frame when it was seen in two frames at least, and in this one or so many before.
constexpr int kShown = 3, kSeen = 2;
/// Frames at the beginning that do not count: a tracker knows nothing yet.
constexpr int kFirst = 5;

/// The scene as the camera sees it from a place on a circle about what it looks at: frame i of n on an arc of `sweep`.
sensor::SceneFile from_arc(const sensor::SceneFile& scene, int i, int n, double sweep) {
  sensor::SceneFile file = scene;
  const sensor::Pose& camera = scene.T_world_camera;
  const Vector3 forward = camera.direction({0, 0, 1});
  // Where it looks at the table.
  const double far = forward[2] < -0.1 ? (camera.t[2] - 0.05) / -forward[2] : 0.8;
  Vector3 target{};
  for (std::size_t k = 0; k < 3; ++k) target[k] = camera.t[k] + far * forward[k];
  const double angle = sweep * ((i + 0.5) / n - 0.5);
  const sensor::Pose turn = sensor::translation(target[0], target[1], target[2]) * sensor::rotation({0, 0, 1}, angle) *
                            sensor::translation(-target[0], -target[1], -target[2]);
  file.T_world_camera = turn * camera;
  file.camera.seed = scene.camera.seed + static_cast<std::uint64_t>(i);
  return file;
}

Motion motion(const sensor::Pose& T_world_last, const sensor::Pose& T_world_now) {
  const sensor::Pose T_now_last = T_world_now.inverse() * T_world_last;
  return {T_now_last.R, T_now_last.t};
}

/// The ways that are compared.
struct Way {
  const char* name;
  int samples;
  bool tracked;
};

/// One scene, all frames, all ways. The clouds of one frame are in memory at a time.
std::vector<Counts> follow(const sensor::SceneFile& scene, const std::vector<Way>& ways, const Options& options,
                           int frames, double sweep) {
  std::vector<Counts> counts(ways.size());
  std::vector<Localizer> localizers;
  for (const Way& way : ways) {
    Options own = options;
    own.samples = way.samples;
    own.threads = 1;
    localizers.emplace_back(own);
  }
  std::vector<Tracker> trackers(ways.size());
  std::vector<Vector3> guesses;
  Result result;
  sensor::Pose last;
  for (int i = 0; i < frames; ++i) {
    const sensor::SceneFile file = from_arc(scene, i, frames, sweep);
    const Shot shot = shoot(file);
    const Motion moved = i > 0 ? motion(last, file.T_world_camera) : Motion();
    last = file.T_world_camera;
    for (std::size_t w = 0; w < ways.size(); ++w) {
      if (!ways[w].tracked) {
        localizers[w].localize(shot.cloud.view(), result);
      } else {
        trackers[w].guesses(guesses, moved);
        localizers[w].localize(shot.cloud.view(), result, guesses);
        trackers[w].update(result.handles, moved);
        result.handles.clear();
        for (const Track& track : trackers[w].tracks()) {
          if (track.unseen <= kShown && track.age >= kSeen) result.handles.push_back(track.handle);
        }
        std::stable_sort(result.handles.begin(), result.handles.end(),
                         [](const Handle& a, const Handle& b) { return a.confidence > b.confidence; });
      }
      if (i >= kFirst) counts[w] += judge(shot, result);
    }
  }
  return counts;
}

int run(const Arguments& a) {
  Options options;
  options.seed = seed_of(a.common);
  const int many = a.samples.empty() ? 5000 : static_cast<int>(whole_number("--samples", a.samples, 1, 10'000'000));
  const int few = a.few.empty() ? 1000 : static_cast<int>(whole_number("--few", a.few, 1, 10'000'000));
  const std::uint64_t count = a.random.empty() ? 10 : whole_number("--random", a.random, 1, 100'000);
  const int frames = a.frames.empty() ? 30 : static_cast<int>(whole_number("--frames", a.frames, kFirst + 1, 100'000));
  const double sweep = a.sweep.empty() ? 0.5 : numbers("--sweep", a.sweep, 0, 6.3, "rad").front();
  const int runs = runs_of(a.common, 1), threads = threads_of(a.common);
  const sensor::RandomSceneOptions families = families_named(a.families);
  const Outputs outputs(a.common, "tracking");

  const std::vector<Way> ways = {
      {"each frame for itself", many, false}, {"each frame for itself", few, false}, {"tracked", few, true}};
  std::vector<std::vector<Counts>> by_scene(count);
  {
    Progress progress;
    std::mutex mutex;
    std::size_t done = 0;
    with_threads(threads, [&] {
      tbb::parallel_for(std::size_t{0}, static_cast<std::size_t>(count), [&](std::size_t i) {
        by_scene[i].resize(ways.size());
        for (int k = 0; k < runs; ++k) {
          Options own = options;
          own.seed += static_cast<std::uint64_t>(k);
          const std::vector<Counts> one =
              follow(sensor::random_scene(options.seed + i, families), ways, own, frames, sweep);
          for (std::size_t w = 0; w < ways.size(); ++w) by_scene[i][w] += one[w];
        }
        const std::lock_guard<std::mutex> lock(mutex);
        progress.show(format("scene %zu of %zu", ++done, static_cast<std::size_t>(count)));
      });
    });
  }
  std::vector<Counts> counts(ways.size());
  for (const std::vector<Counts>& scene : by_scene) {
    for (std::size_t w = 0; w < ways.size(); ++w) counts[w] += scene[w];
  }

  Report report;
  report.text = format(
      "%zu scenes, %d frames each from an arc of %g rad; parts and handles of all frames from the %dth on\n"
      "%-22s %8s  recall  found/needed  precision  right/handles\n",
      static_cast<std::size_t>(count), frames, sweep, kFirst + 1, "", "samples");
  report.csv = "way,samples,needed,found,recall,handles,right,precision\n";
  report.json = {{"experiment", "tracking"}, {"scenes", count},      {"frames", frames},
                 {"sweep_rad", sweep},       {"seed", options.seed}, {"ways", Json::array()}};
  PlotPanel panel;
  panel.title = "A moving camera";
  panel.y_label = "share";
  panel.highest = 1;
  panel.series = {{"recall", {0.00f, 0.45f, 0.70f}, {}, {}, {}}, {"precision", {0.84f, 0.37f, 0.00f}, {}, {}, {}}};
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const Counts& c = counts[w];
    report.text += format("%-22s %8d  %6.3f  %5zu/%-6zu  %9.3f  %5zu/%zu\n", ways[w].name, ways[w].samples, c.recall(),
                          c.found, c.needed, c.precision(), c.right, c.handles);
    report.csv += format("%s,%d,%zu,%zu,%.4f,%zu,%zu,%.4f\n", ways[w].name, ways[w].samples, c.needed, c.found,
                         c.recall(), c.handles, c.right, c.precision());
    report.json["ways"].push_back({{"way", ways[w].name},
                                   {"samples", ways[w].samples},
                                   {"tracked", ways[w].tracked},
                                   {"needed", c.needed},
                                   {"found", c.found},
                                   {"recall", c.recall()},
                                   {"handles", c.handles},
                                   {"right", c.right},
                                   {"precision", c.precision()}});
    panel.groups.push_back(format("%s %d", ways[w].tracked ? "tracked," : "alone,", ways[w].samples));
    panel.series[0].y.push_back(c.recall()), panel.series[1].y.push_back(c.precision());
  }
  report.panels = {panel};
  outputs.write(report);
  return 0;
}

}  // namespace

Subcommand add_tracking(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("tracking", "What a tracker finds with few samples while the camera moves");
  app->allow_extras();
  auto a = std::make_shared<Arguments>();
  const char* what = "What is measured";
  add_text_flag(*app, "--random", a->random, "N", "Random scenes; the first has the seed S [10]", what);
  add_text_flag(*app, "--families", a->families, "LIST", "Of random scenes: all, tuning, report, or names [all]", what);
  add_text_flag(*app, "--frames", a->frames, "N", "Frames of each scene, 6 or more; the first 5 do not count [30]",
                what);
  add_text_flag(*app, "--sweep", a->sweep, "RAD", "Angle of the camera's way around the scene (rad) [0.5]", what);
  add_text_flag(*app, "--samples", a->samples, "N", "Neighbourhoods of a frame that is searched for itself [5000]",
                what);
  add_text_flag(*app, "--few", a->few, "N", "Neighbourhoods of a frame with the tracker [1000]", what);
  add_common_flags(*app, a->common, "Runs of each scene, with seeds S, S + 1, ... of the search [1]");
  return {app, [a] { return run(*a); }};
}

}  // namespace handhold::experiments
