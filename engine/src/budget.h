// How long a frame's work may go on.
#pragma once

#include <atomic>
#include <chrono>
#include <optional>

namespace handhold {

/// Asked between units of work of at most some tenths of a millisecond. A default one never ends.
class Budget {
 public:
  using Clock = std::chrono::steady_clock;

  Budget() = default;
  /// `milliseconds` from `start` on, or until `*cancelled`, which outlives this.
  Budget(Clock::time_point start, std::optional<double> milliseconds, const std::atomic<bool>* cancelled)
      : cancelled_(cancelled) {
    if (milliseconds) end_ = start + std::chrono::duration_cast<Clock::duration>(milli(*milliseconds));
  }
  /// The same, but what follows needs `milliseconds` of it.
  Budget less(double milliseconds) const {
    Budget b = *this;
    if (end_) b.end_ = *end_ - std::chrono::duration_cast<Clock::duration>(milli(milliseconds));
    return b;
  }

  bool cancelled() const { return cancelled_ && cancelled_->load(std::memory_order_relaxed); }
  /// Once true it stays so until the frame ends.
  bool spent() const { return cancelled() || (end_ && Clock::now() >= *end_); }

  /// Ends steps that leave nothing behind when they are not done. Never thrown through TBB: tasks return instead, and
  /// the step asks after them.
  struct Spent {};
  /// @throws Spent
  void check() const {
    if (spent()) throw Spent{};
  }

 private:
  using milli = std::chrono::duration<double, std::milli>;
  std::optional<Clock::time_point> end_;
  const std::atomic<bool>* cancelled_ = nullptr;
};

}  // namespace handhold
