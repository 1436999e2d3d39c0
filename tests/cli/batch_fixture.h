// Runs batches in a folder of their own.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "process.h"
#include "sample_files.h"

namespace handhold::test {

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
  /// many/0.pcd, many/1.pcd and so on; of 20 kinds.
  void write_many(std::size_t clouds) const {
    fs::create_directories(folder_.path() / "many");
    for (std::size_t i = 0; i < clouds; ++i) {
      folder_.write("many/" + std::to_string(i) + ".pcd", binary_pcd(moved(static_cast<char>('a' + i % 20))));
    }
  }
  /// The results in a folder, sorted: with its name before theirs.
  Words results(const std::string& out) const {
    Words names;
    std::error_code error;  // no folder yet: none
    for (const auto& entry : fs::directory_iterator(folder_.path() / out, error)) {
      const std::string name = entry.path().filename().string();
      if (entry.path().extension() == ".json" && name[0] != '.' && entry.is_regular_file())
        names.push_back(out + "/" + name);
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  /// The cloud in many/ of a result.
  static std::string cloud_of(const std::string& result) { return "many/" + fs::path(result).stem().string() + ".pcd"; }
  std::vector<fs::file_time_type> times_of(const Words& names) const {
    std::vector<fs::file_time_type> times;
    for (const std::string& name : names) times.push_back(fs::last_write_time(folder_.path() / name));
    return times;
  }
  bool there(const std::string& name) const { return fs::exists(folder_.path() / name); }

  Folder folder_;
};

}  // namespace handhold::test
