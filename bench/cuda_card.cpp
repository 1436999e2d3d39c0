#include "cuda_card.h"

#include <cuda_runtime.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <new>

#include "handhold/device.h"

namespace handhold::bench {
namespace {

void check(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();
  throw DeviceError(std::string("CUDA: ") + what + ": " + cudaGetErrorString(error));
}

int attribute(cudaDeviceAttr which) {
  int value = 0;
  check(cudaDeviceGetAttribute(&value, which, 0), "an attribute of the GPU");
  return value;
}

std::string version(int number) {
  return std::to_string(number / 1000) + "." + std::to_string(number % 1000 / 10);
}

/// Lanes of a multiprocessor by compute capability (CUDA C++ Programming Guide, "Arithmetic Instructions").
struct Lanes {
  int fp32, fp64;
};
Lanes lanes_of(int major, int minor) {
  switch (10 * major + minor) {
    case 80:
      return {64, 32};
    case 90:
    case 100:
      return {128, 64};
    default:
      return {128, 2};
  }
}

using DeviceMemory = std::unique_ptr<char, void (*)(char*)>;
DeviceMemory device_memory(std::size_t bytes) {
  char* p = nullptr;
  if (cudaMalloc(reinterpret_cast<void**>(&p), bytes) != cudaSuccess) cudaGetLastError(), p = nullptr;
  return {p, [](char* q) { cudaFree(q); }};
}
DeviceMemory host_memory(std::size_t bytes) {
  char* p = nullptr;
  if (cudaMallocHost(reinterpret_cast<void**>(&p), bytes) != cudaSuccess) cudaGetLastError(), p = nullptr;
  return {p, [](char* q) { cudaFreeHost(q); }};
}

class Events {
 public:
  Events() {
    for (cudaEvent_t& e : event_) check(cudaEventCreate(&e), "an event");
  }
  ~Events() {
    for (cudaEvent_t e : event_) cudaEventDestroy(e);
  }
  Events(const Events&) = delete;
  /// The shortest of several runs of a copy (s).
  double shortest(const std::function<cudaError_t()>& copy) const {
    double least = 0;
    for (int i = 0; i < 10; ++i) {
      check(cudaEventRecord(event_[0]), "an event");
      check(copy(), "a copy");
      check(cudaEventRecord(event_[1]), "an event");
      check(cudaEventSynchronize(event_[1]), "a copy");
      float ms = 0;
      check(cudaEventElapsedTime(&ms, event_[0], event_[1]), "the time");
      if (i == 0 || 1e-3 * ms < least) least = 1e-3 * ms;
    }
    return least;
  }

