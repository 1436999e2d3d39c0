// What the program writes when all is well.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "handhold/config.h"
#include "process.h"
#include "run_times.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

Words keys(const Json& json) {
  Words names;
  for (const auto& [key, value] : json.items()) names.push_back(key);
  return names;
}

class Cli : public ::testing::Test {
 protected:
  Cli() { folder_.write("cloud.pcd", binary_pcd(cylinder())); }

  /// Standard output of a run that must succeed without a word on standard error.
  std::string output(const Words& arguments, const Surroundings& around = {}) {
    const Outcome done = run_program(arguments, folder_.path(), around);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_EQ(done.err, "");
    return done.out;
  }
  Json json(Words arguments) {
    arguments.insert(arguments.begin(), "localize");
    arguments.insert(arguments.end(), {"--json", "-"});
    return Json::parse(output(arguments));
  }

  Folder folder_;
};

TEST_F(Cli, VersionAndHelp) {
  EXPECT_EQ(output({"--version"}).rfind("handhold ", 0), 0u);
  EXPECT_NE(output({"--help"}).find("localize"), std::string::npos);
  const std::string help = output({"localize", "--help"});
  Words flags = {"show-samples", "json",      "picture", "html",     "explain",     "print-options",
                 "config",       "viewpoint", "repeat",  "no-times", "hand ",       "depth ",
                 "fx",           "fy",        "cx",      "cy",       "depth-unit-m"};
  const Words options = option_names();
  flags.insert(flags.end(), options.begin(), options.end());
  for (std::string flag : flags) {
    std::replace(flag.begin(), flag.end(), '_', '-');
    EXPECT_NE(help.find("--" + flag), std::string::npos) << flag;
  }
}

TEST_F(Cli, FindsTheHandleOfACylinder) {
  const Json result = json({"cloud.pcd"});
  EXPECT_EQ(result["status"], "ok");
  ASSERT_FALSE(result["affordances"].empty());
  ASSERT_FALSE(result["handles"].empty());
  const Json& handle = result["handles"][0];
  EXPECT_NEAR(handle["center"][0].get<double>(), kCylinderCenter[0], 0.005);
  EXPECT_NEAR(handle["center"][2].get<double>(), kCylinderCenter[2], 0.005);
  EXPECT_NEAR(handle["radius"].get<double>(), kCylinderRadius, 0.003);
  EXPECT_GT(handle["axis"][1].get<double>(), 0.98);
}

TEST_F(Cli, JsonHasTheSchemaThatOtherProgramsRead) {
  const Json result = json({"cloud.pcd"});
  EXPECT_EQ(keys(result),
            (Words{"schema", "status", "backend", "cloud", "options", "funnel", "times_ms", "handles", "affordances"}));
  EXPECT_EQ(result["schema"], "handhold/1");
  EXPECT_EQ(keys(result["cloud"]), (Words{"points", "finite", "organized", "viewpoint"}));
  EXPECT_EQ(result["cloud"]["points"], cylinder().size());
  EXPECT_EQ(result["cloud"]["organized"], false);
  EXPECT_EQ(result["cloud"]["viewpoint"], (Json{0.0, 0.0, 0.0}));
  EXPECT_EQ(keys(result["options"]), option_names());
  EXPECT_EQ(result["funnel"]["samples"], 5000);
  for (const char* stage : {"index", "moments", "fit", "shell", "visibility", "handles", "total"}) {
    EXPECT_TRUE(result["times_ms"][stage].is_number()) << stage;
  }
  ASSERT_FALSE(result["handles"].empty());
  EXPECT_EQ(keys(result["handles"][0]), (Words{"center", "axis", "approach", "radius", "length", "confidence", "arc",
                                               "residual", "observed_free", "normal_error", "affordances"}));
  ASSERT_FALSE(result["affordances"].empty());
  EXPECT_EQ(keys(result["affordances"][0]), (Words{"center", "axis", "normal", "radius", "gap", "observed_free"}));
  for (const Json& index : result["handles"][0]["affordances"]) EXPECT_LT(index, result["affordances"].size());
}

