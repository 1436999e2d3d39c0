// handhold evaluate: its report, its files, and what it refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "process.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

using Words = std::vector<std::string>;

// The cylinder of sample_files.h as a part, one that is not there, and handles: right, duplicate, false, unsure.
constexpr const char* kTruth = R"({"cloud": [
  {"what": "rod", "center": [0.05, 0, 0.7], "axis": [0, 1, 0], "radius": 0.02, "length": 0.15, "confidence": 1,
   "centre_line": [[0.05, -0.075, 0.7], [0.05, 0.075, 0.7]], "visible": 1, "graspable": true},
  {"what": "ghost", "center": [-0.2, 0, 0.8], "axis": [1, 0, 0], "radius": 0.01, "length": 0.1, "confidence": 1}],
  "quiet": []})";
constexpr const char* kResult = R"({"schema": "handhold/1", "handles": [
  {"center": [0.051, 0.01, 0.7], "axis": [0, 1, 0], "approach": [0, 0, 1], "radius": 0.019, "length": 0.12, "confidence": 0.95},
  {"center": [0.05, 0.04, 0.7], "axis": [0, 1, 0], "approach": [0, 0, 1], "radius": 0.02, "length": 0.05, "confidence": 0.8},
  {"center": [0.2, 0, 0.7], "axis": [0, 1, 0], "approach": [0, 0, 1], "radius": 0.02, "length": 0.05, "confidence": 0.6},
  {"center": [-0.2, 0, 0.8], "axis": [1, 0, 0], "approach": [0, 0, 1], "radius": 0.01, "length": 0.1, "confidence": 0.2}],
  "affordances": [{"center": [0.05, 0, 0.7], "axis": [0, 1, 0], "normal": [0, 0, -1], "radius": 0.02}]})";
// In the place of the cylinder a flat bar, and the camera in the origin.
constexpr const char* kScene = R"(name = 'cloud'
[camera]
position = [0.0, 0.0, 0.0]
rotation = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
preset = 'bare'
[[object]]
name = 'bar'
family = 'board'
position = [0.05, 0.0, 0.715]
sizes = {width = 0.05, depth = 0.15, thickness = 0.03}
)";

class Evaluate : public ::testing::Test {
 protected:
  Evaluate() {
    std::filesystem::create_directory(folder_.path() / "results");
    folder_.write("truth.json", kTruth);
    folder_.write("results/cloud.json", kResult);
    folder_.write("results/quiet.json", R"({"handles": [], "affordances": []})");
    folder_.write("cloud.pcd", binary_pcd(cylinder()));
  }

  Outcome evaluate(Words arguments) const {
    arguments.insert(arguments.begin(), "evaluate");
    return run_program(arguments, folder_.path());
  }
  std::string report(const Words& arguments) const {
    const Outcome done = evaluate(arguments);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_EQ(done.err, "");
    return done.out;
  }
  void expect_refusal(const Words& arguments, int exit_code, const std::string& part) const {
    const Outcome done = evaluate(arguments);
    EXPECT_EQ(done.exit_code, exit_code) << done.err;
    EXPECT_EQ(done.out, "");
    EXPECT_EQ(done.err.rfind("handhold: error: ", 0), 0u) << done.err;
    EXPECT_EQ(done.err.find('\n'), done.err.size() - 1) << done.err;
    EXPECT_NE(done.err.find(part), std::string::npos) << part << " in " << done.err;
  }

  Folder folder_;
};

void expect_parts(const std::string& text, const Words& parts) {
  for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
}

TEST_F(Evaluate, Report) {
  const std::string all = report({"results", "truth.json"});
  expect_parts(all, {"scenes       2", "recall       1.000  2 of 2", "precision    0.500  2 of 4",
                     "duplicates   0.250  1 of 4", "quiet        1.000  1 of 1", "rod ", "ghost ", "10 to 20 mm"});
  EXPECT_EQ(all.find("soundness"), std::string::npos) << "no scenes were given";
  const std::string sure = report({"results", "truth.json", "--min-confidence", "0.5", "--explain"});
  expect_parts(sure, {"recall       0.500  1 of 2", "precision    0.333  1 of 3", "missed 'ghost': handle 4 is there",
                      "duplicate handle 2: on 'rod'", "false handle 3: "});
  expect_parts(report({"results", "truth.json", "--hand-aperture", "0.03"}), {"1.000  1 of 1 needed parts"});
}

TEST_F(Evaluate, SoundnessAgainstTheScenesGeometry) {
  std::filesystem::create_directory(folder_.path() / "scenes");
  folder_.write("scenes/cloud.toml", kScene);
  std::string other = kScene;
  folder_.write("scenes/quiet.toml", other.replace(other.find("cloud"), 5, "quiet"));
  const std::string text = report({"results", "truth.json", "--scenes", "scenes", "--explain"});
  expect_parts(text, {"soundness    0.500  2 of 4 handles", "1.000  1 of 1 affordances",
                      "0.000  0 of 1 false handles are sound, 1 unsound", "unsound: nothing between the fingers",
                      "false handle 3: on 'bar' (board); ", "false handles on",
                      "board                 1      0                1/2"});
  expect_parts(report({"results", "truth.json", "--scenes", "scenes", "--hand-aperture", "0.025"}),
               {"soundness    0.000  0 of 4 handles"});
  std::filesystem::remove(folder_.path() / "scenes/quiet.toml");
  expect_refusal({"results", "truth.json", "--scenes", "scenes"}, 1, "quiet.toml");
  expect_refusal({"results", "truth.json", "--scenes", "nowhere"}, 1, "'nowhere' is no folder");
}

