#include "urdf.h"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <mutex>
#include <stdexcept>
#include <thread>

namespace handhold::plan {
namespace {

/// Keeps what urdfdom reports on this thread, and hands on what others do. console_bridge has one handler for the whole
/// process, and no other way to silence urdfdom: so it is ours only while a text is parsed, by one thread at a time.
class Listener : public console_bridge::OutputHandler {
 public:
  Listener() : others_(console_bridge::getOutputHandler()) { console_bridge::useOutputHandler(this); }
  ~Listener() override { console_bridge::useOutputHandler(others_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* file, int line) override {
    if (std::this_thread::get_id() != listening_) {
      if (others_) others_->log(text, level, file, line);
    } else if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_error_.empty()) {
      first_error_ = text;
    }
  }
  const std::string& first_error() const { return first_error_; }

 private:
  console_bridge::OutputHandler* const others_;
  const std::thread::id listening_ = std::this_thread::get_id();
  std::string first_error_;
};

std::string on_one_line(std::string text) {
  for (char& c : text) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace

urdf::ModelInterfaceSharedPtr parse_urdf(const std::string& text) {
  static std::mutex one_at_a_time;
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  Listener listener;
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(text);
  if (!model) throw std::invalid_argument("bad URDF: " + on_one_line(listener.first_error()));
  return model;
}

}  // namespace handhold::plan
