// The 34 sums over a neighbourhood's points: added up in single precision, a vector of sixteen points at a time, and
// carried to double every kChunk vectors, as moments.h does.
#pragma once

#include "../moment_sums.h"

namespace handhold::HANDHOLD_LANE {

inline constexpr int kTotals = 34;

class Totals {
 public:
  LANE_FN Totals() { clear(); }

  /// Adds sixteen points; zeros add nothing.
  LANE_FN void add(F16 x, F16 y, F16 z) {
    add_point<0, kTotals>(sum_, x, y, z);
    if (++vectors_ == kChunk) carry();
  }
  /// Writes sum k to to[(1 + k) * stride].
  LANE_FN void store(double* to, std::size_t stride) {
    if (vectors_ > 0) carry();
    write(to + stride, stride);
  }

 private:
  LANE_FN void clear() {
    LANE_UNROLL(34)
    for (int k = 0; k < kTotals; ++k) sum_[k] = F16(0.0f);
    vectors_ = 0;
  }

#if defined(HANDHOLD_ISA_CUDA)
  // Each lane has the totals of its own number, and of those sixteen and thirty-two further on.
  LANE_FN void carry() {
    total_[0] += static_cast<double>(reduce_sixteen(sum_));
    total_[1] += static_cast<double>(reduce_sixteen(sum_ + 16));
    const float last[2] = {reduce_add(sum_[32]), reduce_add(sum_[33])};
    total_[2] += static_cast<double>(pack_lane() == 0 ? last[0] : last[1]);
    clear();
  }
  LANE_FN void write(double* to, std::size_t stride) const {
    const std::size_t k = pack_lane();
    to[k * stride] = total_[0], to[(k + 16) * stride] = total_[1];
    if (k < 2) to[(k + 32) * stride] = total_[2];
  }
  double total_[3] = {0.0, 0.0, 0.0};
#else
  LANE_FN void carry() {
    for (int k = 0; k < kTotals; ++k) total_[k] += static_cast<double>(reduce_add(sum_[k]));
    clear();
  }
  LANE_FN void write(double* to, std::size_t stride) const {
    for (std::size_t k = 0; k < kTotals; ++k) to[k * stride] = total_[k];
  }
  double total_[kTotals] = {};
#endif

  F16 sum_[kTotals];
  int vectors_;
};

}  // namespace handhold::HANDHOLD_LANE
