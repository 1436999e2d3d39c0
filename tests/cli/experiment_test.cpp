// handhold experiment: what it writes, on settings that take no time, and what it refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "experiment_fixture.h"
#include "process.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

TEST_F(Experiment, Help) {
  const std::string help = output({"--help"});
  for (const char* name : {"fig8", "fig9", "axis", "density", "tracking", "table1", "table2"}) {
    EXPECT_NE(help.find(name), std::string::npos) << name;
    const std::string own = output({name, "--help"});
    EXPECT_NE(own.find("Usage: handhold experiment " + std::string(name)), std::string::npos) << own;
    for (const char* flag : {"--runs", "--seed", "--threads", "--output", "--csv", "--json", "--plot"}) {
      EXPECT_NE(own.find(flag), std::string::npos) << name << " " << flag;
    }
  }
}

TEST_F(Experiment, Fig8TimesTheStagesOfACloud) {
  folder_.write("cloud.pcd", binary_pcd(cylinder()));
  const std::string text = output({"fig8", "cloud.pcd", "--samples", "300", "--runs", "2", "--threads", "2", "--json",
                                   "8.json", "--csv", "8.csv", "--plot", "8.png"});
  EXPECT_NE(text.find("method paper, 300 samples, uniform"), std::string::npos) << text;
  const Json result = json("8.json");
  EXPECT_EQ(result["samples"], 300);
  EXPECT_EQ(result["runs"], 2);
  EXPECT_EQ(result["threads"], 1) << "what stands at the top is the paper's figure";
  EXPECT_EQ(result["points"], cylinder().size());
  ASSERT_EQ(result["by_threads"].size(), 2u);
  EXPECT_EQ(result["by_threads"][1]["threads"], 2);
  EXPECT_EQ(result["by_threads"][0]["total_ms"], result["total_ms"]);
  double sum = 0;
  for (const char* stage : {"index", "samples", "neighbours", "moments", "fit", "shell", "visibility", "handles"}) {
    ASSERT_TRUE(result["stages_ms"].contains(stage)) << stage;
    sum += result["stages_ms"][stage].get<double>();
  }
  EXPECT_EQ(result["stages_ms"].size(), 8u);
  EXPECT_GT(sum, 0);
  EXPECT_LE(sum, 1.01 * result["total_ms"].get<double>()) << "stages are parts of the frame";
  EXPECT_EQ(lines("8.csv").size(), 1 + 2 * 9u);
  expect_png("8.png");

  output({"fig8", "cloud.pcd", "--samples", "300", "--runs", "1", "--threads", "1", "--method", "default", "--strategy",
          "max", "--json", "1.json"});
  EXPECT_EQ(json("1.json")["by_threads"].size(), 1u);
  EXPECT_EQ(json("1.json")["method"], "default");
  EXPECT_EQ(json("1.json")["strategy"], "max");
}

TEST_F(Experiment, Fig8TakesASceneOfThePaperWithoutACloud) {
  const Json result =
      Json::parse(experiment({"fig8", "--samples", "200", "--runs", "1", "--threads", "1", "--json", "-"}).out);
  EXPECT_EQ(result["cloud"], "paper_1");
  EXPECT_EQ(result["points"], 640 * 480);
}

TEST_F(Experiment, Fig9CountsWhatEachStrategyFinds) {
  const Words words = {"fig9", "--scenes", "1,7", "--samples", "700,800", "--uniform-samples",
                       "900",  "--runs",   "2",   "--seed",    "5"};
  Words first = words, again = words;
  first.insert(first.end(), {"-o", "new/out", "--threads", "1"});
  again.insert(again.end(), {"--json", "again.json", "--csv", "again.csv", "--plot", "again.png", "--threads", "2"});
  const std::string text = output(first);
  EXPECT_EQ(output(again), text);
  for (const char* ending : {".json", ".csv", ".png"}) {
    EXPECT_EQ(folder_.read("new/out/fig9" + std::string(ending)), folder_.read("again" + std::string(ending)))
        << ending << ": the same bytes for every number of threads";
  }
  expect_png("again.png");

  const Json result = json("again.json");
  EXPECT_EQ(result["method"], "default");
  ASSERT_EQ(result["scenes"].size(), 2u);
  EXPECT_EQ(result["scenes"][0]["name"], "paper_1");
  EXPECT_EQ(result["scenes"][0]["handles"], 5);
  EXPECT_EQ(result["scenes"][1]["name"], "paper_7");
  EXPECT_EQ(result["scenes"][1]["handles"], 10);
  Words settings;
  double found = 0;
  for (const Json& scene : result["scenes"]) {
    settings.clear();
    for (const Json& r : scene["results"]) {
      settings.push_back(r["strategy"].get<std::string>() + " " + std::to_string(r["samples"].get<int>()));
      EXPECT_EQ(r["runs"], 2);
      const double mean = r["mean"], std = r["std"];
      found += mean;
      EXPECT_LE(mean, scene["handles"].get<double>());
      // Of two runs: half their distance from each other, times the root of two.
      EXPECT_NEAR(std / std::sqrt(2) * 2, std::round(std / std::sqrt(2) * 2), 1e-9);
      if (r["all_found_runs"] == 2) {
        EXPECT_EQ(mean, scene["handles"].get<double>());
      }
    }
  }
  EXPECT_EQ(settings, (Words{"uniform 700", "sum 700", "max 700", "uniform 800", "sum 800", "max 800", "uniform 900"}));
  EXPECT_GT(found, 0);
  EXPECT_EQ(lines("again.csv").size(), 1 + 2 * 7u);
  EXPECT_NE(text.find("together      15"), std::string::npos) << text;
}

