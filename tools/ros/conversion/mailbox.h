// Frames between the thread that receives and the one that searches: the newest wins.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <utility>

namespace handhold::ros_bridge {

/// Holds one thing at most.
template <class T>
class Mailbox {
 public:
  /// Takes the place of what waits. True: something waited, and is dropped.
  bool put(T thing) {
    std::optional<T> before;  // ends outside the lock
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      before = std::exchange(waiting_, std::move(thing));
    }
    there_.notify_one();
    return before.has_value();
  }
  /// Waits; none: it was closed.
  std::optional<T> take() {
    std::unique_lock<std::mutex> lock(mutex_);
    there_.wait(lock, [this] { return closed_ || waiting_.has_value(); });
    if (closed_) return std::nullopt;
    return std::exchange(waiting_, std::nullopt);
  }
  void close() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      closed_ = true;
    }
    there_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable there_;
  std::optional<T> waiting_;
  bool closed_ = false;
};

}  // namespace handhold::ros_bridge
