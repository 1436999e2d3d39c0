// handhold simulate: the files it writes, and what it refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "handhold/io.h"
#include "handhold/random_scene.h"
#include "process.h"
#include "refusal.h"

namespace handhold::test {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

// A small image: the test is about files.
const char* const kScene = R"(name = "one"
[camera]
eye = [0, -0.6, 0.5]
target = [0, 0, 0.05]
width = 160
height = 120
fx = 145.0
fy = 145.0
cx = 79.5
cy = 59.5
[[object]]
name = "table"
family = "board"
position = [0, 0, 0]
[[object]]
name = "bottle"
family = "bottle"
position = [0, 0, 0]
)";

class Simulate : public ::testing::Test {
 protected:
  Simulate() { folder_.write("scene.toml", kScene); }

  Outcome simulate(Words words) {
    words.insert(words.begin(), "simulate");
    return run_program(words, folder_.path());
  }
  Words entries_of(const std::string& name) {
    Words names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / name)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  /// One line of error with all of `parts` in it, and nothing written.
  void expect_refusal(const Words& words, int exit_code, const Words& parts) {
    expect_one_line_refusal(
        folder_, [&](const Words& w) { return simulate(w); }, words, exit_code, parts);
  }

  Folder folder_;
};

TEST_F(Simulate, WritesCloudSceneAndTruth) {
  const Outcome done = simulate({"scene.toml", "-o", "out/deep"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(done.err, "");
  EXPECT_EQ(done.out.rfind("1 scene, ", 0), 0u) << done.out;
  EXPECT_EQ(entries_of("out/deep"), (Words{"one.pcd", "one.toml", "truth.json"}));
  const Cloud cloud = read_cloud((folder_.path() / "out/deep/one.pcd").string());
  EXPECT_EQ(cloud.width, 160u);
  EXPECT_EQ(cloud.height, 120u);
  const Json truth = Json::parse(folder_.read("out/deep/truth.json"));
  ASSERT_TRUE(truth.contains("one"));
  ASSERT_EQ(truth["one"].size(), 3u);
  const Json& body = truth["one"][0];
  EXPECT_EQ(body["what"], "bottle body");
  EXPECT_EQ(body["graspable"], true);
  EXPECT_TRUE(body["measured"].is_boolean());
  EXPECT_NEAR(body["radius"].get<double>(), 0.030, 1e-9);
  EXPECT_EQ(truth["one"][2]["what"], "bottle shoulder");
  EXPECT_LT(truth["one"][2]["confidence"].get<double>(), 0.5);
  // What was written is the scene: the same again from it.
  const Outcome again = simulate({"out/deep/one.toml", "-o", "again"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(folder_.read("again/truth.json"), folder_.read("out/deep/truth.json"));
  EXPECT_EQ(folder_.read("again/one.pcd"), folder_.read("out/deep/one.pcd"));
  EXPECT_EQ(folder_.read("again/one.toml"), folder_.read("out/deep/one.toml"));
}

TEST_F(Simulate, RandomScenesAreThoseOfTheLibrary) {
  const Outcome done = simulate({"--random", "2", "--seed", "30", "--families", "tuning", "-o", "out"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const auto options = sensor::RandomSceneOptions::of_half(sensor::FamilyHalf::kTuning);
  const sensor::SceneFile first = sensor::random_scene(30, options), second = sensor::random_scene(31, options);
  EXPECT_EQ(entries_of("out"), (Words{first.name + ".pcd", first.name + ".toml", second.name + ".pcd",
                                      second.name + ".toml", "truth.json"}));
  EXPECT_EQ(folder_.read("out/" + first.name + ".toml"), sensor::to_toml(first));
  EXPECT_EQ(Json::parse(folder_.read("out/truth.json")).size(), 2u);
}

TEST_F(Simulate, NegativesHaveNoParts) {
  const Outcome done = simulate({"--set", "negatives", "--random", "1", "--clutter", "0", "--bare", "-o", "out"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(Json::parse(folder_.read("out/truth.json")), Json::parse(R"({"negative_1_c0": []})"));
}

TEST_F(Simulate, FamiliesByName) {
  const Outcome done = simulate({"--random", "1", "--families", "mug,ball", "--clutter", "1", "-o", "out"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const sensor::SceneFile file = sensor::read_scene((folder_.path() / "out/random_1_c1.toml").string());
  bool mug = false;
  for (const sensor::SceneObject& object : file.objects) {
    EXPECT_TRUE(object.family == "mug" || object.family == "ball" || object.family == "board") << object.family;
    mug |= object.family == "mug";
  }
  EXPECT_TRUE(mug) << "the only target";
}

TEST_F(Simulate, ListsFamilies) {
  const Outcome done = simulate({"--list-families"});
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_NE(done.out.find("lint_roller    graspable  report"), std::string::npos) << done.out;
  EXPECT_NE(done.out.find("0.0460 .. 0.0900 m"), std::string::npos) << done.out;
}

TEST_F(Simulate, WrongUse) {
  expect_refusal({}, 2, {"-o FOLDER"});
  expect_refusal({"-o", "out"}, 2, {"no scenes given"});
  expect_refusal({"scene.toml"}, 2, {"-o FOLDER"});
  expect_refusal({"scene.toml", "--random", "2", "-o", "out"}, 2, {"scene.toml", "give one of them"});
  expect_refusal({"scene.toml", "--seed", "2", "-o", "out"}, 2, {"--seed"});
  expect_refusal({"--set", "paper", "--random", "2", "-o", "out"}, 2, {"--random"});
  expect_refusal({"--set", "negatives", "-o", "out"}, 2, {"--random"});
  expect_refusal({"--set", "papers", "-o", "out"}, 2, {"papers", "singles"});
  expect_refusal({"--random", "0", "-o", "out"}, 2, {"--random", "'0'"});
  expect_refusal({"--random", "many", "-o", "out"}, 2, {"--random", "many"});
  expect_refusal({"--random", "1", "--seed", "-1", "-o", "out"}, 2, {"--seed", "-1"});
  expect_refusal({"--random", "1", "--seed", "99999999999999999999", "-o", "out"}, 2, {"--seed"});
  expect_refusal({"--random", "1", "--clutter", "17", "-o", "out"}, 2, {"--clutter", "16"});
  expect_refusal({"--random", "1", "--families", "mugg", "-o", "out"}, 2, {"--families", "mugg", "mug"});
  expect_refusal({"--random", "1", "--families", "board", "-o", "out"}, 2, {"--families", "board"});
  expect_refusal({"--random", "1", "--families", "mug,", "-o", "out"}, 2, {"--families"});
  expect_refusal({"--set", "negatives", "--random", "1", "--families", "mug", "-o", "out"}, 2, {"mug"});
  expect_refusal({"scene.toml", "--randm", "1", "-o", "out"}, 2, {"--random"});
}

TEST_F(Simulate, BadFiles) {
  expect_refusal({"none.toml", "-o", "out"}, 1, {"none.toml"});
  expect_refusal({".", "-o", "out"}, 1, {"'.'"});
  expect_refusal({"scene.toml", "scene.toml", "-o", "out"}, 2, {"'one'"});
  folder_.write("bad.toml", std::string(kScene) + "family = \"twice\"\n");
  expect_refusal({"bad.toml", "-o", "out"}, 1, {"bad.toml", "line 19", "family"});
  folder_.write("bad.toml", std::string(kScene) + "sizes = {body_radius = 1.0}\n");
  expect_refusal({"bad.toml", "-o", "out"}, 1, {"bad.toml", "line ", "body_radius", "0.037"});
  expect_refusal({"scene.toml", "-o", "scene.toml"}, 1, {"'scene.toml'"});
  expect_refusal({"scene.toml", "-o", "scene.toml/out"}, 1, {"'scene.toml/out'"});
}

}  // namespace
}  // namespace handhold::test