TEST_F(Cli, JsonFileIsWhatStandardOutputWouldGet) {
  const std::string expected = output({"localize", "cloud.pcd", "--no-times", "--json", "-"});
  EXPECT_EQ(output({"localize", "cloud.pcd", "--no-times", "--json", "out.json"}), "");
  EXPECT_EQ(folder_.read("out.json"), expected);
  EXPECT_EQ(folder_.entries(), (Words{"cloud.pcd", "out.json"}));
}

TEST_F(Cli, SameBytesForEveryNumberOfThreads) {
  const std::string one = output({"localize", "cloud.pcd", "--no-times", "--json", "-", "--threads", "1"});
  EXPECT_NE(one.find("\"observed_free\""), std::string::npos) << "without affordances this test says nothing";
  for (const char* threads : {"2", "7"}) {
    EXPECT_EQ(output({"localize", "cloud.pcd", "--no-times", "--json", "-", "--threads", threads}), one) << threads;
  }
}

TEST_F(Cli, SeedsMatter) {
  const Words words = {"localize", "cloud.pcd", "--no-times", "--json", "-", "--seed"};
  Words first = words, second = words;
  first.push_back("1");
  second.push_back("2");
  EXPECT_EQ(output(first), output(first));
  EXPECT_FALSE(Json::parse(output(first))["affordances"] == Json::parse(output(second))["affordances"]);
}

TEST_F(Cli, NoTimesLeavesOutWhatDiffers) {
  const Json result = json({"cloud.pcd", "--no-times", "--repeat", "2"});
  EXPECT_FALSE(result.contains("times_ms"));
  EXPECT_FALSE(result.contains("times_p99_ms"));
  EXPECT_FALSE(result["options"].contains("threads"));
}

TEST_F(Cli, RepeatGivesMediansAndPercentiles) {
  const Json result = json({"cloud.pcd", "--repeat", "3"});
  EXPECT_EQ(keys(result["times_ms"]), keys(result["times_p99_ms"]));
  for (const auto& [stage, time] : result["times_ms"].items()) EXPECT_LE(time, result["times_p99_ms"][stage]) << stage;
  const std::string text = output({"localize", "cloud.pcd", "--repeat", "3"});
  EXPECT_NE(text.find("3 runs"), std::string::npos) << text;
  EXPECT_NE(text.find("moments"), std::string::npos) << text;
}

TEST(RunTimes, MedianAndNearestRank) {
  std::vector<StageTimes> runs(200);
  for (std::size_t i = 0; i < runs.size(); ++i)
    runs[i].fit = static_cast<double>((i * 77) % 200 + 1);  // 1 .. 200, shuffled
  EXPECT_EQ(summarize(runs).median_ms.fit, 100.5);
  EXPECT_EQ(summarize(runs).p99_ms.fit, 198);
  runs.resize(1);
  EXPECT_EQ(summarize(runs).median_ms.fit, summarize(runs).p99_ms.fit);
}

TEST_F(Cli, SummaryIsInMillimetres) {
  const std::string text = output({"localize", "cloud.pcd"});
  EXPECT_NE(text.find("cloud.pcd"), std::string::npos) << text;
  EXPECT_NE(text.find("radius mm"), std::string::npos) << text;
}

TEST_F(Cli, ExplainNamesStepsAndOptions) {
  const std::string text = output({"localize", "cloud.pcd", "--explain", "--hand-aperture", "0.02"});
  EXPECT_NE(text.find("of 5000 samples"), std::string::npos) << text;
  EXPECT_NE(text.find('%'), std::string::npos) << text;
  EXPECT_NE(text.find("what would change that"), std::string::npos) << text;
  EXPECT_NE(text.find("raise --"), std::string::npos) << text;
  // With JSON on standard output the words go elsewhere.
  const Outcome done = run_program({"localize", "cloud.pcd", "--explain", "--json", "-"}, folder_.path());
  EXPECT_FALSE(Json::parse(done.out).empty());
  EXPECT_NE(done.err.find("of 5000 samples"), std::string::npos) << done.err;
}

