// The node's parameters: names, layers, what is refused and what stays then.
#include "settings.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "handhold/device.h"
#include "handhold/option_text.h"

namespace handhold::ros_bridge {
namespace {

using Problems = std::vector<std::string>;

Settings read(const Texts& texts, Problems& problems, const Settings& good = {}, const ArmOptions& arm = nullptr) {
  problems.clear();
  return read_settings(texts, good, "/node", arm, problems);
}

TEST(Settings, EveryOptionIsAParameter) {
  Problems problems;
  Texts texts;
  const Options defaults;
  for (const std::string& name : option_names()) texts[name] = get_option(defaults, name);
  texts["hand_aperture"] = "0.07";
  const Settings s = read(texts, problems);
  EXPECT_EQ(problems, Problems());
  for (const std::string& name : option_names()) {
    EXPECT_EQ(get_option(s.options, name), name == "hand_aperture" ? "0.07" : get_option(defaults, name)) << name;
  }
}

TEST(Settings, TheNodesOwn) {
  Problems problems;
  const Settings s = read({{"workspace_frame", "table"},
                           {"viewpoint_frame", "none"},
                           {"fixed_frame", "odom"},
                           {"base_frame", "torso"},
                           {"track", "false"},
                           {"transform_timeout", "0"},
                           {"input_timeout", "2.5"},
                           {"diagnostics_period", "0.5"}},
                          problems);
  EXPECT_EQ(problems, Problems());
  EXPECT_EQ(s.workspace_frame, "table");
  EXPECT_EQ(s.viewpoint_frame, "none");
  EXPECT_EQ(s.fixed_frame, "odom");
  EXPECT_EQ(s.base_frame, "torso");
  EXPECT_FALSE(s.track);
  EXPECT_EQ(s.transform_timeout, 0);
  EXPECT_EQ(s.input_timeout, 2.5);
  EXPECT_EQ(s.diagnostics_period, 0.5);
}

TEST(Settings, WhatIsWrongStaysAsItWas) {
  Problems problems;
  Settings good;
  good.options.samples = 77;
  good.options.finger_width = 0.013;
  good.track = false;
  good.input_timeout = 9;
  const Settings s = read({{"samples", "many"},
                           {"finger_width", "-1"},
                           {"hand_aperture", "0.07"},
                           {"hand_apertur", "0.06"},
                           {"zzzzzzzz", "1"},
                           {"track", "yes"},
                           {"input_timeout", "-3"},
                           {"hand", "pr2"}},
                          problems, good);
  EXPECT_EQ(s.options.samples, 77);
  EXPECT_EQ(s.options.finger_width, 0.013);
  EXPECT_EQ(s.options.hand_aperture, 0.07);
  EXPECT_FALSE(s.track);
  EXPECT_EQ(s.input_timeout, 9);
  EXPECT_EQ(s.hand, "");
  ASSERT_EQ(problems.size(), 7u);
  const Problems expected = {
      "parameter /node/hand = 'pr2': must be 'baxter', or empty",
      "parameter /node/track = 'yes': must be true or false",
      "parameter /node/input_timeout = '-3': must be from 0.1 to 3600 s",
      "unknown parameter /node/hand_apertur; did you mean 'hand_aperture'?",
      "unknown parameter /node/zzzzzzzz; parameters are the names of options, as in hand_aperture",
      "parameter /node/samples = 'many': must be a whole number",
      "parameter /node/finger_width = -1"};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(problems[i].substr(0, expected[i].size()), expected[i]);
  // Nothing that was refused is in them.
  EXPECT_NO_THROW(s.options.validate());
}

TEST(Settings, OptionsThatDoNotGoTogetherStayAsTheyWere) {
  Problems problems;
  const Settings s = read({{"hand_minimum", "0.2"}}, problems);
  EXPECT_EQ(problems.size(), 1u);
  EXPECT_NO_THROW(s.options.validate());
  EXPECT_LT(s.options.hand_minimum, s.options.hand_aperture);
}

TEST(Settings, AGpuThatIsNotThereIsAProblem) {
  Problems problems;
  EXPECT_EQ(read({{"backend", "auto"}}, problems).options.backend, Backend::kAuto);
  EXPECT_EQ(problems, Problems());
  const CudaDevice device = cuda_device();
  if (device.available) GTEST_SKIP() << "there is a GPU here: " << device.name;
  Settings good;
  for (const Backend last : {Backend::kCpu, Backend::kAuto}) {
    good.options.backend = last;
    const Settings s = read({{"backend", "cuda"}, {"samples", "77"}}, problems, good);
    EXPECT_EQ(problems,
              Problems{"parameter /node/backend = cuda: " + device.reason + "; use 'cpu', or 'auto' to fall back"});
    EXPECT_EQ(s.options.backend, last);
    EXPECT_EQ(s.options.samples, 77);
  }
  // A GPU that went away between two readings.
  good.options.backend = Backend::kCuda;
  EXPECT_EQ(read({{"backend", "cuda"}}, problems, good).options.backend, Backend::kAuto);
  EXPECT_EQ(problems.size(), 1u);
}

TEST(Settings, HandThenFileThenParameters) {
  const std::string path = ::testing::TempDir() + "handhold_settings_" + std::to_string(::getpid()) + ".toml";
  std::ofstream(path) << "finger_width = 0.017\nhand_minimum = 0.03\n";
  Problems problems;
  Settings s = read({{"hand", "baxter"}, {"config", path}, {"hand_minimum", "0.02"}}, problems);
  EXPECT_EQ(problems, Problems());
  EXPECT_EQ(s.options.hand_aperture, Options::baxter().hand_aperture);
  EXPECT_EQ(s.options.finger_width, 0.017);
  EXPECT_EQ(s.options.hand_minimum, 0.02);

  // A file with a mistake is refused as a whole.
  std::ofstream(path) << "finger_width = 0.019\nfinger_widht = 0.018\n";
  s = read({{"config", path}}, problems, s);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0],
            "parameter /node/config: " + path + ", line 2: unknown key 'finger_widht'; did you mean 'finger_width'?");
  EXPECT_EQ(s.options.finger_width, 0.017);
  std::remove(path.c_str());
}

TEST(Settings, AnArmsHandIsTheDefault) {
  Problems problems;
  const ArmOptions arm = [](const Texts& texts) {
    if (texts.at("arm") != "long") throw std::invalid_argument("arm: unknown name");
    Options options;
    options.hand_aperture = 0.06;
    return options;
  };
  const Settings good = read({{"arm", "long"}, {"slot", ""}, {"grasps", "2"}}, problems, {}, arm);
  EXPECT_EQ(problems, Problems());
  EXPECT_EQ(good.options.hand_aperture, 0.06);
  EXPECT_EQ(good.arm, (Texts{{"arm", "long"}, {"grasps", "2"}}));
  EXPECT_EQ(read({{"arm", "long"}, {"hand_aperture", "0.05"}}, problems, {}, arm).options.hand_aperture, 0.05);
  // One that cannot be: the last good one stays.
  const Settings bad = read({{"arm", "short"}}, problems, good, arm);
  EXPECT_EQ(problems, Problems{"parameter /node/arm: unknown name"});
  EXPECT_EQ(bad.arm, good.arm);
  EXPECT_EQ(bad.options.hand_aperture, 0.06);
  // A program that cannot plan says so.
  EXPECT_TRUE(read({{"arm", "long"}}, problems).arm.empty());
  EXPECT_EQ(problems.size(), 1u);
}

}  // namespace
}  // namespace handhold::ros_bridge
