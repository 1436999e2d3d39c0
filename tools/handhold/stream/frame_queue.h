// Frames between the thread that reads them and the one that searches them.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>

#include "frame.h"

namespace handhold::stream {

/// Holds a few frames. A source that does not wait (a camera) drops the oldest ones when it is full.
class FrameQueue {
 public:
  FrameQueue(std::size_t capacity, bool drop_oldest) : capacity_(capacity), drop_oldest_(drop_oldest) {}

  /// Waits for room unless the oldest are dropped. False: it was closed.
  bool push(Frame frame) {
    std::unique_lock<std::mutex> lock(mutex_);
    if (drop_oldest_) {
      while (frames_.size() >= capacity_) frames_.pop_front(), ++dropped_;
    } else {
      room_.wait(lock, [this] { return closed_ || frames_.size() < capacity_; });
    }
    if (closed_) return false;
    frames_.push_back(std::move(frame));
    lock.unlock();
    there_.notify_one();
    return true;
  }
  /// Waits for a frame; none: it was closed, and all are taken.
  std::optional<Frame> pop() {
    std::unique_lock<std::mutex> lock(mutex_);
    there_.wait(lock, [this] { return closed_ || !frames_.empty(); });
    if (frames_.empty()) return std::nullopt;
    Frame frame = std::move(frames_.front());
    frames_.pop_front();
    lock.unlock();
    room_.notify_one();
    return frame;
  }
  void close() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      closed_ = true;
    }
    room_.notify_all(), there_.notify_all();
  }
  std::size_t dropped() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return dropped_;
  }

 private:
  std::size_t capacity_;
  bool drop_oldest_;
  mutable std::mutex mutex_;
  std::condition_variable room_, there_;
  std::deque<Frame> frames_;
  std::size_t dropped_ = 0;
  bool closed_ = false;
};

}  // namespace handhold::stream
