// handhold simulate: from scenes to clouds and truth.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atomic_file.h"
#include "command_line.h"
#include "handhold/io.h"
#include "handhold/random_scene.h"
#include "progress.h"
#include "scene_choice.h"
#include "subcommand.h"
#include "usage_error.h"

namespace handhold {
namespace {

using sensor::FamilyGroup;
using sensor::FamilyHalf;
using sensor::RandomSceneOptions;
using sensor::SceneFile;

struct Arguments {
  std::vector<std::string> scenes;
  std::string folder, random, seed, set, families, clutter;
  bool bare = false, list_families = false;
};

/// Families and clutter of random scenes.
RandomSceneOptions random_options(const Arguments& a, bool negatives) {
  RandomSceneOptions options = families_named(a.families, negatives);
  if (!a.clutter.empty()) options.clutter_level = static_cast<int>(whole_number("--clutter", a.clutter, 0, 16));
  return options;
}

/// The scenes that the arguments name; wrong combinations are refused before.
std::vector<SceneFile> wanted_scenes(const Arguments& a, Progress& progress) {
  const std::string set = a.set.empty() && !a.random.empty() ? "random" : a.set;
  const bool drawn = set == "random" || set == "negatives";
  if (!set.empty() && !drawn && set != "paper" && set != "singles") {
    throw UsageError("--set = '" + set + "': must be random, negatives, paper or singles");
  }
  if (set.empty() == a.scenes.empty()) {
    throw UsageError(set.empty() ? "no scenes given; for example 'handhold simulate scene.toml -o FOLDER', or "
                                   "'--random 10 --seed 1 -o FOLDER'"
                                 : "both '" + a.scenes[0] + "' and a set of scenes given; give one of them");
  }
  if (drawn && a.random.empty()) throw UsageError("--set " + set + " needs --random, too: the number of scenes");
  const std::pair<const char*, const std::string*> of_random[] = {
      {"--random", &a.random}, {"--seed", &a.seed}, {"--families", &a.families}, {"--clutter", &a.clutter}};
  for (const auto& [flag, text] : of_random) {
    if (!drawn && !text->empty()) throw UsageError(std::string(flag) + " is for --set random and negatives only");
  }
  std::vector<SceneFile> scenes;
  if (drawn) {
    const std::uint64_t count = whole_number("--random", a.random, 1, 1000000);
    const std::uint64_t seed = a.seed.empty() ? 1 : whole_number("--seed", a.seed, 0, UINT64_MAX - count);
    const RandomSceneOptions options = random_options(a, set == "negatives");
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % 16 == 0) progress.show("making scene " + std::to_string(i + 1) + " of " + std::to_string(count));
      scenes.push_back(sensor::random_scene(seed + i, options));
      if (set == "negatives") scenes.back().name.replace(0, 6, "negative");
    }
  } else if (set == "paper") {
    scenes = sensor::paper_scenes();
  } else if (set == "singles") {
    scenes = sensor::single_object_scenes();
  }
  for (const std::string& path : a.scenes) {
    progress.show("reading " + path);
    scenes.push_back(sensor::read_scene(path));
    for (std::size_t i = 0; i + 1 < scenes.size(); ++i) {
      if (scenes[i].name != scenes.back().name) continue;
      throw UsageError("'" + path + "': another scene is named '" + scenes[i].name + "', too; give it another name");
    }
  }
  if (a.bare) {
    for (SceneFile& scene : scenes) {
      scene.camera.noise = {};
    }
  }
  return scenes;
}

std::string family_table() {
  std::string text;
  for (const sensor::Family& family : sensor::families()) {
    const char* group = family.group == FamilyGroup::kGraspable ? "graspable"
                        : family.group == FamilyGroup::kPlain   ? "plain"
                                                                : "furniture";
    const char* half = family.half == FamilyHalf::kTuning   ? "tuning"
                       : family.half == FamilyHalf::kReport ? "report"
                                                            : "both";
    char line[200];
    std::snprintf(line, sizeof line, "%-14s %-10s %s\n", family.name.c_str(), group, half);
    text += line;
    for (const sensor::SizeRange& size : family.sizes) {
      std::snprintf(line, sizeof line, "  %-18s %7.4f   %.4f .. %.4f m\n", size.name.c_str(), size.value, size.low,
                    size.high);
      text += line;
    }
  }
  return text;
}

