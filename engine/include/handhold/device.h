// The GPU that a search may run on.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace handhold {

/// Thrown when a GPU fails: it has too little memory, or is lost. what() names the step and the driver's reason.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The first NVIDIA GPU of this machine, as Options::backend = Backend::kCuda takes it.
struct CudaDevice {
  bool available = false;
  std::string name;    ///< "NVIDIA H200"; empty: none is available
  std::string reason;  ///< why none is available, in one line; empty where one is
};

/// What `backend` = `cuda` would run on. Asks the driver at each call, which may take a while, and prints nothing. That
/// a device is there does not say that it can do what all options ask for: Localizer::backend() and its constructor do.
/// Throws nothing but std::bad_alloc.
CudaDevice cuda_device();

/// Pins memory of the caller while it lives, so that a GPU reads clouds where they are and nothing is copied on the
/// way: for a buffer that frame after frame comes in. Memory that cudaMallocHost gave is pinned already. Does nothing
/// where there is no GPU.
class PinnedMemory {
 public:
  /// The memory must stay where it is for as long as this lives.
  PinnedMemory(const void* data, std::size_t bytes);
  ~PinnedMemory();
  PinnedMemory(const PinnedMemory&) = delete;
  PinnedMemory& operator=(const PinnedMemory&) = delete;
  /// False: it is not, and clouds in it are copied first, as all others.
  bool pinned() const { return data_ != nullptr; }

 private:
  const void* data_ = nullptr;
};

}  // namespace handhold
