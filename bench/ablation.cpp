// What each condition of the default method is worth: scenes with their truth, searched with all conditions on, and
// with each one off alone.
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "conditions.h"
#include "files.h"
#include "handhold/io.h"
#include "handhold/localizer.h"
#include "handhold/scene_file.h"
#include "localizer_detail.h"
#include "matching.h"
#include "progress.h"
#include "soundness.h"
#include "statistics.h"
#include "summary.h"
#include "tables.h"
#include "text.h"

namespace handhold {
namespace {

using evaluation::format;

/// One row of the table.
struct Case {
  std::string name;
  Options options;
  Conditions conditions;
};

/// Means over the right candidates: evidence that neither speaks for a candidate nor against it.
struct Usual {
  double normal_error = 0;  ///< rad
  double corner_gain = 0;
};

/// The first one has all conditions on.
std::vector<Case> all_cases(const Options& standard, const Usual& usual) {
  std::vector<Case> cases;
  const auto add = [&](const char* name, const std::function<void(Options&, Conditions&)>& change) {
    cases.push_back({name, standard, {}});
    change(cases.back().options, cases.back().conditions);
  };
  const auto without = [&](const char* name, bool Conditions::*condition) {
    add(name, [&](Options&, Conditions& c) { c.*condition = false; });
  };
  using O = Options;
  using C = Conditions;
  add("all on", [](O&, C&) {});
  without("shadows unknown", &C::fill_shadows);
  without("border unknown", &C::fill_void);
  without("unseen is free", &C::seen_empty);
  add("free share 0.3", [](O& o, C&) { o.min_free = 0.3; });
  add("free share 0.7", [](O& o, C&) { o.min_free = 0.7; });
  without("approach from the sensor only", &C::other_angles);
  add("one radius: 25 mm", [](O& o, C&) { o.radius = {0.025}; });
  add("axis from pca", [](O& o, C&) { o.axis = AxisEstimator::kPca; });
  add("axis from normals", [](O& o, C&) { o.axis = AxisEstimator::kNormals; });
  without("neighbourhoods not refined", &C::refine);
  without("any arc", &C::least_arc);
  without("hollows too", &C::convex);
  without("groups not refitted", &C::refit);
  without("refit not filtered by normals", &C::filter_normals);
  without("affordances where the surface goes on", &C::ends);
  without("no straps by their outline", &C::straps);
  without("bends not followed", &C::bows);
  without("no evidence from the outline", &C::outline);
  without("radius profile not cut", &C::cut_profile);
  add("no normals in the verdict", [&](O&, C& c) { c.normal_error = usual.normal_error; });
  add("no corner gain", [&](O&, C& c) { c.corner_gain = usual.corner_gain; });
  without("pieces not continued", &C::continue_parts);
  without("curves not joined", &C::join_curved);
  add("every confidence", [](O& o, C&) { o.min_confidence = 0; });
  add("confidence 0.5", [](O& o, C&) { o.min_confidence = 0.5; });
  without("samples on flat places, too", &C::pass_flat);
  add("uniform samples", [](O& o, C&) { o.strategy = Strategy::kUniform; });
  add("half the samples", [](O& o, C&) { o.samples = std::max(1, o.samples / 2); });
  add("twice the samples", [](O& o, C&) { o.samples *= 2; });
  add("paper's method", [](O& o, C&) { o.method = Method::kPaper; });
  return cases;
}

/// A scene that `handhold simulate` made.
struct Scene {
  std::string name;
  std::vector<evaluation::LabelledPart> parts;
};

struct Search {
  double seconds = 0;  ///< of one thread's time
  std::vector<Handle> handles;
};

Search search(Localizer& localizer, const CloudView& cloud) {
  const auto now = [] {
    std::timespec t{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double start = now();
  Search result;
  result.handles = localizer.localize(cloud).handles;
  result.seconds = now() - start;
  return result;
}

/// Runs f(i) for every scene, several at a time, and shows how far it is.
void for_all(std::size_t scenes, const char* what, const std::function<void(std::size_t)>& f) {
  Progress progress;
  std::mutex mutex;
  std::size_t done = 0;
  const auto show = [&] { progress.show(format("%s: %zu of %zu scenes", what, done, scenes)); };
  show();
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, scenes, 1),
      [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          f(i);
          const std::lock_guard<std::mutex> lock(mutex);
          ++done;
          show();
        }
      },
      tbb::simple_partitioner());
}

Usual usual_evidence(const std::string& folder, const std::vector<Scene>& scenes, const Options& options) {
  std::vector<std::vector<Evidence>> right(scenes.size());
  for_all(scenes.size(), "evidence", [&](std::size_t s) {
    const Cloud cloud = read_cloud(folder + "/" + scenes[s].name + ".pcd");
    Localizer localizer(options);
    localizer.localize(cloud.view());
    const Recycled<PartCandidate>& candidates = LocalizerInside::candidates(localizer);
    std::vector<Handle> handles;
    for (const PartCandidate& candidate : candidates) handles.push_back(candidate.handle);
    const evaluation::SceneScore score = evaluation::score_scene(scenes[s].name, scenes[s].parts, handles);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (score.handles[i].verdict == evaluation::Verdict::kRight) right[s].push_back(candidates[i].evidence);
    }
  });
  std::vector<double> normals, corners;
  for (const std::vector<Evidence>& scene : right) {
    for (const Evidence& e : scene) {
      if (e.normal_error > 0) normals.push_back(e.normal_error);  // of thin parts none is measured
      corners.push_back(e.corner_gain);
    }
  }
  return {mean(normals), mean(corners)};
}

