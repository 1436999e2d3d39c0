// Messages that are used again: a cloud of 5 MB is allocated, and its pages are touched first, once and not 30 times a
// second.
#pragma once

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>
#include <mutex>
#include <vector>

namespace handhold::ros_bridge {

template <class Message>
class MessagePool {
 public:
  /// One that nobody holds. There are as many as are held at a time.
  boost::shared_ptr<Message> take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& message : messages_) {
      if (message.use_count() == 1) return message;
    }
    messages_.push_back(boost::make_shared<Message>());
    return messages_.back();
  }

 private:
  std::mutex mutex_;
  std::vector<boost::shared_ptr<Message>> messages_;
};

}  // namespace handhold::ros_bridge
