// Ctrl-C ends long work in an orderly way.
#pragma once

#include <atomic>
#include <csignal>

namespace handhold {

/// True after SIGINT or SIGTERM came while an `Interrupt` lived.
inline std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the signal's handler sets it");

/// While it lives SIGINT and SIGTERM set `interrupted`; a second one kills the program, as ever.
class Interrupt {
 public:
  Interrupt() {
    interrupted = false;
    struct sigaction action {};
    action.sa_handler = [](int) { interrupted = true; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    ::sigaction(SIGINT, &action, &before_[0]);
    ::sigaction(SIGTERM, &action, &before_[1]);
  }
  ~Interrupt() {
    ::sigaction(SIGINT, &before_[0], nullptr);
    ::sigaction(SIGTERM, &before_[1], nullptr);
  }
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

 private:
  struct sigaction before_[2]{};
};

}  // namespace handhold