/// What a case gave in all scenes.
struct Outcome {
  std::vector<evaluation::SceneScore> scores;
  std::vector<std::vector<Handle>> handles;
  std::vector<double> ratios;  ///< time over that with all conditions on, of each scene
};

/// Judges what was found; soundness too, where the folder has the scene's file.
evaluation::Scene judge(const Scene& scene, const sensor::Scene* geometry, const sensor::Pose& T_world_camera,
                        std::vector<Handle> handles, const Options& options) {
  evaluation::Scene judged;
  judged.name = scene.name, judged.parts = scene.parts;
  judged.result.handles = std::move(handles);
  judged.score = evaluation::score_scene(scene.name, scene.parts, judged.result.handles);
  if (geometry) {
    sensor::Hand hand;
    hand.aperture = options.hand_aperture, hand.minimum = options.hand_minimum;
    hand.finger_thickness = options.finger_thickness, hand.finger_width = options.finger_width;
    hand.finger_depth = options.finger_depth;
    evaluation::check_soundness(judged, *geometry, T_world_camera, hand);
  }
  return judged;
}

/// Searches every scene with every case. All cases of a scene follow each other, with a search with all conditions on
/// before every few of them, so that a ratio of times is one of neighbours.
std::vector<Outcome> measure(const std::string& folder, const std::vector<Scene>& scenes,
                             const std::vector<Case>& cases) {
  constexpr std::size_t kBetween = 4;
  std::vector<Outcome> outcomes(cases.size());
  for (Outcome& o : outcomes) {
    o.scores.resize(scenes.size()), o.handles.resize(scenes.size()), o.ratios.resize(scenes.size());
  }
  tbb::enumerable_thread_specific<std::vector<Localizer>> localizers([&cases] {
    std::vector<Localizer> all;
    for (const Case& c : cases) all.push_back(LocalizerInside::make(c.options, c.conditions));
    return all;
  });
  for_all(scenes.size(), "searching", [&](std::size_t s) {
    const Scene& scene = scenes[s];
    const Cloud cloud = read_cloud(folder + "/" + scene.name + ".pcd");
    std::vector<Localizer>& all = localizers.local();
    std::vector<double> seconds(cases.size()), standard;
    std::vector<Search> found(cases.size());
    // Each scene begins with another case, so that none is always the first after a pause.
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if (i % kBetween == 0) {
        found[0] = search(all[0], cloud.view());
        standard.push_back(found[0].seconds);
      }
      const std::size_t c = 1 + (i + s) % (cases.size() - 1);
      if (i + 1 < cases.size()) {
        found[c] = search(all[c], cloud.view());
        seconds[c] = found[c].seconds;
      }
    }
    seconds[0] = quantile(standard, 0.5);
    sensor::Scene geometry;
    sensor::SceneFile file;
    const std::string path = folder + "/" + scene.name + ".toml";
    const bool checked = std::filesystem::exists(path);
    if (checked) file = sensor::read_scene(path), geometry = sensor::build(file);
    for (std::size_t c = 0; c < cases.size(); ++c) {
      evaluation::Scene judged = judge(scene, checked ? &geometry : nullptr, file.T_world_camera,
                                       std::move(found[c].handles), cases[c].options);
      outcomes[c].scores[s] = std::move(judged.score);
      outcomes[c].handles[s] = std::move(judged.result.handles);
      outcomes[c].ratios[s] = seconds[c] / seconds[0];
    }
  });
  return outcomes;
}

struct Line {
  std::string name;
  evaluation::Summary summary;
  std::size_t wrong = 0;  ///< handles on no listed part
  double time = 0;        ///< over that with all conditions on
};

evaluation::Share of_support(const evaluation::Summary& summary, const char* name) {
  for (const evaluation::Group& group : summary.by_support) {
    if (group.name == name) return group.recall;
  }
  return {};
}

