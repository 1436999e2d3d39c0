// handhold stream: depth images, and OpenNI2's recordings of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "oni_file.h"
#include "process.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

constexpr int kFrames = 4;

std::string exactly(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

class DepthStream : public ::testing::Test {
 protected:
  void SetUp() override {
    // A cylinder that moves 4 mm a frame.
    for (int i = 0; i < kFrames; ++i) recording_.frames.push_back(depth_image(0.004 * i));
    recording_.h_fov = 2 * std::atan(80.0 / 300);
    recording_.v_fov = 2 * std::atan(60.0 / 300);
    write_images();
  }
  void write_images() const {
    std::filesystem::create_directories(folder_.path() / "depth");
    for (int i = 0; i < kFrames; ++i) folder_.write("depth/" + std::to_string(i) + ".png", png(recording_.frames[i]));
  }
  Outcome run(Words arguments) const {
    arguments.insert(arguments.begin(), "stream");
    arguments.insert(arguments.end(), {"--samples", "300"});
    return run_program(arguments, folder_.path());
  }
  /// The camera of the recording, which holds the fields of view as floats.
  Words camera() const {
    const double fx = 80 / std::tan(static_cast<double>(static_cast<float>(recording_.h_fov)) / 2);
    const double fy = 60 / std::tan(static_cast<double>(static_cast<float>(recording_.v_fov)) / 2);
    return {"--fx", exactly(fx), "--fy", exactly(fy), "--cx", "79.5", "--cy", "59.5", "--depth-unit-m", "0.001"};
  }
  Words with_camera(Words words) const {
    const Words flags = camera();
    words.insert(words.end(), flags.begin(), flags.end());
    return words;
  }
  /// A line for each frame. Nothing is said but the summary.
  std::vector<Json> frames(Words arguments) const {
    arguments.insert(arguments.end(), {"--no-times", "--json", "-"});
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    return lines(outcome.out);
  }
  static std::vector<Json> lines(const std::string& text) {
    std::vector<Json> all;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) all.push_back(Json::parse(line));
    return all;
  }
  void expect_line(const Words& arguments, int code, const Words& what) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, code) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    for (const std::string& part : what) EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
  }

  Folder folder_;
  OniRecording recording_;
};

TEST_F(DepthStream, FollowsAHandleThroughDepthImages) {
  const std::vector<Json> all = frames(with_camera({"depth"}));
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    const Json& frame = all[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame["source"], "depth/" + std::to_string(i) + ".png");
    EXPECT_EQ(frame["status"], "ok");
    ASSERT_EQ(frame["tracks"].size(), 1u) << i;
    EXPECT_EQ(frame["tracks"][0]["id"], 1);
    EXPECT_NEAR(frame["tracks"][0]["center"][0].get<double>(), 0.004 * i, 0.008);
    EXPECT_NEAR(frame["tracks"][0]["center"][2].get<double>(), kCylinderCenter[2], 0.008);
  }
}

TEST_F(DepthStream, TakesAListOfDepthImages) {
  folder_.write("list.txt", "# backwards\ndepth/3.png\ndepth/1.png\n");
  const std::vector<Json> all = frames(with_camera({"list.txt"}));
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0]["source"], "depth/3.png");
  EXPECT_EQ(all[1]["source"], "depth/1.png");
}

TEST_F(DepthStream, ADamagedImageIsReportedAndPassedOver) {
  folder_.write("depth/2.png", depth_png().substr(0, 100));
  const Outcome outcome = run(with_camera({"depth", "--json", "frames.jsonl"}));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err.rfind("handhold: ", 0), 0u) << outcome.err;
  EXPECT_NE(outcome.err.find("2.png"), std::string::npos) << outcome.err;
  const std::vector<Json> all = lines(folder_.read("frames.jsonl"));
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(all[2]["status"], "unreadable");
  EXPECT_EQ(all[3]["status"], "ok");
}

