// Runs experiments in a folder of their own.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "process.h"
#include "refusal.h"

namespace handhold::test {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

class Experiment : public ::testing::Test {
 protected:
  Outcome experiment(Words words) const {
    words.insert(words.begin(), "experiment");
    return run_program(words, folder_.path());
  }
  /// Standard output of a run that must succeed without a word on standard error.
  std::string output(const Words& words) const {
    const Outcome done = experiment(words);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_EQ(done.err, "");
    return done.out;
  }
  Json json(const std::string& name) const { return Json::parse(folder_.read(name)); }
  void expect_png(const std::string& name) const {
    EXPECT_EQ(folder_.read(name).rfind("\x89PNG\r\n\x1a\n", 0), 0u) << name;
  }
  /// Lines of a CSV, which must all have as many cells as its header.
  std::vector<std::string> lines(const std::string& name) const {
    std::istringstream text(folder_.read(name));
    std::vector<std::string> all;
    for (std::string line; std::getline(text, line);) {
      if (!all.empty()) {
        EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(all[0].begin(), all[0].end(), ',')) << line;
      }
      all.push_back(line);
    }
    return all;
  }
  /// One line of error with all of `parts` in it, and nothing written.
  void expect_refusal(const Words& words, int exit_code, const Words& parts) const {
    expect_one_line_refusal(
        folder_, [&](const Words& w) { return experiment(w); }, words, exit_code, parts);
  }

  Folder folder_;
};

}  // namespace handhold::test
