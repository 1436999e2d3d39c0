// handhold evaluate: how right results are, by labels and by the complete geometry of the scenes.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atomic_file.h"
#include "case_picture.h"
#include "causes.h"
#include "command_line.h"
#include "files.h"
#include "handhold/config.h"
#include "handhold/io.h"
#include "handhold/scene_file.h"
#include "objects.h"
#include "progress.h"
#include "soundness.h"
#include "subcommand.h"
#include "summary.h"
#include "tables.h"
#include "usage_error.h"

namespace handhold {
namespace {

namespace fs = std::filesystem;
using evaluation::Scene;
using evaluation::Verdict;

struct Arguments {
  std::string results, truth;
  std::string scenes, clouds;
  std::string csv, pictures;
  std::string min_confidence, part_confidence;
  std::string aperture, minimum, thickness, width, depth;
  bool explain = false;
};

void add_flags(CLI::App& app, Arguments& a) {
  app.add_option("RESULTS", a.results, "Folder of SCENE.json, each from 'handhold localize --json'")->option_text(" ");
  app.add_option("TRUTH", a.truth, "JSON file: scene -> list of parts")->option_text(" ");
  const auto text = [&app](const char* flag, std::string& target, const char* value, const char* help,
                           const char* group) { add_text_flag(app, flag, target, value, help, group); };
  const char* input = "Input";
  text("--scenes", a.scenes, "DIR",
       "Folder of SCENE.toml: check soundness, and say what handles lie on, by the complete geometry", input);
  text("--clouds", a.clouds, "DIR", "Folder of SCENE.pcd, for --pictures [--scenes, or where TRUTH is]", input);
  const char* output = "Output";
  text("--csv", a.csv, "F", "Write a line per scene, handle and needed part", output);
  text("--pictures", a.pictures, "DIR", "Write a picture of every miss and every false handle", output);
  app.add_flag("--explain", a.explain, "Print the cause of every miss and every false handle")
      ->disable_flag_override()
      ->group(output);
  const char* rule = "What counts";
  text("--min-confidence", a.min_confidence, "C", "Leave out handles below this confidence [0]", rule);
  text("--part-confidence", a.part_confidence, "C", "Ask for parts at least this sure [0.5]", rule);
  text("--hand-aperture", a.aperture, "M", "Widest opening of the hand; wider parts are not asked for (m) [0.08]",
       rule);
  text("--hand-minimum", a.minimum, "M", "Narrowest opening of the hand (m) [0]", rule);
  text("--finger-thickness", a.thickness, "M", "Along the closing direction (m) [0.01]", rule);
  text("--finger-width", a.width, "M", "Along the part (m) [0.02]", rule);
  text("--finger-depth", a.depth, "M", "Along the approach (m) [0.04]", rule);
}

void set_number(const char* flag, const std::string& text, double low, double high, double& target) {
  if (text.empty()) return;
  const std::vector<double> values = parse_numbers(flag, text);
  if (values.size() != 1 || values[0] < low || values[0] > high) {
    const std::string bound =
        high < 1e6 ? " from " + std::to_string(static_cast<int>(low)) + " to " + std::to_string(static_cast<int>(high))
                   : ", not negative";
    throw UsageError(std::string(flag) + " = '" + text + "': must be one number" + bound);
  }
  target = values[0];
}

struct Rules {
  evaluation::MatchOptions match;
  sensor::Hand hand;
};

Rules rules(const Arguments& a) {
  constexpr double kAny = 1e9;
  Rules r;
  set_number("--min-confidence", a.min_confidence, 0, 1, r.match.min_confidence);
  set_number("--part-confidence", a.part_confidence, 0, 1, r.match.part_confidence);
  set_number("--hand-aperture", a.aperture, 0, kAny, r.hand.aperture);
  set_number("--hand-minimum", a.minimum, 0, kAny, r.hand.minimum);
  set_number("--finger-thickness", a.thickness, 0, kAny, r.hand.finger_thickness);
  set_number("--finger-width", a.width, 0, kAny, r.hand.finger_width);
  set_number("--finger-depth", a.depth, 0, kAny, r.hand.finger_depth);
  try {
    r.hand.validate();
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  r.match.hand_aperture = r.hand.aperture;
  return r;
}

void check_folder(const std::string& path, const std::string& what) {
  std::error_code error;
  if (!fs::is_directory(path, error)) throw std::runtime_error("'" + path + "' is no folder; it must hold " + what);
}

std::string file_of(const std::string& folder, const std::string& scene, const char* ending) {
  return (fs::path(folder) / (scene + ending)).string();
}

std::vector<Scene> read_scenes(const Arguments& a, const evaluation::MatchOptions& match) {
  std::vector<Scene> scenes;
  for (auto& [name, parts] : evaluation::read_truth(a.truth)) {
    Scene scene;
    scene.name = name;
    scene.parts = parts;
    const std::string path = file_of(a.results, name, ".json");
    std::error_code error;
    if (!fs::exists(path, error)) {
      throw std::runtime_error("'" + a.results + "' has no result of scene '" + name + "' of '" + a.truth +
                               "'; write one with 'handhold localize --json " + path + "'");
    }
    scene.result = evaluation::read_result(path);
    scene.score = evaluation::score_scene(name, scene.parts, scene.result.handles, match);
    scenes.push_back(std::move(scene));
  }
  if (scenes.empty()) throw std::runtime_error("'" + a.truth + "' names no scene; there is nothing to compare");
  return scenes;
}

/// "mug_0001-missed-2.png"
class CasePictures {
 public:
  CasePictures(const Scene& scene, const std::string& cloud, const std::string& folder)
      : scene_(scene), cloud_path_(cloud), folder_(folder) {}

  /// Returns how many were written.
  int write() {
    for (std::size_t k = 0; k < scene_.parts.size(); ++k) {
      if (!scene_.score.parts[k].needed || scene_.score.parts[k].handle >= 0) continue;
      const evaluation::LabelledPart& part = scene_.parts[k];
      CasePicture picture;
      for (std::size_t i = 0; i < scene_.parts.size(); ++i) picture.parts.push_back(mark(i, i == k));
      picture.focus = part.center;
      picture.extent = part.length / 2 + 2 * part.radius + kAround;
      picture.caption = scene_.name + ": missed '" + part.what +
                        "' (magenta): " + why_missed(k, scene_.parts, scene_.result, scene_.score);
      write(picture, "missed", k);
    }
    for (std::size_t i = 0; i < scene_.score.handles.size(); ++i) {
      const Verdict verdict = scene_.score.handles[i].verdict;
      if (verdict != Verdict::kFalse && verdict != Verdict::kDuplicate) continue;
      const char* kind = verdict == Verdict::kFalse ? "false" : "duplicate";
      const Handle& handle = scene_.result.handles[i];
      CasePicture picture;
      for (std::size_t k = 0; k < scene_.parts.size(); ++k) picture.parts.push_back(mark(k, false));
      picture.handle = i;
      picture.focus = handle.center;
      picture.extent = handle.length / 2 + 2 * handle.radius + kAround;
      picture.caption = scene_.name + ": " + kind + " handle " + std::to_string(i + 1) +
                        " (red): " + why_false(i, scene_.parts, scene_.result, scene_.score);
      write(picture, kind, i);
    }
    return count_;
  }

 private:
  static constexpr double kAround = 0.04;  // m

  TruthMark mark(std::size_t k, bool subject) const {
    return {scene_.parts[k].centre_line, scene_.parts[k].radius, subject};
  }

  void write(const CasePicture& picture, const char* kind, std::size_t index) {
    if (count_++ == 0) {  // only scenes with something to show need their cloud
      cloud_ = read_cloud(cloud_path_);
      painter_ = std::make_unique<CasePainter>(cloud_.view(), cloud_.rgb, scene_.result);
    }
    const std::string name = scene_.name + "-" + kind + "-" + std::to_string(index + 1) + ".png";
    painter_->write((fs::path(folder_) / name).string(), picture);
  }

  const Scene& scene_;
  std::string cloud_path_, folder_;
  Cloud cloud_;
  std::unique_ptr<CasePainter> painter_;
  int count_ = 0;
};

void write_text(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

int run(const Arguments& a) {
  if (a.results.empty() || a.truth.empty()) {
    throw UsageError(
        "a folder of results and a truth file are needed; for example 'handhold evaluate results truth.json'");
  }
  const Rules rule = rules(a);
  if (!a.clouds.empty() && a.pictures.empty()) throw UsageError("--clouds needs --pictures, which shows them");
  check_folder(a.results, "SCENE.json for each scene");
  if (!a.scenes.empty()) check_folder(a.scenes, "SCENE.toml for each scene");
  if (!a.csv.empty()) AtomicFile::check_writable(a.csv);

  int pictures = 0;
  std::vector<Scene> scenes;
  {
    Progress progress;
    progress.show("reading " + a.truth);
    scenes = read_scenes(a, rule.match);
    for (Scene& scene : scenes) {
      if (a.scenes.empty()) break;
      progress.show("checking " + scene.name);
      const sensor::SceneFile file = sensor::read_scene(file_of(a.scenes, scene.name, ".toml"));
      const sensor::Scene geometry = sensor::build(file);
      evaluation::check_soundness(scene, geometry, file.T_world_camera, rule.hand);
      std::vector<std::string> families;
      for (const sensor::SceneObject& object : file.objects) families.push_back(object.family);
      evaluation::find_objects(scene, geometry, families, file.T_world_camera);
    }
    if (!a.pictures.empty()) {
      const fs::path beside_truth = fs::path(a.truth).parent_path();
      const std::string clouds = !a.clouds.empty()      ? a.clouds
                                 : !a.scenes.empty()    ? a.scenes
                                 : beside_truth.empty() ? "."
                                                        : beside_truth.string();
      std::error_code error;
      fs::create_directories(a.pictures, error);
      if (error) throw std::runtime_error("cannot make the folder '" + a.pictures + "': " + error.message());
      for (const Scene& scene : scenes) {
        progress.show("drawing " + scene.name);
        pictures += CasePictures(scene, file_of(clouds, scene.name, ".pcd"), a.pictures).write();
      }
    }
  }
  if (!a.csv.empty()) write_text(a.csv, evaluation::csv(scenes));

  std::vector<evaluation::SceneScore> scores;
  std::vector<std::vector<evaluation::LabelledPart>> parts;
  std::vector<std::vector<Handle>> handles;
  for (const Scene& scene : scenes) {
    scores.push_back(scene.score);
    parts.push_back(scene.parts);
    handles.push_back(scene.result.handles);
  }
  std::string text = evaluation::summary_text(evaluation::summarize(scores, parts, handles));
  if (a.explain) {
    const std::string cases = evaluation::cases_text(scenes);
    text += cases.empty() ? "\nnothing was missed and no handle is false\n" : "\n" + cases;
  }
  if (!a.pictures.empty()) text += std::to_string(pictures) + " pictures in '" + a.pictures + "'\n";
  write_and_flush(stdout, text, "standard output");
  return 0;
}

}  // namespace

Subcommand add_evaluate(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("evaluate", "Compare results with the truth");
  app->allow_extras();
  auto arguments = std::make_shared<Arguments>();
  add_flags(*app, *arguments);
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace handhold
