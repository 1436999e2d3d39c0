// handhold stream: frame after frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "frame_queue.h"
#include "process.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

class Stream : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_.path() / "frames");
    // A cylinder that moves 4 mm a frame.
    for (int i = 0; i < 6; ++i) {
      Points points = cylinder();
      for (auto& p : points) p[0] += 0.004f * static_cast<float>(i);
      folder_.write("frames/" + std::to_string(i) + ".pcd", binary_pcd(points));
    }
  }
  Outcome run(Words arguments) const {
    arguments.insert(arguments.begin(), "stream");
    arguments.insert(arguments.end(), {"--samples", "300"});
    return run_program(arguments, folder_.path());
  }
  static std::vector<Json> lines(const std::string& text) {
    std::vector<Json> all;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) all.push_back(Json::parse(line));
    return all;
  }

  Folder folder_;
};

TEST_F(Stream, FollowsAHandleThroughTheFrames) {
  const Outcome outcome = run({"frames", "--json", "-"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err.rfind("6 frames of 6 searched", 0), 0u) << outcome.err;
  const std::vector<Json> frames = lines(outcome.out);
  ASSERT_EQ(frames.size(), 6u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i]["frame"], i);
    EXPECT_EQ(frames[i]["status"], "ok");
    EXPECT_EQ(frames[i]["dropped"], 0);
    ASSERT_EQ(frames[i]["tracks"].size(), 1u) << i;
    const Json& track = frames[i]["tracks"][0];
    EXPECT_EQ(track["id"], 1);
    EXPECT_EQ(track["age"], i + 1);
    EXPECT_EQ(track["unseen"], 0);
    EXPECT_NEAR(track["center"][0].get<double>(), kCylinderCenter[0] + 0.004 * static_cast<double>(i), 0.008);
    ASSERT_EQ(frames[i]["handles"].size(), 1u);
    EXPECT_TRUE(frames[i]["handles"][0].contains("confidence"));
  }
  EXPECT_GT(frames.back()["tracks"][0]["velocity"][0], 0.001);
}

TEST_F(Stream, SameBytesForAnyNumberOfThreads) {
  const Outcome one = run({"frames", "--no-times", "--json", "1.jsonl", "--threads", "1"});
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_EQ(one.err, "") << "quiet in a pipe";
  EXPECT_EQ(one.out.rfind("6 frames of 6 searched", 0), 0u) << one.out;
  EXPECT_EQ(run({"frames", "--no-times", "--json", "3.jsonl", "--threads", "3"}).exit_code, 0);
  EXPECT_EQ(folder_.read("1.jsonl"), folder_.read("3.jsonl"));
  const Outcome alone = run({"frames", "--no-times", "--no-track", "--json", "-"});
  for (const Json& frame : lines(alone.out)) EXPECT_FALSE(frame.contains("tracks") || frame.contains("time_s"));
}

TEST_F(Stream, ABadFrameIsReportedAndPassedOver) {
  folder_.write("frames/3.pcd", "not a cloud");
  const Outcome outcome = run({"frames", "--json", "frames.jsonl"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err.rfind("handhold: ", 0), 0u) << outcome.err;
  EXPECT_NE(outcome.err.find("3.pcd"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.out.find("1 unreadable"), std::string::npos) << outcome.out;
  const std::vector<Json> frames = lines(folder_.read("frames.jsonl"));
  ASSERT_EQ(frames.size(), 6u);
  EXPECT_EQ(frames[3]["status"], "unreadable");
  EXPECT_EQ(frames[4]["tracks"][0]["id"], 1) << "the same one, after the gap";
}

TEST_F(Stream, WrongUseIsOneLine) {
  const auto expect_line = [&](const Words& arguments, int code, const std::string& what) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, code) << outcome.err;
    EXPECT_NE(outcome.err.find(what), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  };
  expect_line({}, 2, "no source given");
  expect_line({"none"}, 1, "neither a folder nor a list");
  for (const char* rate : {"0", "-5", "nan", "fast"}) expect_line({"frames", "--rate-hz", rate}, 2, "--rate-hz");
  expect_line({"frames", "--json", "no/such/folder.jsonl"}, 1, "no/such/folder.jsonl");
}

TEST(FrameQueue, DropsTheOldestOrWaits) {
  stream::FrameQueue camera(2, true);
  for (std::size_t i = 0; i < 5; ++i) {
    stream::Frame frame;
    frame.number = i;
    EXPECT_TRUE(camera.push(std::move(frame)));
  }
  EXPECT_EQ(camera.dropped(), 3u);
  camera.close();
  EXPECT_EQ(camera.pop()->number, 3u);
  EXPECT_EQ(camera.pop()->number, 4u);
  EXPECT_FALSE(camera.pop());
  EXPECT_FALSE(camera.push({})) << "closed";

  stream::FrameQueue files(2, false);
  std::thread reader([&] {
    for (std::size_t i = 0; i < 50; ++i) {
      stream::Frame frame;
      frame.number = i;
      files.push(std::move(frame));
    }
    files.close();
  });
  std::size_t next = 0;
  while (const auto frame = files.pop()) EXPECT_EQ(frame->number, next++);
  reader.join();
  EXPECT_EQ(next, 50u);
  EXPECT_EQ(files.dropped(), 0u);
}

}  // namespace
}  // namespace handhold::test
