// handhold batch: many clouds, some of them bad, stopped and taken up again.
#include <gtest/gtest.h>

#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "process.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

class Batch : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_.path() / "clouds/deep");
    for (const char* name : {"a", "b", "c"})
      folder_.write("clouds/" + std::string(name) + ".pcd", binary_pcd(moved(name[0])));
    folder_.write("clouds/deep/d.ply", ascii_ply(moved('d')));
    folder_.write("clouds/notes.txt", "not a cloud");
  }
  /// The cylinder, a little elsewhere for each letter.
  static Points moved(char letter) {
    Points points = cylinder();
    for (auto& p : points) p[0] += 0.01f * static_cast<float>(letter - 'a');
    return points;
  }
  Outcome run(Words arguments) const {
    arguments.insert(arguments.begin(), "batch");
    arguments.insert(arguments.end(), {"--samples", "300"});
    return run_program(arguments, folder_.path());
  }
  std::string alone(const std::string& cloud) const {
    return run_program({"localize", cloud, "--samples", "300", "--no-times", "--json", "-"}, folder_.path()).out;
  }
  static void expect_line(const Outcome& outcome, int code, const std::string& what) {
    EXPECT_EQ(outcome.exit_code, code) << outcome.err;
    EXPECT_NE(outcome.err.find(what), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  bool there(const std::string& name) const { return fs::exists(folder_.path() / name); }

  Folder folder_;
};

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
  constexpr int kClouds = 200;
  fs::create_directories(folder_.path() / "many");
  for (int i = 0; i < kClouds; ++i) folder_.write("many/" + std::to_string(i) + ".pcd", binary_pcd(cylinder()));
  const fs::path out = folder_.path() / "out";
  const auto results = [&] {
    std::size_t count = 0;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(out, error)) count += entry.path().stem().string().size() <= 3;
    return count;
  };
  Surroundings around;
  around.interrupt_when = [&] { return results() >= 2; };
  const Words words = {"batch", "many", "-o", "out", "--samples", "300", "--threads", "1"};
  const Outcome stopped = run_program(words, folder_.path(), around);
  EXPECT_EQ(stopped.exit_code, 130) << stopped.err;
  EXPECT_NE(stopped.err.find("interrupted: "), std::string::npos) << stopped.err;
  EXPECT_NE(stopped.err.find("of 200 clouds are done"), std::string::npos) << stopped.err;
  const std::size_t before = results();
  EXPECT_GE(before, 2u);
  EXPECT_LT(before, static_cast<std::size_t>(kClouds));
  // Every result that is there is whole, and is kept.
  const std::string whole = alone("many/0.pcd");
  for (const auto& entry : fs::directory_iterator(out)) {
    if (entry.path().stem().string().size() <= 3) {
      EXPECT_EQ(folder_.read("out/" + entry.path().filename().string()), whole);
    }
  }
  const auto written = fs::last_write_time(out / "0.json");
  EXPECT_EQ(run_program(words, folder_.path()).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(out / "0.json"), written);
  EXPECT_EQ(results(), static_cast<std::size_t>(kClouds));
  EXPECT_EQ(folder_.read("out/199.json"), whole);
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

/// Several processes by mpirun; -1: there is none.
int run_ranks(int ranks, const std::string& arguments, const fs::path& where) {
#ifdef HANDHOLD_MPIRUN
  // As root, and with more ranks than cores, too.
  const std::string command = "cd '" + where.string() +
                              "' && OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
                              "OMPI_MCA_rmaps_base_oversubscribe=1 " HANDHOLD_MPIRUN " -n " +
                              std::to_string(ranks) + " " HANDHOLD_PROGRAM " batch " + arguments + " > log 2>&1";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 255;
#else
  static_cast<void>(ranks), static_cast<void>(arguments), static_cast<void>(where);
  return -1;
#endif
}

TEST_F(Batch, AnyNumberOfRanksGivesTheSame) {
  const Outcome one = run({"clouds", "-o", "one", "--recursive"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  for (const int ranks : {1, 2, 5}) {
    const std::string out = "out" + std::to_string(ranks);
    const int code = run_ranks(
        ranks, "clouds -o " + out + " --recursive --samples 300 --threads 1 --json " + out + ".json", folder_.path());
    if (code == -1) GTEST_SKIP() << "built without MPI, or there is no mpirun";
    ASSERT_EQ(code, 0) << folder_.read("log");
    for (const char* name : {"a", "b", "c", "deep/d"}) {
      EXPECT_EQ(folder_.read(out + "/" + name + ".json"), folder_.read("one/" + std::string(name) + ".json"));
    }
    const auto summary = nlohmann::json::parse(folder_.read(out + ".json"));
    EXPECT_EQ(summary["done"], 4);
    EXPECT_EQ(summary["handles"], 4);
  }
  // What is wrong with the arguments one of them says.
  EXPECT_EQ(run_ranks(2, "nothing -o out", folder_.path()), 1);
  const std::string log = folder_.read("log");
  const std::size_t first = log.find("neither a folder nor a list");
  ASSERT_NE(first, std::string::npos) << log;
  EXPECT_EQ(log.find("neither a folder nor a list", first + 1), std::string::npos) << log;
  // A bad cloud, wherever it was read.
  folder_.write("clouds/bad.pcd", "not a cloud");
  EXPECT_EQ(run_ranks(2, "clouds -o out2 --recursive --samples 300 --json bad.json", folder_.path()), 1);
  const auto bad = nlohmann::json::parse(folder_.read("bad.json"));
  EXPECT_EQ(bad["failed"], 1);
  EXPECT_EQ(bad["kept"], 4);
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