TEST_F(Cli, NoHandlesIsNoFailure) {
  EXPECT_EQ(json({"cloud.pcd", "--hand-aperture", "0.01"})["handles"], Json::array());
  EXPECT_NE(output({"localize", "cloud.pcd", "--hand-aperture", "0.01"}).find("no handles"), std::string::npos);
}

TEST_F(Cli, ListsEndBeforeTheCloudsName) {
  Json result = json({"--radius", "0.02", "0.03", "cloud.pcd", "--viewpoint", "-.1", "-0.2", "1e-1"});
  EXPECT_EQ(result["options"]["radius"], (Json{0.02, 0.03}));
  EXPECT_EQ(result["cloud"]["viewpoint"], (Json{-0.1, -0.2, 0.1}));
  result = json({"--viewpoint", "none", "cloud.pcd", "--workspace", "-1", "1", "-1", "1", "0", "2"});
  EXPECT_TRUE(result["cloud"]["viewpoint"].is_null());
  EXPECT_EQ(result["options"]["workspace"], (Json{-1.0, 1.0, -1.0, 1.0, 0.0, 2.0}));
}

TEST_F(Cli, PrecedenceIsDefaultsHandConfigFlags) {
  folder_.write("some.toml", "hand_aperture = 0.07\nsamples = 100\n");
  const auto aperture_and_samples = [&](Words words) {
    words.insert(words.begin(), "localize");
    words.push_back("--print-options");
    Options options;
    apply_toml(options, output(words), "printed");
    return std::pair(options.hand_aperture, options.samples);
  };
  const Options standard, baxter = Options::baxter();
  ASSERT_NE(baxter.hand_aperture, standard.hand_aperture);
  EXPECT_EQ(aperture_and_samples({}), std::pair(standard.hand_aperture, standard.samples));
  EXPECT_EQ(aperture_and_samples({"--hand", "baxter"}), std::pair(baxter.hand_aperture, baxter.samples));
  EXPECT_EQ(aperture_and_samples({"--config", "some.toml", "--hand", "baxter"}), std::pair(0.07, 100));
  EXPECT_EQ(aperture_and_samples({"--samples", "7", "--config", "some.toml"}), std::pair(0.07, 7));
}

TEST_F(Cli, PrintedOptionsReadBack) {
  const Words words = {"localize", "--print-options", "--reach", "0.07", "--radius", "0.02",
                       "0.03",     "--hand",          "baxter"};
  const std::string printed = output(words);
  folder_.write("printed.toml", printed);
  EXPECT_EQ(output({"localize", "--print-options", "--config", "printed.toml"}), printed);
}

