// The GPU of a build without CUDA: there is none.
#include "device_frame.h"
#include "handhold/device.h"

namespace handhold {

CudaDevice cuda_device() {
  return {false, {}, "this build of handhold has no CUDA backend (it was configured without HANDHOLD_CUDA)"};
}

std::unique_ptr<DeviceFrame> make_cuda_frame() {
  throw DeviceError(cuda_device().reason);
}

PinnedMemory::PinnedMemory(const void*, std::size_t) {}
PinnedMemory::~PinnedMemory() = default;

}  // namespace handhold