TEST_F(Experiment, AxisComparesTheEstimators) {
  output({"axis", "--scenes", "cylinders", "--noise", "0,1", "--samples", "20", "-o", "."});
  EXPECT_EQ(folder_.entries(), (Words{"axis.csv", "axis.json", "axis.png"}));
  expect_png("axis.png");
  EXPECT_EQ(lines("axis.csv").size(), 1 + 2 * 3u);
  const Json results = json("axis.json")["results"];
  ASSERT_EQ(results.size(), 6u);
  const auto of = [&](double noise, const char* axis) {
    for (const Json& r : results) {
      if (r["noise"] == noise && r["axis"] == axis) return r;
    }
    ADD_FAILURE() << axis << " at " << noise;
    return Json();
  };
  for (const char* axis : {"taubin", "normals", "pca"}) {
    const Json exact = of(0, axis), noisy = of(1, axis);
    EXPECT_GT(exact["neighbourhoods"], 200) << "12 cylinders, 20 each";
    EXPECT_GE(exact["p90_deg"], exact["median_deg"]);
    EXPECT_GT(noisy["median_deg"], exact["median_deg"]) << axis;
    EXPECT_GT(exact["with_axis"], 0.9);
    EXPECT_GT(exact["affordances"], 0.5) << "nothing stands beside these cylinders";
    EXPECT_LE(exact["affordances"], 1);
    EXPECT_GT(exact["us_per_neighbourhood"], 0);
  }
  // A cylinder is a quadric: without noise the fit is exact wherever it is well conditioned.
  EXPECT_LT(of(0, "taubin")["median_deg"], 0.1);
  EXPECT_GT(of(0, "normals")["ms_per_cloud"], 0);
  EXPECT_EQ(of(0, "taubin")["ms_per_cloud"], 0);
}

TEST_F(Experiment, DensityHasTwoCurves) {
  const Words words = {"density", "--random",  "1", "--families",  "tuning", "--seed",    "3",   "--shares",
                       "1,0.25",  "--singles", "2", "--distances", "0.6,1",  "--samples", "1000"};
  Words first = words, again = words;
  first.insert(first.end(), {"-o", "out", "--threads", "1"});
  again.insert(again.end(), {"-o", "again", "--threads", "2"});
  EXPECT_EQ(output(again), output(first));
  for (const char* name : {"density.json", "density.csv", "density.png"}) {
    EXPECT_EQ(folder_.read("out/" + std::string(name)), folder_.read("again/" + std::string(name)));
  }
  expect_png("out/density.png");
  EXPECT_EQ(lines("out/density.csv").size(), 1 + 2 + 2u);
  const Json result = json("out/density.json");
  const Json &thinned = result["thinned"], &distances = result["distances"];
  ASSERT_EQ(thinned.size(), 2u);
  ASSERT_EQ(distances.size(), 2u);
  EXPECT_EQ(thinned[0]["share"], 1);
  EXPECT_NEAR(thinned[1]["points"].get<double>() / thinned[0]["points"].get<double>(), 0.25, 0.005);
  EXPECT_EQ(thinned[1]["needed"], thinned[0]["needed"]) << "the truth is that of the whole cloud";
  EXPECT_GT(thinned[0]["needed"], 0);
  EXPECT_EQ(distances[1]["distance_m"], 1);
  EXPECT_EQ(distances[0]["scenes"], 2);
  for (const Json* curve : {&thinned, &distances}) {
    for (const Json& point : *curve) {
      EXPECT_LE(point["found"], point["needed"]);
      EXPECT_LE(point["right"], point["handles"]);
      if (point["needed"] > 0) {
        EXPECT_DOUBLE_EQ(point["recall"], point["found"].get<double>() / point["needed"].get<double>());
      }
    }
  }
}