TEST_F(DepthStream, PicturesBesideCloudsAreNoFrames) {
  std::filesystem::create_directories(folder_.path() / "clouds");
  folder_.write("clouds/0.pcd", binary_pcd(cylinder()));
  folder_.write("clouds/0.png", depth_png());
  const Outcome outcome = run({"clouds"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out.rfind("1 frames of 1 searched", 0), 0u) << outcome.out;
}

TEST_F(DepthStream, WrongUseIsOneLine) {
  expect_line({"depth"}, 2, {"'depth'", "depth images", "--fx"});
  for (std::size_t left_out = 0; left_out < camera().size(); left_out += 2) {
    Words words = with_camera({"depth"});
    const std::string flag = words[1 + left_out];
    words.erase(words.begin() + 1 + static_cast<int>(left_out), words.begin() + 3 + static_cast<int>(left_out));
    expect_line(words, 2, {"'depth'", flag});
    words.insert(words.end(), {flag, "far"});
    expect_line(words, 2, {flag + " = 'far'"});
  }
  expect_line(with_camera({"depth/0.png"}), 2, {"'depth/0.png'", "handhold localize --depth"});

  std::filesystem::create_directories(folder_.path() / "clouds");
  folder_.write("clouds/0.pcd", binary_pcd(cylinder()));
  expect_line(with_camera({"clouds"}), 2, {"--fx", "'clouds'", "depth images"});
  folder_.write("clouds/1.png", depth_png());
  expect_line(with_camera({"clouds"}), 2, {"'clouds'", "clouds and PNGs"});
  folder_.write("list.txt", "depth/0.png\nclouds/0.pcd\n");
  expect_line(with_camera({"list.txt"}), 2, {"'list.txt'", "clouds and PNGs"});
  std::filesystem::create_directories(folder_.path() / "empty");
  expect_line({"empty"}, 1, {"'empty'", ".png"});
}

#ifdef HANDHOLD_WITH_OPENNI2

TEST_F(DepthStream, ARecordingGivesTheHandlesOfItsDepthImages) {
  folder_.write("film.oni", oni_file(recording_));
  const std::vector<std::string> before = folder_.entries();
  const std::vector<Json> images = frames(with_camera({"depth"}));
  std::vector<Json> played = frames({"film.oni"});
  EXPECT_EQ(folder_.entries(), before) << "OpenNI2 leaves no file";
  ASSERT_EQ(played.size(), images.size());
  for (std::size_t i = 0; i < played.size(); ++i) {
    EXPECT_EQ(played[i]["source"], "film.oni");
    EXPECT_EQ(played[i]["handles"].size(), 1u);
    played[i]["source"] = images[i]["source"];
    EXPECT_EQ(played[i], images[i]);
  }
}

TEST_F(DepthStream, ARecordingIsPlayedAtARate) {
  folder_.write("film.oni", oni_file(recording_));
  const Outcome outcome = run({"film.oni", "--rate-hz", "20"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find(" frames of 4 searched"), std::string::npos) << outcome.out;
}

TEST_F(DepthStream, AMirroredRecordingIsTurnedBack) {
  const std::vector<Json> images = frames(with_camera({"depth"}));
  for (DepthImage& image : recording_.frames) {
    for (auto row = image.values.begin(); row != image.values.end(); row += image.width) {
      std::reverse(row, row + image.width);
    }
  }
  recording_.mirrored = true;
  folder_.write("film.oni", oni_file(recording_));
  const std::vector<Json> played = frames({"film.oni"});
  ASSERT_EQ(played.size(), images.size());
  for (std::size_t i = 0; i < played.size(); ++i) EXPECT_EQ(played[i]["handles"], images[i]["handles"]);
}

TEST_F(DepthStream, ARecordingMayHoldTenthsOfMillimetres) {
  for (DepthImage& image : recording_.frames) {
    for (std::uint16_t& value : image.values) value = static_cast<std::uint16_t>(10 * value);
  }
  recording_.tenths = true;
  folder_.write("film.oni", oni_file(recording_));
  const std::vector<Json> played = frames({"film.oni"});
  ASSERT_EQ(played.size(), static_cast<std::size_t>(kFrames));
  for (const Json& frame : played) {
    ASSERT_EQ(frame["handles"].size(), 1u);
    EXPECT_NEAR(frame["handles"][0]["center"][2].get<double>(), kCylinderCenter[2], 0.008);
  }
}

TEST_F(DepthStream, ACutOffRecordingIsSearchedUpToThere) {
  const std::string whole = oni_file(recording_);
  folder_.write("cut.oni", whole.substr(0, whole.size() - 1000));
  const Outcome outcome = run({"cut.oni", "--json", "frames.jsonl"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err.rfind("handhold: error: the recording 'cut.oni' breaks off after 3 of 4 frames", 0), 0u)
      << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_EQ(lines(folder_.read("frames.jsonl")).size(), 3u);
}

TEST_F(DepthStream, ARecordingWithFewerFramesThanItClaimsIsReported) {
  recording_.announced = 6;
  folder_.write("film.oni", oni_file(recording_));
  const Outcome outcome = run({"film.oni"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("breaks off after 4 of 6 frames"), std::string::npos) << outcome.err;
}

TEST_F(DepthStream, ADamagedFrameOfARecordingIsPassedOver) {
  recording_.frames[1].values.resize(100);
  folder_.write("film.oni", oni_file(recording_));
  const Outcome outcome = run({"film.oni", "--json", "frames.jsonl"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("frame 2 of 'film.oni' is damaged"), std::string::npos) << outcome.err;
  const std::vector<Json> all = lines(folder_.read("frames.jsonl"));
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(all[1]["status"], "unreadable");
  EXPECT_EQ(all[2]["status"], "ok");
}

TEST_F(DepthStream, WhatIsNoRecordingIsOneLine) {
  expect_line({"none.oni"}, 1, {"'none.oni'", "No such file"});
  folder_.write("text.oni", "not a recording\n");
  expect_line({"text.oni"}, 1, {"'text.oni'", "no OpenNI recording"});
  folder_.write("empty.oni", "");
  expect_line({"empty.oni"}, 1, {"'empty.oni'", "no OpenNI recording"});
  folder_.write("head.oni", oni_file(recording_).substr(0, 20));
  expect_line({"head.oni"}, 1, {"'head.oni'", "damaged"});
  folder_.write("cut.oni", oni_file(recording_).substr(0, 200));
  expect_line({"cut.oni"}, 1, {"'cut.oni'", "cannot be opened"});
  folder_.write("film.oni", oni_file(recording_));
  expect_line(with_camera({"film.oni"}), 2, {"--fx", "'film.oni'"});
  expect_line({"openni2:film.oni"}, 2, {"'film.oni' is a recording"});
  recording_.h_fov = 0;
  folder_.write("blind.oni", oni_file(recording_));
  expect_line({"blind.oni"}, 1, {"'blind.oni'", "field of view"});
  recording_.depth = false;
  folder_.write("infrared.oni", oni_file(recording_));
  expect_line({"infrared.oni"}, 1, {"'infrared.oni'", "no depth stream"});
}

TEST_F(DepthStream, ARecordingWithWrongSizesIsRefused) {
  // The first record's header: magic, type, node, bytes with its fields, bytes of its payload; 4 bytes each.
  for (const std::size_t at : {24, 28, 32, 36, 40}) {
    std::string bytes = oni_file(recording_);
    bytes.replace(at, 4, "\xff\xff\xff\x7f");
    folder_.write("film.oni", bytes);
    expect_line({"film.oni"}, 1, {"'film.oni' is damaged", "record at byte 24"});
  }
  // The size of its name, and a letter of it.
  for (const std::size_t at : {52, 56}) {
    std::string bytes = oni_file(recording_);
    bytes[at] = '\xff';
    folder_.write("film.oni", bytes);
    expect_line({"film.oni"}, 1, {"'film.oni' is damaged", "record at byte 24"});
  }
}

TEST_F(DepthStream, WithoutADeviceThereIsOneLine) {
  expect_line({"openni2:nowhere"}, 1, {"'nowhere'", "cannot be opened"});
  // Where there is one, the next step fails.
  const Outcome first = run({"openni2:", "--json", "no/such/folder.jsonl"});
  EXPECT_EQ(first.exit_code, 1);
  EXPECT_EQ(std::count(first.err.begin(), first.err.end(), '\n'), 1) << first.err;
  EXPECT_TRUE(first.err.find("finds no device") != std::string::npos ||
              first.err.find("no/such/folder.jsonl") != std::string::npos)
      << first.err;
  expect_line({"openni2:", "--rate-hz", "30"}, 2, {"--rate-hz", "its own rate"});
  expect_line(with_camera({"openni2:"}), 2, {"--fx"});
}

#else

TEST_F(DepthStream, WithoutOpenNi2ItsSourcesAreRefused) {
  for (const char* source : {"film.oni", "openni2:", "openni2:nowhere"}) {
    expect_line({source}, 2, {std::string("'") + source + "'", "built without it"});
  }
}

#endif

}  // namespace
}  // namespace handhold::test