 private:
  cudaEvent_t event_[2] = {};
};

/// Bandwidths (bytes/s): of a copy on the device, read and written, and of copies to and from pinned memory.
void measure_copies(Rates& rates) {
  const Events events;
  DeviceMemory from{nullptr, nullptr}, to{nullptr, nullptr};
  std::size_t bytes = std::size_t{1} << 30;
  for (; bytes >= std::size_t{1} << 26; bytes /= 2) {
    from = device_memory(bytes), to = device_memory(bytes);
    if (from && to) break;
  }
  if (!from || !to) throw DeviceError("CUDA: less than 128 MiB of device memory are free");
  check(cudaMemset(from.get(), 1, bytes), "clearing memory");
  rates.memory = 2.0 * static_cast<double>(bytes) / events.shortest([&] {
    return cudaMemcpyAsync(to.get(), from.get(), bytes, cudaMemcpyDeviceToDevice);
  });
  const std::size_t part = std::min(bytes, std::size_t{1} << 28);
  const DeviceMemory host = host_memory(part);
  if (!host) throw DeviceError("CUDA: " + std::to_string(part >> 20) + " MiB of pinned host memory cannot be had");
  std::memset(host.get(), 1, part);
  rates.up = static_cast<double>(part) /
             events.shortest([&] { return cudaMemcpyAsync(to.get(), host.get(), part, cudaMemcpyHostToDevice); });
  rates.down = static_cast<double>(part) /
               events.shortest([&] { return cudaMemcpyAsync(host.get(), from.get(), part, cudaMemcpyDeviceToHost); });
}

/// As the kernel module says it ("580.159.03"); empty where it does not.
std::string driver_of_module() {
  std::ifstream file("/proc/driver/nvidia/version");
  for (std::string word; file >> word;) {
    if (word.find('.') != std::string::npos && word.find_first_not_of("0123456789.") == std::string::npos) return word;
  }
  return {};
}

}  // namespace

Card measure_card() {
  Card card;
  cudaDeviceProp properties;
  check(cudaSetDevice(0), "the first device");
  check(cudaGetDeviceProperties(&properties, 0), "the GPU's properties");
  card.name = properties.name;
  card.capability = std::to_string(properties.major) + "." + std::to_string(properties.minor);
  card.multiprocessors = properties.multiProcessorCount;
  card.memory = static_cast<double>(properties.totalGlobalMem), card.l2 = static_cast<double>(properties.l2CacheSize);
  int driver = 0, runtime = 0;
  check(cudaDriverGetVersion(&driver), "the driver's version");
  check(cudaRuntimeGetVersion(&runtime), "the runtime's version");
  const std::string module = driver_of_module();
  card.driver = (module.empty() ? "" : module + ", ") + "CUDA " + version(driver), card.runtime = version(runtime);
  card.clock = 1e3 * attribute(cudaDevAttrClockRate);
  card.memory_clock = 1e3 * attribute(cudaDevAttrMemoryClockRate);
  card.memory_bits = attribute(cudaDevAttrGlobalMemoryBusWidth);
  const Lanes lanes = lanes_of(properties.major, properties.minor);
  card.fp32_lanes = lanes.fp32, card.fp64_lanes = lanes.fp64;
  card.rates.fp32 = card.multiprocessors * card.clock * lanes.fp32;
  card.rates.fp64 = card.multiprocessors * card.clock * lanes.fp64;
  measure_copies(card.rates);
  return card;
}

Card assumed_card() {
  Card card;
  card.name = "none (dry run)", card.driver = card.runtime = card.capability = "none";
  card.multiprocessors = 132, card.clock = 2e9, card.fp32_lanes = 128, card.fp64_lanes = 64;
  card.memory = 1e11, card.l2 = 5e7, card.memory_clock = 3e9, card.memory_bits = 6144;
  card.rates = {5e10, 5e10, 4e12, 132 * 2e9 * 128, 132 * 2e9 * 64};
  return card;
}

PinnedCloud::PinnedCloud(const CloudView& cloud, bool pin) : view_(cloud) {
  constexpr std::size_t kPage = 4096;
  view_.point_step = 3 * sizeof(float);
  const std::size_t bytes = std::max<std::size_t>(1, cloud.size() * view_.point_step);
  // Whole pages: two clouds must not share one.
  const std::size_t room = (bytes + kPage - 1) / kPage * kPage;
  void* p = std::aligned_alloc(kPage, room);
  if (!p) throw std::bad_alloc();
  memory_ = {p, FreePinned{}};
  how_ = "not at all";
  if (pin) {
    if (cudaHostRegister(p, room, cudaHostRegisterDefault) == cudaSuccess) {
      memory_.get_deleter().how = FreePinned::How::kRegistered, how_ = "cudaHostRegister";
    } else {
      cudaGetLastError();
      check(cudaMallocHost(&p, room), "pinned host memory");
      memory_ = {p, FreePinned{FreePinned::How::kAllocated}};
      how_ = "cudaMallocHost";
    }
  }
  auto* xyz = static_cast<float*>(memory_.get());
  for (std::size_t i = 0; i < cloud.size(); ++i) std::copy_n(cloud.point(i), 3, xyz + 3 * i);
  view_.data = xyz;
}

void FreePinned::operator()(void* p) const {
  if (how == How::kAllocated) {
    cudaFreeHost(p);
    return;
  }
  if (how == How::kRegistered) cudaHostUnregister(p);
  std::free(p);
}

}  // namespace handhold::bench