std::string table(const std::vector<Line>& lines) {
  std::string text =
      format("%-31s recall  found/needed  raised  lying  precision  right/handles  false  sound   time\n",
             "off or changed, alone");
  for (const Line& line : lines) {
    const evaluation::Summary& m = line.summary;
    const std::string sound = m.sound_handles.of > 0 ? format("%.3f", m.sound_handles.value()) : "-";
    text += format("%-31s  %.3f  %5zu/%-6zu   %.3f  %.3f      %.3f  %5zu/%-7zu  %5zu  %5s  %5.2f\n", line.name.c_str(),
                   m.recall.value(), m.recall.count, m.recall.of, of_support(m, "raised").value(),
                   of_support(m, "lying").value(), m.precision.value(), m.precision.count, m.precision.of, line.wrong,
                   sound.c_str(), line.time);
  }
  return text;
}

std::string csv(const std::vector<Line>& lines) {
  std::string text =
      "condition,recall,found,needed,recall_raised,recall_lying,precision,right,handles,duplicates,false,sound_false,"
      "sound,checked,time_ratio\n";
  for (const Line& line : lines) {
    const evaluation::Summary& m = line.summary;
    text +=
        format("%s,%.4f,%zu,%zu,%.4f,%.4f,%.4f,%zu,%zu,%zu,%zu,%zu,%zu,%zu,%.4f\n", line.name.c_str(), m.recall.value(),
               m.recall.count, m.recall.of, of_support(m, "raised").value(), of_support(m, "lying").value(),
               m.precision.value(), m.precision.count, m.precision.of, m.duplicates.count, line.wrong,
               m.sound_false_handles.count, m.sound_handles.count, m.sound_handles.of, line.time);
  }
  return text;
}

constexpr const char* kAbout =
    "What each condition of the default method is worth: searches scenes that 'handhold simulate' made with all "
    "conditions on, and with each one off or changed alone.\n\n"
    "The weights of the confidence are not fitted again for a row, so it says what a condition is worth to this "
    "program "
    "and not what it would be without it. Evidence that a row takes from the confidence (normals, corner gain) is "
    "replaced by its mean over the right candidates, which speaks neither for nor against. 'false' counts handles on "
    "no "
    "listed part, 'sound' is the share of handles at which two fingers fit in the scene's complete geometry ('-': no "
    "NAME.toml), 'time' the median over the scenes of one thread's time over that with all conditions on.";

int run(int argc, char** argv) {
  CLI::App app{kAbout};
  std::string folder, csv_path;
  std::vector<std::string> only;
  std::uint64_t seed = 1;
  int samples = 5000, threads = 1;
  app.add_option("FOLDER", folder, "Folder with NAME.pcd, NAME.toml and truth.json")->required();
  app.add_option("--csv", csv_path, "Write the table with all counts");
  app.add_option("--only", only, "Only rows whose name contains one of these words");
  app.add_option("--seed", seed, "Seed of the random numbers [1]");
  app.add_option("--samples", samples, "Neighbourhoods to look at (count) [5000]")->check(CLI::Range(1, 5'000'000));
  app.add_option("--threads", threads,
                 "Scenes to search at a time (count); with more than one, times disturb each other [1]")
      ->check(CLI::Range(1, 1024));
  CLI11_PARSE(app, argc, argv);
  if (!csv_path.empty()) AtomicFile::check_writable(csv_path);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));

  std::vector<Scene> scenes;
  for (auto& [name, parts] : evaluation::read_truth(folder + "/truth.json")) scenes.push_back({name, parts});
  if (scenes.empty())
    throw std::runtime_error("'" + folder + "/truth.json' names no scene; there is nothing to measure");
  Options standard;
  standard.seed = seed, standard.samples = samples, standard.threads = 1;
  const auto chosen = [&](const Usual& usual) {
    std::vector<Case> cases = all_cases(standard, usual);
    const auto left_out = [&only](const Case& c) {
      return std::none_of(only.begin(), only.end(),
                          [&c](const std::string& word) { return c.name.find(word) != std::string::npos; });
    };
    if (!only.empty()) cases.erase(std::remove_if(cases.begin() + 1, cases.end(), left_out), cases.end());
    return cases;
  };
  if (chosen({}).size() < 2) {
    throw std::runtime_error("--only '" + only.front() +
                             "': no row's name contains that; without --only all are shown");
  }
  const std::vector<Case> cases = chosen(usual_evidence(folder, scenes, standard));
  std::vector<Outcome> outcomes = measure(folder, scenes, cases);
  std::vector<std::vector<evaluation::LabelledPart>> parts;
  for (const Scene& scene : scenes) parts.push_back(scene.parts);
  std::vector<Line> lines;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    Line line{cases[c].name, evaluation::summarize(outcomes[c].scores, parts, outcomes[c].handles), 0, 0};
    line.wrong = line.summary.precision.of - line.summary.precision.count - line.summary.duplicates.count;
    line.time = quantile(outcomes[c].ratios, 0.5);
    lines.push_back(std::move(line));
  }
  if (!csv_path.empty()) write_file(csv_path, csv(lines));
  std::fputs(table(lines).c_str(), stdout);
  return 0;
}

}  // namespace
}  // namespace handhold

int main(int argc, char** argv) {
  try {
    return handhold::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handhold_ablation: %s\n", error.what());
    return 1;
  }
}