TEST_F(Evaluate, ScenesWithNothingToHold) {
  const Outcome made = run_program(
      {"simulate", "--set", "negatives", "--random", "3", "--seed", "3", "--clutter", "0", "--bare", "-o", "negatives"},
      folder_.path());
  ASSERT_EQ(made.exit_code, 0) << made.err;
  std::filesystem::create_directory(folder_.path() / "none");
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "negatives")) {
    if (entry.path().extension() != ".toml") continue;
    // In one scene a handle in the air, 0.3 m before the camera.
    const std::string name = entry.path().stem().string();
    folder_.write("none/" + name + ".json",
                  name == "negative_3_c0" ? R"({"handles": [{"center": [0, 0, 0.3], "axis": [1, 0, 0], "radius": 0.01,
                     "length": 0.05}]})"
                                          : R"({"handles": []})");
  }
  const std::string text =
      report({"none", "negatives/truth.json", "--scenes", "negatives", "--explain", "--csv", "negatives.csv"});
  expect_parts(
      text, {"quiet        0.667  2 of 3 scenes without listed parts", "0 of 1 false handles are sound, 1 unsound",
             "false handles on  count  sound  objects without/all", "none on ", "negative_3_c0: false handle 1: on '"});
  expect_parts(folder_.read("negatives.csv"), {",sound,object,family,cause,", "handle,negative_3_c0,1,,false,"});
}

TEST_F(Evaluate, CsvAndPictures) {
  report({"results", "truth.json", "--csv", "cases.csv", "--pictures", "new/pictures", "--min-confidence", "0.5"});
  const std::string csv = folder_.read("cases.csv");
  expect_parts(csv, {"record,scene,", "scene,cloud,", "scene,quiet,", "handle,cloud,1,rod,right,0.95",
                     "handle,cloud,4,ghost,left_out", "part,cloud,2,ghost,missed"});
  Words pictures;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "new/pictures")) {
    pictures.push_back(entry.path().filename().string());
    EXPECT_EQ(folder_.read("new/pictures/" + pictures.back()).substr(1, 3), "PNG");
  }
  std::sort(pictures.begin(), pictures.end());
  EXPECT_EQ(pictures, (Words{"cloud-duplicate-2.png", "cloud-false-3.png", "cloud-missed-2.png"}));
  std::filesystem::remove(folder_.path() / "cloud.pcd");
  expect_refusal({"results", "truth.json", "--pictures", "more"}, 1, "cloud.pcd");
}

TEST_F(Evaluate, WhatIsRefused) {
  expect_refusal({}, 2, "folder of results and a truth file");
  expect_refusal({"results"}, 2, "folder of results and a truth file");
  expect_refusal({"results", "truth.json", "--min-confidence", "2"}, 2, "--min-confidence = '2'");
  expect_refusal({"results", "truth.json", "--hand-aperture", "wide"}, 2, "--hand-aperture");
  expect_refusal({"results", "truth.json", "--hand-aperture", "0"}, 2, "aperture");
  expect_refusal({"results", "truth.json", "--hand-minimum", "0.09"}, 2, "minimum");
  expect_refusal({"results", "truth.json", "--clouds", "."}, 2, "--pictures");
  expect_refusal({"results", "truth.json", "--sound"}, 2, "unknown option '--sound'");
  expect_refusal({"nowhere", "truth.json"}, 1, "'nowhere' is no folder");
  expect_refusal({"results", "nothing.json"}, 1, "cannot read 'nothing.json'");
  expect_refusal({"results", "results"}, 1, "cannot read 'results'");
  expect_refusal({"results", "truth.json", "--csv", "nowhere/cases.csv"}, 1, "nowhere/cases.csv");
  folder_.write("wrong.json", "{\"cloud\": [{\"what\": 3}]}");
  expect_refusal({"results", "wrong.json"}, 1, "scene 'cloud', part 1: has no \"center\"");
  folder_.write("none.json", "{}");
  expect_refusal({"results", "none.json"}, 1, "names no scene");
  folder_.write("results/quiet.json", "{\"handles\": 1}");
  expect_refusal({"results", "truth.json"}, 1, "handles: must be a list");
  folder_.write("results/quiet.json", "not JSON");
  expect_refusal({"results", "truth.json"}, 1, "quiet.json' is not JSON");
  std::filesystem::remove(folder_.path() / "results/quiet.json");
  expect_refusal({"results", "truth.json"}, 1, "'results' has no result of scene 'quiet'");
}

}  // namespace
}  // namespace handhold::test
