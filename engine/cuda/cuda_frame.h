// One frame's search on an NVIDIA GPU: memory, kernels, and one CUDA graph for what a frame does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "device_frame.h"

namespace handhold {

class CudaFrame final : public DeviceFrame {
 public:
  CudaFrame();
  ~CudaFrame() override;
  void take(const CloudView& cloud, const RobustBounds& bounds) override;
  void draw(const kernels::FrameQuery* rounds, std::uint32_t n) override;
  void look(const kernels::FrameQuery& query, const float* xyz) override;
  Found wait() override;
  void positions(float* xyz) override;
  void add_times(StageTimes& times) const override;

  /// For benchmarks: a stage of the last frame, which had one round, once more, alone, and how long it took by the
  /// device's events (ms).
  enum class Stage { kUpload, kTiles, kTree, kLook, kSum, kQuadric, kCircle, kShell, kAlign, kReport };
  static constexpr int kStages = 10;
  static const char* name(Stage stage);
  float time(Stage stage);
  /// The whole frame again as one graph, with or without the upload: by events (ms).
  float time_frame(bool upload);
  kernels::FrameCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Copies the points of a cloud, tightly packed (x y z), in parallel.
void pack_points(const CloudView& cloud, float* xyz);

}  // namespace handhold
