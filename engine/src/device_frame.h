// Where the neighbourhoods of a frame are searched when it is not on the CPU.
#pragma once

#include <cstdint>
#include <memory>

#include "bounds.h"
#include "cuda/frame.h"
#include "handhold/cloud.h"
#include "handhold/result.h"

namespace handhold {

/// One frame at a time; calls return before the device is done, but for `wait`. Memory is kept from frame to frame and
/// grows when it has to. All may throw DeviceError.
class DeviceFrame {
 public:
  struct Found {
    std::uint32_t finite = 0;                    ///< points of the cloud
    const std::uint8_t* end = nullptr;           ///< [samples] kernels::End
    const kernels::FoundShell* shell = nullptr;  ///< [shells], in no order
    std::uint32_t shells = 0;
  };
  virtual ~DeviceFrame() = default;
  /// Takes a cloud, which must stay until the next `wait`.
  virtual void take(const CloudView& cloud, const RobustBounds& bounds) = 0;
  /// Looks at places that are drawn on the device, round by round: in the first one uniformly over the points of the
  /// cloud that was taken, then about the shells that were found.
  virtual void draw(const kernels::FrameQuery* rounds, std::uint32_t n) = 0;
  /// Looks at these (m), query.samples from query.first = 0 on; they are copied.
  virtual void look(const kernels::FrameQuery& query, const float* xyz) = 0;
  /// What the last draw or look found; valid until the next call.
  virtual Found wait() = 0;
  /// The places of the last draw or look (m).
  virtual void positions(float* xyz) = 0;
  /// Adds what the last draw or look took on the device (ms), and the tiles of the cloud if they came with it.
  virtual void add_times(StageTimes& times) const = 0;
};

/// On the first NVIDIA GPU.
std::unique_ptr<DeviceFrame> make_cuda_frame();

}  // namespace handhold
