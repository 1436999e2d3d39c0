// handhold batch: many clouds, some of them bad, stopped and taken up again.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "batch_fixture.h"

namespace handhold::test {
namespace {

TEST_F(Batch, GivesWhatLocalizeGivesForAnyNumberOfThreads) {
  for (const char* threads : {"1", "2", "5"}) {
    const std::string out = std::string("out") + threads;
    const Outcome outcome = run({"clouds", "-o", out, "--threads", threads});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(outcome.err.empty()) << "quiet in a pipe";
    for (const char* name : {"a", "b", "c"}) {
      EXPECT_EQ(folder_.read(out + "/" + name + ".json"), alone("clouds/" + std::string(name) + ".pcd"));
    }
    EXPECT_FALSE(there(out + "/deep/d.json"));
  }
}

TEST_F(Batch, FoldersWithinAndLists) {
  EXPECT_EQ(run({"clouds", "-o", "out", "--recursive"}).exit_code, 0);
  EXPECT_EQ(folder_.read("out/deep/d.json"), alone("clouds/deep/d.ply"));
  folder_.write("list.txt", "# two of them\n\nclouds/b.pcd\r\nclouds/deep/d.ply\n");
  const Outcome outcome = run({"list.txt", "-o", "listed", "--json", "summary.json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(folder_.read("listed/clouds/b.json"), alone("clouds/b.pcd"));
  EXPECT_TRUE(there("listed/clouds/deep/d.json"));
  const auto summary = nlohmann::json::parse(folder_.read("summary.json"));
  EXPECT_EQ(summary["clouds"], 2);
  EXPECT_EQ(summary["done"], 2);
  EXPECT_EQ(summary["handles"], 2);
}

TEST_F(Batch, GoesOnWhereItStopped) {
  EXPECT_EQ(run({"clouds", "-o", "out"}).exit_code, 0);
  const auto before = fs::last_write_time(folder_.path() / "out/a.json");
  fs::remove(folder_.path() / "out/b.json");
  // A cloud that has changed is searched again.
  folder_.write("clouds/c.pcd", binary_pcd(moved('x')));
  fs::last_write_time(folder_.path() / "clouds/c.pcd", fs::file_time_type::clock::now() + std::chrono::seconds(5));
  const Outcome outcome = run({"clouds", "-o", "out", "--csv", "rows.csv"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(fs::last_write_time(folder_.path() / "out/a.json"), before);
  EXPECT_EQ(folder_.read("out/b.json"), alone("clouds/b.pcd"));
  EXPECT_EQ(folder_.read("out/c.json"), alone("clouds/c.pcd"));
  const std::string rows = folder_.read("rows.csv");
  EXPECT_NE(rows.find("\"a\",kept"), std::string::npos) << rows;
  EXPECT_NE(rows.find("\"b\",done"), std::string::npos) << rows;
  EXPECT_NE(rows.find("\"c\",done"), std::string::npos) << rows;
}

TEST_F(Batch, InterruptedItFinishesWhatItBeganAndGoesOnLater) {
  constexpr std::size_t kClouds = 200;
  write_many(kClouds);
  Surroundings around;
  around.watch = [&](int process) {
    if (results("out").size() < 2) return false;
    ::kill(process, SIGINT);
    return true;
  };
  const Words words = {"batch", "many", "-o", "out", "--samples", "300", "--threads", "1"};
  const Outcome stopped = run_program(words, folder_.path(), around);
  EXPECT_EQ(stopped.exit_code, 130) << stopped.err;
  EXPECT_NE(stopped.err.find("interrupted: "), std::string::npos) << stopped.err;
  EXPECT_NE(stopped.err.find("of 200 clouds are done"), std::string::npos) << stopped.err;
  const Words before = results("out");
  EXPECT_GE(before.size(), 2u);
  EXPECT_LT(before.size(), kClouds);
  // Every result that is there is whole, and is kept.
  for (const std::string& name : before) EXPECT_EQ(folder_.read(name), alone(cloud_of(name))) << name;
  const auto times = times_of(before);
  EXPECT_EQ(run_program(words, folder_.path()).exit_code, 0);
  EXPECT_EQ(times_of(before), times);
  EXPECT_EQ(results("out").size(), kClouds);
  EXPECT_EQ(folder_.read("out/199.json"), alone("many/199.pcd"));
}

TEST_F(Batch, WhatAKilledOneLeftHalfIsRemoved) {
  EXPECT_EQ(run({"clouds", "-o", "out"}).exit_code, 0);
  const Words whole = folder_.entries();
  folder_.write("out/a.json.part-1-0", "{\"sch");
  EXPECT_EQ(run({"clouds", "-o", "out"}).exit_code, 0);
  EXPECT_EQ(folder_.entries(), whole);
  // What is of no cloud here, or is being written, is left alone.
  for (const char* name : {"out/x.json.part-1-0", "out/a.json.part-1", "out/b.json.part-1-0"}) folder_.write(name, "{");
  const int writer = ::open((folder_.path() / "out/b.json.part-1-0").c_str(), O_WRONLY);
  ASSERT_EQ(::flock(writer, LOCK_EX), 0);
  const Words others = folder_.entries();
  EXPECT_EQ(run({"clouds", "-o", "out"}).exit_code, 0);
  EXPECT_EQ(folder_.entries(), others);
  ::close(writer);
}

TEST_F(Batch, OtherOptionsAreNotMixed) {
  EXPECT_EQ(run({"clouds", "-o", "out"}).exit_code, 0);
  expect_line(run({"clouds", "-o", "out", "--seed", "2"}), 2, "other options");
  EXPECT_EQ(run({"clouds", "-o", "out", "--threads", "2"}).exit_code, 0) << "threads change nothing";
  const Outcome forced = run({"clouds", "-o", "out", "--seed", "2", "--force", "--json", "summary.json"});
  EXPECT_EQ(forced.exit_code, 0) << forced.err;
  EXPECT_EQ(nlohmann::json::parse(folder_.read("summary.json"))["done"], 3);
}

TEST_F(Batch, BadCloudsAreReportedAndPassedOver) {
  const std::string whole = folder_.read("clouds/b.pcd");
  folder_.write("clouds/b.pcd", whole.substr(0, whole.size() / 2));
  folder_.write("clouds/empty.pcd", binary_pcd({}));
  const Outcome outcome = run({"clouds", "-o", "out", "--json", "summary.json"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("b.pcd"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("empty.pcd' has no points"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("2 of 4 clouds"), std::string::npos) << outcome.err;
  EXPECT_TRUE(there("out/a.json") && there("out/c.json"));
  EXPECT_FALSE(there("out/b.json") || there("out/empty.json"));
  EXPECT_EQ(nlohmann::json::parse(folder_.read("summary.json"))["problems"].size(), 2u);
  // Mended, the same command makes up for it.
  folder_.write("clouds/b.pcd", whole);
  fs::remove(folder_.path() / "clouds/empty.pcd");
  EXPECT_EQ(run({"clouds", "-o", "out"}).exit_code, 0);
  EXPECT_EQ(folder_.read("out/b.json"), alone("clouds/b.pcd"));
}

TEST_F(Batch, WrongUseIsOneLine) {
  expect_line(run({}), 2, "no clouds given");
  expect_line(run({"clouds"}), 2, "-o");
  expect_line(run({"nothing", "-o", "out"}), 1, "neither a folder nor a list");
  expect_line(run({"clouds/a.pcd", "-o", "out"}), 2, "is a cloud");
  fs::create_directories(folder_.path() / "none");
  expect_line(run({"none", "-o", "out"}), 1, "--recursive");
  folder_.write("list.txt", "# nothing\n");
  expect_line(run({"list.txt", "-o", "out"}), 1, "names no cloud");
  expect_line(run({"list.txt", "-o", "out", "--recursive"}), 2, "needs a folder");
  expect_line(run({"clouds", "-o", "clouds/a.pcd"}), 1, "cannot make the folder");
  expect_line(run({"clouds", "-o", "out", "--hand-aperture", "0"}), 2, "--hand-aperture");
  EXPECT_FALSE(there("out"));
  folder_.write("clouds/a.ply", ascii_ply(cylinder()));
  expect_line(run({"clouds", "-o", "out"}), 2, "rename one of them");
}

TEST_F(Batch, AFullDiskEndsIt) {
  Surroundings small;
  small.max_file_bytes = 3000;  // the options fit, a result does not
  const Outcome outcome = run_program({"batch", "clouds", "-o", "out", "--samples", "300"}, folder_.path(), small);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("out/"), std::string::npos) << outcome.err;
  for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(there("out/" + std::string(name) + ".json"));
  EXPECT_EQ(run({"clouds", "-o", "out"}).exit_code, 0);
  EXPECT_EQ(folder_.read("out/a.json"), alone("clouds/a.pcd"));
}

}  // namespace
}  // namespace handhold::test