TEST_F(Experiment, TrackingComparesThreeWays) {
  const Words words = {"tracking", "--random",  "1",   "--families", "tuning", "--seed",  "3",  "--frames",
                       "8",        "--samples", "800", "--few",      "400",    "--sweep", "0.2"};
  Words first = words, again = words;
  first.insert(first.end(), {"-o", "out", "--threads", "1"});
  again.insert(again.end(), {"-o", "again", "--threads", "2"});
  EXPECT_EQ(output(again), output(first));
  EXPECT_EQ(folder_.read("out/tracking.csv"), folder_.read("again/tracking.csv"));
  expect_png("out/tracking.png");
  const Json result = json("out/tracking.json");
  ASSERT_EQ(result["ways"].size(), 3u);
  EXPECT_EQ(result["ways"][0]["samples"], 800);
  EXPECT_EQ(result["ways"][1]["samples"], 400);
  EXPECT_EQ(result["ways"][2]["tracked"], true);
  for (const Json& way : result["ways"]) {
    EXPECT_EQ(way["needed"], result["ways"][0]["needed"]);
    EXPECT_LE(way["found"], way["needed"]);
  }
  EXPECT_GT(result["ways"][0]["needed"], 0);
  expect_refusal({"tracking", "--frames", "5"}, 2, {"--frames = '5'", "6 to"});
  expect_refusal({"tracking", "--sweep", "x"}, 2, {"--sweep = 'x'"});
}

TEST_F(Experiment, WrongUse) {
  expect_refusal({}, 2, {"no experiment given", "fig9"});
  expect_refusal({"fig99"}, 2, {"unknown subcommand 'fig99'", "fig9"});
  expect_refusal({"fig9", "more"}, 2, {"'more'", "handhold experiment fig9 --help"});
  for (const char* name : {"fig8", "fig9", "axis", "density", "tracking"}) {
    expect_refusal({name, "--run", "2"}, 2, {"unknown option '--run'", "did you mean '--runs'"});
    expect_refusal({name, "--runs", "0"}, 2, {"--runs = '0'", "1 to"});
    expect_refusal({name, "--seed", "-1"}, 2, {"--seed", "whole number"});
    expect_refusal({name, "--threads", "many"}, 2, {"--threads = 'many'"});
    expect_refusal({name, "--samples", "0"}, 2, {"--samples = '0'"});
    expect_refusal({name, "--csv", "no/such/folder.csv"}, 1, {"'no/such/folder.csv'"});
    expect_refusal({name, "--plot", "-"}, 2, {"--plot"});
    expect_refusal({name, "--csv", "same", "--json", "same"}, 2, {"'same'"});
  }
  for (const char* name : {"fig8", "fig9", "density"}) {
    expect_refusal({name, "--method", "best"}, 2, {"--method = 'best'", "'paper'"});
  }
  expect_refusal({"fig8", "none.pcd"}, 1, {"none.pcd"});
  expect_refusal({"fig8", "--strategy", "all"}, 2, {"--strategy = 'all'", "'uniform'"});
  expect_refusal({"fig9", "--scenes", "8"}, 2, {"--scenes = '8'", "1 to 7"});
  expect_refusal({"fig9", "--scenes", "1.5"}, 2, {"--scenes = '1.5'", "whole numbers"});
  expect_refusal({"fig9", "--samples", "2000,many"}, 2, {"--samples", "many"});
  expect_refusal({"fig9", "--samples", "50,50"}, 2, {"--samples = '50,50'"});
  expect_refusal({"axis", "--noise", "-1"}, 2, {"--noise = '-1'", "0 to 20"});
  expect_refusal({"axis", "--radius", "1"}, 2, {"--radius = '1'", "m"});
  expect_refusal({"axis", "--scenes", "mugs"}, 2, {"--scenes = 'mugs'", "cylinders or parts"});
  expect_refusal({"density", "--shares", "0"}, 2, {"--shares = '0'"});
  expect_refusal({"density", "--distances", "0.5,9"}, 2, {"--distances", "0.3 to 5 m"});
  expect_refusal({"density", "--families", "mugg"}, 2, {"--families", "mugg"});
  expect_refusal({"density", "--singles", "145"}, 2, {"--singles", "144"});
  folder_.write("file", "");
  expect_refusal({"fig9", "-o", "file"}, 1, {"'file'"});
}

TEST_F(Experiment, ACloudThatCannotBeSearched) {
  folder_.write("empty.pcd", binary_pcd({}));
  expect_refusal({"fig8", "empty.pcd", "--json", "out.json"}, 1, {"'empty.pcd'", "empty"});
}

}  // namespace
}  // namespace handhold::test
