// handhold batch under mpirun: processes that share the clouds, and some of them that come to grief.
#include <gtest/gtest.h>

#include <signal.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batch_fixture.h"

namespace handhold::test {
namespace {

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The process that mpirun started as a rank; 0: there is none yet, or no more.
int process_of_rank(int mpirun, int rank) {
  const std::string parent = "\nPPid:\t" + std::to_string(mpirun) + "\n";
  const std::string variable = '\0' + std::string("OMPI_COMM_WORLD_RANK=") + std::to_string(rank) + '\0';
  std::error_code error;
  for (fs::directory_iterator entry("/proc", error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (text_of(entry->path() / "status").find(parent) == std::string::npos) continue;
    if (text_of(entry->path() / "environ").find(variable) != std::string::npos) return std::stoi(name);
  }
  return 0;
}

class BatchRanks : public Batch {
 protected:
  static constexpr std::size_t kClouds = 200;

  void SetUp() override {
#ifndef HANDHOLD_MPIRUN
    GTEST_SKIP() << "built without MPI, or there is no mpirun";
#endif
    Batch::SetUp();
  }
  /// As root, and with more ranks than cores, too.
  static Surroundings ranks(int count) {
    Surroundings around;
#ifdef HANDHOLD_MPIRUN
    around.launcher = {HANDHOLD_MPIRUN, "-n", std::to_string(count)};
#else
    static_cast<void>(count);
#endif
    around.environment = {{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                          {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                          {"OMPI_MCA_rmaps_base_oversubscribe", "1"}};
    return around;
  }
  Outcome run_ranks(int count, Words arguments) const {
    arguments.insert(arguments.begin(), "batch");
    arguments.insert(arguments.end(), {"--samples", "300", "--threads", "1"});
    return run_program(arguments, folder_.path(), ranks(count));
  }
  static std::size_t count_of(const std::string& what, const std::string& text) {
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
    return count;
  }
  static bool has(const std::string& text, const std::string& what) {
    return text.find(what) != std::string::npos;
  }

  /// Makes many/, and undisturbed/ of it.
  void prepare_many() const {
    write_many(kClouds);
    ASSERT_EQ(run({"many", "-o", "undisturbed"}).exit_code, 0);
    ASSERT_EQ(results("undisturbed").size(), kClouds);
  }
  /// Each result in out/ is that of undisturbed/.
  void expect_whole() const {
    for (const std::string& name : results("out")) {
      EXPECT_EQ(folder_.read(name), folder_.read("undisturbed" + name.substr(name.find('/')))) << name;
    }
  }
  /// All of many/ is in out/, and nothing else is.
  void expect_complete() const {
    expect_whole();
    EXPECT_EQ(results("out").size(), kClouds);
    const auto files = [&](const char* folder) {
      const fs::directory_iterator all(folder_.path() / folder);
      return std::distance(begin(all), end(all));
    };
    EXPECT_EQ(files("out"), files("undisturbed"));
  }
  /// Kills one of three ranks in the middle of many/, then has `count` ranks finish it (0: without mpirun).
  void kill_and_go_on(int rank, int count) {
    prepare_many();
    // Three results go to pipes that nobody reads: whoever writes one waits, so that no rank gets through before the
    // kill.
    fs::create_directories(folder_.path() / "out");
    const std::vector<fs::path> pipes = {folder_.path() / "out/150.json", folder_.path() / "out/151.json",
                                         folder_.path() / "out/152.json"};
    for (const fs::path& pipe : pipes) {
      ASSERT_EQ(::mkfifo(pipe.c_str(), 0666), 0);
      fs::last_write_time(pipe, fs::last_write_time(folder_.path() / "many/0.pcd") - std::chrono::hours(1));
    }
    Surroundings around = ranks(3);
    // Seconds that mpirun gives the others: before it asks them to end, and again before it kills them.
    around.environment.emplace_back("OMPI_MCA_odls_base_sigkill_timeout", "2");
    bool was_killed = false;
    around.watch = [&](int mpirun) {
      if (results("out").size() < 3) return false;
      const int process = process_of_rank(mpirun, rank);
      was_killed = process > 0 && ::kill(process, SIGKILL) == 0;
      return was_killed;
    };
    const Words words = {"batch", "many", "-o", "out", "--samples", "300", "--threads", "1"};
    const Outcome killed = run_program(words, folder_.path(), around);
    ASSERT_TRUE(was_killed) << killed.err;
    for (const fs::path& pipe : pipes) fs::remove(pipe);
    EXPECT_EQ(killed.exit_code, 128 + SIGKILL) << killed.err;
    EXPECT_EQ(count_of("process rank " + std::to_string(rank), killed.err), 1u) << killed.err;
    EXPECT_TRUE(has(killed.err, "signal 9")) << killed.err;
    EXPECT_EQ(killed.out, "") << "a summary of what nobody knows";
    if (rank != 0) {
      EXPECT_EQ(count_of("handhold: interrupted: no report of rank ", killed.err), 1u) << killed.err;
    }

    // What is there is whole, and is kept.
    const Words before = results("out");
    EXPECT_GE(before.size(), 3u);
    EXPECT_LE(before.size(), kClouds - pipes.size());
    expect_whole();
    const auto times = times_of(before);
    const Outcome rest = count > 0 ? run_ranks(count, {"many", "-o", "out", "--json", "summary.json"})
                                   : run({"many", "-o", "out", "--json", "summary.json"});
    EXPECT_EQ(rest.exit_code, 0) << rest.err;
    EXPECT_EQ(times_of(before), times);
    const auto summary = nlohmann::json::parse(folder_.read("summary.json"));
    EXPECT_EQ(summary["kept"], before.size());
    EXPECT_EQ(summary["done"], kClouds - before.size());
    expect_complete();
  }
};

TEST_F(BatchRanks, AnyNumberGivesTheSame) {
  const Outcome one = run({"clouds", "-o", "one", "--recursive"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  for (const int count : {1, 2, 5}) {
    const std::string out = "out" + std::to_string(count);
    const Outcome several = run_ranks(count, {"clouds", "-o", out, "--recursive", "--json", out + ".json"});
    ASSERT_EQ(several.exit_code, 0) << several.err;
    for (const char* name : {"a", "b", "c", "deep/d"}) {
      EXPECT_EQ(folder_.read(out + "/" + name + ".json"), folder_.read("one/" + std::string(name) + ".json"));
    }
    const auto summary = nlohmann::json::parse(folder_.read(out + ".json"));
    EXPECT_EQ(summary["done"], 4);
    EXPECT_EQ(summary["handles"], 4);
  }
}

TEST_F(BatchRanks, WrongUseIsSaidByOne) {
  const Outcome outcome = run_ranks(2, {"nothing", "-o", "out"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(count_of("neither a folder nor a list", outcome.err), 1u) << outcome.err;
}

TEST_F(BatchRanks, ABadCloudIsReportedWhoeverReadsIt) {
  ASSERT_EQ(run({"clouds", "-o", "out"}).exit_code, 0);
  folder_.write("clouds/bad.pcd", "not a cloud");
  fs::remove(folder_.path() / "out/b.json");
  const Outcome outcome = run_ranks(2, {"clouds", "-o", "out", "--json", "summary.json"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(count_of("handhold: cannot read clouds/bad.pcd: ", outcome.err), 1u) << outcome.err;
  EXPECT_TRUE(has(outcome.err, "1 of 4 clouds could not be searched")) << outcome.err;
  const auto summary = nlohmann::json::parse(folder_.read("summary.json"));
  EXPECT_EQ(summary["failed"], 1);
  EXPECT_EQ(summary["done"], 1);
  EXPECT_EQ(summary["kept"], 2);
  EXPECT_EQ(summary["problems"][0]["name"], "bad");
}

TEST_F(BatchRanks, OneThatIsKilledEndsTheJobWhichGoesOnLater) {
  kill_and_go_on(1, 2);
}

TEST_F(BatchRanks, TheFirstOneKilledEndsTheJobWhichGoesOnLater) {
  kill_and_go_on(0, 0);
}

/// Rank 0 in the folder, rank 1 in one below it that has the same clouds.
class BatchTwoFolders : public BatchRanks {
 protected:
  void SetUp() override {
    BatchRanks::SetUp();
    if (IsSkipped()) return;
    prepare_many();
    fs::create_directories(folder_.path() / "elsewhere/out");
    fs::create_directory_symlink(folder_.path() / "many", folder_.path() / "elsewhere/many");
  }
  Outcome run_both() const {
    const Words batch = {"batch", "many", "-o", "out", "--samples", "300", "--threads", "1"};
    Words words = batch;
    words.insert(words.end(), {":", "-n", "1", "--wdir", (folder_.path() / "elsewhere").string(), HANDHOLD_PROGRAM});
    words.insert(words.end(), batch.begin(), batch.end());
    return run_program(words, folder_.path(), ranks(1));
  }
};

TEST_F(BatchTwoFolders, ADiskThatIsFullForOneIsReportedWithItsNumber) {
  for (std::size_t i = 0; i < kClouds; ++i) {
    fs::create_symlink("/dev/full", folder_.path() / ("elsewhere/out/" + std::to_string(i) + ".json"));
  }
  const Outcome outcome = run_both();
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(count_of("handhold: error: ", outcome.err), 1u) << outcome.err;
  EXPECT_TRUE(has(outcome.err, "handhold: error: rank 1: cannot write 'out/")) << outcome.err;
  EXPECT_TRUE(has(outcome.err, "No space left on device; free some space")) << outcome.err;
  // The other one did the rest; what was lost is made up for.
  const Words before = results("out");
  EXPECT_GT(before.size(), 0u);
  EXPECT_LT(before.size(), kClouds);
  EXPECT_EQ(run({"many", "-o", "out"}).exit_code, 0);
  expect_complete();
}

TEST_F(BatchTwoFolders, WhatOneDoesNotSeeIsReportedWithItsNumber) {
  fs::remove(folder_.path() / "elsewhere/many");
  const Outcome outcome = run_both();
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(count_of("handhold: error: ", outcome.err), 1u) << outcome.err;
  EXPECT_TRUE(has(outcome.err, "handhold: error: rank 1: 'many' is neither a folder nor a list")) << outcome.err;
  EXPECT_EQ(results("out"), Words());
}

}  // namespace
}  // namespace handhold::test