int run(const Arguments& a) {
  if (a.list_families) {
    write_and_flush(stdout, family_table(), "standard output");
    return 0;
  }
  if (a.folder.empty()) throw UsageError("no folder given for what is made; add '-o FOLDER'");
  std::vector<std::pair<std::string, std::vector<sensor::Part>>> truth;
  std::size_t points = 0;
  {
    Progress progress;
    const std::vector<SceneFile> scenes = wanted_scenes(a, progress);
    std::error_code error;
    std::filesystem::create_directories(a.folder, error);
    if (!std::filesystem::is_directory(a.folder)) {
      throw std::runtime_error("cannot make the folder '" + a.folder + "'" +
                               (error ? ": " + error.message() : std::string()) + "; give another one");
    }
    AtomicFile::check_writable(a.folder + "/truth.json");

    truth.resize(scenes.size());
    std::mutex mutex;
    std::size_t done = 0;
    tbb::parallel_for(std::size_t{0}, scenes.size(), [&](std::size_t i) {
      const SceneFile& file = scenes[i];
      const sensor::Scene scene = sensor::build(file);
      const sensor::Frame frame = sensor::DepthCamera(file.camera).capture(scene, file.T_world_camera);
      truth[i] = {file.name, sensor::captured_truth(file, scene, frame)};
      write_pcd(a.folder + "/" + file.name + ".pcd", frame.cloud.view());
      write_file(a.folder + "/" + file.name + ".toml", sensor::to_toml(file));
      const auto measured = static_cast<std::size_t>(
          std::count_if(frame.object.begin(), frame.object.end(), [](std::int32_t object) { return object >= 0; }));
      const std::lock_guard<std::mutex> lock(mutex);
      points += measured;
      progress.show("scene " + std::to_string(++done) + " of " + std::to_string(scenes.size()));
    });
  }
  write_file(a.folder + "/truth.json", sensor::truth_json(truth));

  std::size_t wanted = 0;
  for (const auto& [name, parts] : truth) {
    wanted += static_cast<std::size_t>(std::count_if(parts.begin(), parts.end(), [](const sensor::Part& part) {
      return part.graspable && part.measured && part.confidence >= 0.5;
    }));
  }
  write_and_flush(stdout,
                  std::to_string(truth.size()) + (truth.size() == 1 ? " scene, " : " scenes, ") +
                      std::to_string(points / std::max<std::size_t>(1, truth.size())) + " points each, " +
                      std::to_string(wanted) +
                      (wanted == 1 ? " visible graspable part: '" : " visible graspable parts: '") + a.folder + "'\n",
                  "standard output");
  return 0;
}

}  // namespace

Subcommand add_simulate(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("simulate", "Make clouds and their truth from scenes, with a simulated camera");
  app->allow_extras();
  auto a = std::make_shared<Arguments>();
  app->add_option("SCENE", a->scenes, "Scene files, .toml")->option_text("...");
  const char* what = "Scenes";
  add_text_flag(*app, "--random", a->random, "N", "Make N random scenes", what);
  add_text_flag(*app, "--seed", a->seed, "S", "Of the first random scene; the next ones have S + 1, ... (1)", what);
  add_text_flag(*app, "--set", a->set, "NAME",
                "random, negatives (nothing to hold), paper (seven scenes), singles (12 objects x 4 x 3)", what);
  add_text_flag(*app, "--families", a->families, "LIST",
                "Of random scenes: all, tuning, report, or names: mug,hammer,ball", what);
  add_text_flag(*app, "--clutter", a->clutter, "K", "Things beside the targets (0, 3 or 8 in turn)", what);
  app->add_flag("--bare", a->bare, "No sensor noise")->disable_flag_override()->group(what);
  app->add_flag("--list-families", a->list_families, "Print the families with their sizes, and exit")
      ->disable_flag_override()
      ->group(what);
  add_text_flag(*app, "-o,--output", a->folder, "FOLDER",
                "Gets NAME.pcd (cloud) and NAME.toml (scene) for every scene, and truth.json", "Output");
  return {app, [a] { return run(*a); }};
}

}  // namespace handhold
