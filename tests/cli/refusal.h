// What a refusal looks like, whichever subcommand it comes from.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "process.h"

namespace handhold::test {

/// One line of error with all of `parts` in it, nothing on standard output, and no file more or less in `folder`.
/// @param run  runs the program with words
template <class Run>
void expect_one_line_refusal(const Folder& folder, Run run, const std::vector<std::string>& words, int exit_code,
                             const std::vector<std::string>& parts) {
  std::string command;
  for (const std::string& word : words) command += word + " ";
  SCOPED_TRACE(command);
  const std::vector<std::string> before = folder.entries();
  const Outcome done = run(words);
  EXPECT_EQ(done.exit_code, exit_code) << done.err;
  EXPECT_EQ(done.out, "");
  EXPECT_EQ(done.err.rfind("handhold: error: ", 0), 0u) << done.err;
  EXPECT_EQ(done.err.find('\n'), done.err.size() - 1) << done.err;
  for (const std::string& part : parts) EXPECT_NE(done.err.find(part), std::string::npos) << part << done.err;
  EXPECT_EQ(folder.entries(), before);
}

}  // namespace handhold::test
