#include "frame_statistics.h"

#include <cstdio>

#include "statistics.h"

namespace handhold::ros_bridge {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

constexpr std::pair<const char*, double FrameTimes::*> kTimes[] = {
    {"delivery", &FrameTimes::delivery}, {"waiting", &FrameTimes::waiting}, {"conversion", &FrameTimes::conversion},
    {"search", &FrameTimes::search},     {"publish", &FrameTimes::publish}, {"total", &FrameTimes::total}};

constexpr std::pair<const char*, std::int64_t Funnel::*> kFunnel[] = {{"samples", &Funnel::samples},
                                                                      {"too_few_points", &Funnel::too_few_points},
                                                                      {"flat", &Funnel::flat},
                                                                      {"curvature_low", &Funnel::curvature_low},
                                                                      {"concave", &Funnel::concave},
                                                                      {"circle_wide", &Funnel::circle_wide},
                                                                      {"circle_narrow", &Funnel::circle_narrow},
                                                                      {"poor_fit", &Funnel::poor_fit},
                                                                      {"no_gap", &Funnel::no_gap},
                                                                      {"shell_empty", &Funnel::shell_empty},
                                                                      {"affordances", &Funnel::affordances},
                                                                      {"cut", &Funnel::cut},
                                                                      {"not_aligned", &Funnel::not_aligned},
                                                                      {"unconfirmed", &Funnel::unconfirmed},
                                                                      {"too_short", &Funnel::too_short},
                                                                      {"low_confidence", &Funnel::low_confidence},
                                                                      {"in_handles", &Funnel::in_handles}};

}  // namespace

void FrameStatistics::received(const std::string& publisher, std::uint32_t sequence, bool dropped) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++received_;
  if (dropped) ++dropped_;
  const auto [last, is_new] = sequences_.try_emplace(publisher, sequence);
  // A publisher that begins anew, or writes no counts, loses nothing.
  if (!is_new && sequence > last->second) lost_ += sequence - last->second - 1;
  last->second = sequence;
}

void FrameStatistics::searched(double now_s, const FrameTimes& times, const Result& result) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++searched_;
  recent_.emplace_back(now_s, times);
  if (recent_.size() > kRecent) recent_.pop_front();
  skipping_ = false;
  status_ = result.status;
  funnel_ = result.funnel;
  handles_ = result.handles.size();
  points_ = result.points;
  finite_points_ = result.finite_points;
}

void FrameStatistics::skipped(const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++skipped_;
  skipping_ = true;
  reason_ = reason;
}

FrameStatistics::Summary FrameStatistics::summary() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Summary out;
  out.received = received_;
  out.skipping = skipping_;
  out.not_searched = searched_ > 0 && status_ != Status::kOk && status_ != Status::kDeadline;
  out.message = skipping_        ? reason_
                : searched_ == 0 ? "no cloud searched yet"
                                 : std::string(to_string(status_)) + ", " + std::to_string(handles_) + " handles";

  const auto add = [&](std::string name, std::string value) {
    out.values.emplace_back(std::move(name), std::move(value));
  };
  add("received", std::to_string(received_));
  add("searched", std::to_string(searched_));
  add("dropped", std::to_string(dropped_));
  add("lost", std::to_string(lost_));
  add("skipped", std::to_string(skipped_));
  const double span = recent_.size() < 2 ? 0 : recent_.back().first - recent_.front().first;
  add("rate_hz", number(span > 0 ? static_cast<double>(recent_.size() - 1) / span : 0));
  std::vector<double> ms;
  for (const auto& [name, member] : kTimes) {
    ms.clear();
    for (const auto& [time, times] : recent_) ms.push_back(times.*member);
    for (const auto& [suffix, share] : {std::pair("_ms_p50", 0.5), std::pair("_ms_p99", 0.99)}) {
      add(std::string(name) + suffix, ms.empty() ? "" : number(quantile(ms, share)));
    }
  }
  add("status", searched_ == 0 ? "" : std::string(to_string(status_)));
  add("points", std::to_string(points_));
  add("finite_points", std::to_string(finite_points_));
  add("handles", std::to_string(handles_));
  for (const auto& [name, member] : kFunnel) add(std::string("funnel.") + name, std::to_string(funnel_.*member));
  return out;
}

}  // namespace handhold::ros_bridge
