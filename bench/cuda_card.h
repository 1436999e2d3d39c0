// The GPU as such: what it is, and what it moves and computes in a second.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "floors.h"
#include "handhold/cloud.h"

namespace handhold::bench {

struct Card {
  std::string name, driver, runtime, capability;
  int multiprocessors = 0;
  double clock = 0;           ///< Hz; the highest
  int fp32_lanes = 0;         ///< of a multiprocessor
  int fp64_lanes = 0;         ///< likewise
  double memory = 0, l2 = 0;  ///< bytes
  double memory_clock = 0;    ///< Hz
  int memory_bits = 0;        ///< of the bus
  std::string pinned;         ///< how memory of the caller was pinned
  Rates rates;                ///< bandwidths as measured, operations as computed
};

/// The first GPU. @throws DeviceError
Card measure_card();
/// Round numbers, for a run without one.
Card assumed_card();

struct FreePinned {
  enum class How { kPlain, kRegistered, kAllocated } how = How::kPlain;
  void operator()(void* p) const;
};

/// A copy of a cloud in memory that the device reads by itself.
class PinnedCloud {
 public:
  /// pin: false, without a GPU. @throws DeviceError
  PinnedCloud(const CloudView& cloud, bool pin);
  PinnedCloud(PinnedCloud&&) noexcept = default;
  CloudView view() const { return view_; }
  /// "cudaHostRegister", or "cudaMallocHost" where the former is refused
  const std::string& how() const { return how_; }

 private:
  std::unique_ptr<void, FreePinned> memory_;
  CloudView view_;
  std::string how_;
};

}  // namespace handhold::bench
