// What the node has done: counts, rate, percentiles, the last frame's funnel. For diagnostics.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "handhold/result.h"

namespace handhold::ros_bridge {

/// Of one frame (ms).
struct FrameTimes {
  double delivery = 0;  ///< from the message's stamp until it was received, as an object
  double waiting = 0;   ///< from there until the search began to look at it; frames that waited longer were dropped
  double conversion = 0;
  double search = 0;   ///< localizer and tracker
  double publish = 0;  ///< making and sending the messages
  double total = 0;    ///< from the message's stamp until all was sent
};

/// May be used from several threads.
class FrameStatistics {
 public:
  /// Percentiles are of so many frames at most: 68 seconds at 30 Hz.
  static constexpr std::size_t kRecent = 2048;

  /// A message came. `sequence` is the publisher's count; gaps in it are messages that were lost on the way.
  /// @param dropped  it took the place of one that had not been searched yet
  void received(const std::string& publisher, std::uint32_t sequence, bool dropped);
  /// A frame was searched. @param now_s  of any steady clock; the rate is that of the frames
  void searched(double now_s, const FrameTimes& times, const Result& result);
  /// A frame was not searched: what is wrong with it.
  void skipped(const std::string& reason);

  struct Summary {
    std::vector<std::pair<std::string, std::string>> values;  ///< names and texts for people and programs
    std::string message;        ///< one line; why the last frame was skipped, or what came out of it
    bool skipping = false;      ///< the last frame was skipped
    bool not_searched = false;  ///< the last frame had no points, or nothing in it could be searched
    std::uint64_t received = 0;
  };
  Summary summary() const;

 private:
  mutable std::mutex mutex_;
  std::uint64_t received_ = 0, dropped_ = 0, lost_ = 0, searched_ = 0, skipped_ = 0;
  std::map<std::string, std::uint32_t> sequences_;
  std::deque<std::pair<double, FrameTimes>> recent_;
  std::string reason_;
  bool skipping_ = false;
  Status status_ = Status::kOk;
  Funnel funnel_;
  std::size_t handles_ = 0, points_ = 0, finite_points_ = 0;
};

/// Everything but stamps, as a diagnostic_msgs/DiagnosticStatus of ROS 1 or ROS 2.
template <class DiagnosticStatus>
void to_message(const FrameStatistics::Summary& summary, DiagnosticStatus& out) {
  out.level = summary.skipping       ? DiagnosticStatus::ERROR
              : summary.not_searched ? DiagnosticStatus::WARN
                                     : DiagnosticStatus::OK;
  out.message = summary.message;
  out.values.resize(summary.values.size());
  for (std::size_t i = 0; i < summary.values.size(); ++i) {
    out.values[i].key = summary.values[i].first;
    out.values[i].value = summary.values[i].second;
  }
}

}  // namespace handhold::ros_bridge
