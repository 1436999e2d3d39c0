// A line on the terminal that says what is going on, and disappears.
#pragma once

#include <unistd.h>

#include <cstdio>
#include <string>

namespace handhold {

/// Shows nothing unless standard error is a terminal, so that logs and pipes see results and errors only.
class Progress {
 public:
  Progress() : on_terminal_(::isatty(STDERR_FILENO) == 1) {}
  ~Progress() { show(""); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(const std::string& what) {
    if (!on_terminal_) return;
    std::fprintf(stderr, "\r\033[K%s", what.c_str());
    std::fflush(stderr);
  }

 private:
  bool on_terminal_;
};

}  // namespace handhold
