// The paper's search of neighbourhoods on a device: what Search does, but for the choice of samples.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "device_frame.h"
#include "handhold/options.h"
#include "handhold/result.h"

namespace handhold {

class DeviceSearch {
 public:
  DeviceSearch(const Options& options, std::unique_ptr<DeviceFrame> frame);

  /// Takes a cloud, which must stay until it is searched. It is not empty.
  void take(const CloudView& cloud);
  /// Bounds of the cloud that was taken, after `draw`.
  const RobustBounds& bounds() const { return bounds_; }

  /// Whether the device draws the samples, too.
  static bool draws(const Options& options) { return !options.workspace; }
  /// Looks at samples that it draws itself, in rounds of so many. Afterwards as `run`; returns the number of the
  /// cloud's finite points.
  std::uint32_t draw(const std::vector<int>& rounds, Step* steps, std::vector<Affordance>& found);
  /// Looks at these (xyz: 3 * n, m); see Search::run.
  void run(const float* xyz, std::uint32_t n, std::uint32_t first, Step* steps, std::vector<Affordance>& found);
  /// Of the affordances that `draw` found; see HandleSearch::run.
  const std::vector<std::uint32_t>& aligned() const { return aligned_; }
  /// The samples of the last look (m).
  void positions(float* xyz) { frame_->positions(xyz); }

  /// Adds the device's times for the cloud that was taken.
  void add_times(StageTimes& times) const;

 private:
  std::uint32_t collect(std::uint32_t n, std::uint32_t first, Step* steps, std::vector<Affordance>& found);

  const Options* options_;
  std::unique_ptr<DeviceFrame> frame_;
  kernels::FrameQuery query_{};  ///< what does not change from frame to frame
  std::vector<kernels::FrameQuery> rounds_;
  double radius_ = 0;  ///< m; of the balls
  CloudView cloud_;    ///< that was taken
  RobustBounds bounds_;
  std::vector<std::uint32_t> order_, aligned_;
  StageTimes times_;
};

}  // namespace handhold