TEST_F(Cli, EveryOptionIsAFlag) {
  // One value per type that every range admits; for names the ones that are not the default.
  const std::vector<Words> flags = {{"method", "paper"},
                                    {"samples", "77"},
                                    {"strategy", "uniform"},
                                    {"seed", "18446744073709551615"},
                                    {"proposal_sigma", "0.01"},
                                    {"workspace", "-1 1 -2 2 -3 3"},
                                    {"radius", "0.02 0.03"},
                                    {"min_neighbours", "44"},
                                    {"axis", "pca"},
                                    {"index", "grid"},
                                    {"hand_aperture", "0.09"},
                                    {"hand_minimum", "0.01"},
                                    {"finger_thickness", "0.011"},
                                    {"finger_width", "0.021"},
                                    {"finger_depth", "0.041"},
                                    {"min_free", "0.6"},
                                    {"reach", "0.06"},
                                    {"shell_gap_area_mm2", "13"},
                                    {"shell_inner_area_mm2", "101"},
                                    {"align_angle", "0.3"},
                                    {"align_offset", "0.011"},
                                    {"align_radius", "0.006"},
                                    {"handle_gap", "0.016"},
                                    {"handle_min_affordances", "4"},
                                    {"handle_min_length", "0.03"},
                                    {"min_confidence", "0.25"},
                                    {"deadline_ms", "12.5"},
                                    {"backend", "auto"},
                                    {"threads", "3"}};
  const std::string defaults = output({"localize", "--print-options"});
  Words seen;
  for (const Words& flag : flags) {
    seen.push_back(flag[0]);
    std::string name = "--" + flag[0];
    std::replace(name.begin(), name.end(), '_', '-');
    Options expected, printed;
    set_option(expected, flag[0], flag[1]);
    const std::string text = output({"localize", "--print-options", name + "=" + flag[1]});
    EXPECT_EQ(text, to_toml(expected)) << name;
    EXPECT_NE(text, defaults) << name;
  }
  EXPECT_EQ(seen, option_names()) << "a new option needs a line here";
}

TEST_F(Cli, DepthImageIsAnOrganizedCloud) {
  folder_.write("depth.png", depth_png());
  const Json result = json({"--depth", "depth.png", "--fx", "300", "--fy", "300", "--cx", "79.5", "--cy", "59.5",
                            "--depth-unit-m", "0.001"});
  EXPECT_EQ(result["cloud"]["organized"], true);
  EXPECT_EQ(result["cloud"]["points"], 160 * 120);
  EXPECT_GT(result["cloud"]["finite"], 500);
}

TEST_F(Cli, PlyIsRead) {
  folder_.write("cloud.ply", ascii_ply(cylinder()));
  EXPECT_EQ(json({"cloud.ply"})["cloud"]["finite"], cylinder().size());
}

TEST_F(Cli, PictureIsAPng) {
  EXPECT_NE(output({"localize", "cloud.pcd", "--picture", "out.png"}), "");
  EXPECT_EQ(folder_.read("out.png").rfind("\x89PNG\r\n\x1a\n", 0), 0u);
  EXPECT_EQ(folder_.entries(), (Words{"cloud.pcd", "out.png"}));
}

TEST_F(Cli, PictureShowsTheSamplesWhenAsked) {
  output({"localize", "cloud.pcd", "--picture", "plain.png"});
  output({"localize", "cloud.pcd", "--picture", "samples.png", "--show-samples"});
  output({"localize", "cloud.pcd", "--picture", "again.png", "--show-samples", "--threads", "1"});
  EXPECT_NE(folder_.read("plain.png"), folder_.read("samples.png"));
  EXPECT_EQ(folder_.read("again.png"), folder_.read("samples.png"));
}

TEST_F(Cli, OutputReplacesAFileAndKeepsItsModeAndLinks) {
  folder_.write("real.json", "old");
  ::chmod((folder_.path() / "real.json").c_str(), 0640);
  std::filesystem::create_symlink("real.json", folder_.path() / "link.json");
  output({"localize", "cloud.pcd", "--json", "link.json"});
  EXPECT_TRUE(std::filesystem::is_symlink(folder_.path() / "link.json"));
  EXPECT_EQ(Json::parse(folder_.read("real.json"))["schema"], "handhold/1");
  struct stat info {};
  ::stat((folder_.path() / "real.json").c_str(), &info);
  EXPECT_EQ(info.st_mode & 0777, 0640u);
}

TEST_F(Cli, DevicesAreWrittenNotReplaced) {
  output({"localize", "cloud.pcd", "--json", "/dev/null"});
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST_F(Cli, ScalarKernelsCanBeForced) {
  Surroundings around;
  around.environment = {{"HANDHOLD_ISA", "scalar"}};
  EXPECT_FALSE(Json::parse(output({"localize", "cloud.pcd", "--json", "-"}, around))["affordances"].empty());
}

}  // namespace
}  // namespace handhold::test
