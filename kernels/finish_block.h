// What a block knows of its sixteen tiles: boxes, which are full, and low-order sums.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// Coordinates beyond this (m) count as missing: squared distances must stay far from overflow.
inline constexpr float kLargestCoordinate = 1e6f;

/// kernels::Kernels::finish_block
LANE_FN std::int32_t finish_tiles(float* points, float* box, std::uint16_t* full, float* sums) {
  const F16 far(kernels::kFar), zero(0.0f), limit(kLargestCoordinate);
  std::uint32_t full_mask = 0;
  std::int32_t total = 0;
  for (int t = 0; t < kernels::kBlockTiles; ++t) {
    float* p = points + 48 * t;
    const F16 x = F16::load(p), y = F16::load(p + 16), z = F16::load(p + 32);
    const M16 valid = (abs(x) <= limit) & (abs(y) <= limit) & (abs(z) <= limit);
    const int n = count(valid);
    total += n;
    full_mask |= (n == kernels::kTilePoints ? 1u : 0u) << t;
    if (n == 0) {
      far.store(p), far.store(p + 16), far.store(p + 32);
      for (int k = 0; k < 3; ++k) box[16 * k + t] = kernels::kFar, box[48 + 16 * k + t] = -kernels::kFar;
      for (int k = 0; k < 10; ++k) sums[16 * k + t] = k >= 1 && k <= 3 ? kernels::kFar : 0.0f;
      continue;
    }
    const F16 xv = select(valid, x, far), yv = select(valid, y, far), zv = select(valid, z, far);
    xv.store(p), yv.store(p + 16), zv.store(p + 32);
    const float low[3] = {reduce_min(xv), reduce_min(yv), reduce_min(zv)};
    box[t] = low[0], box[16 + t] = low[1], box[32 + t] = low[2];
    box[48 + t] = reduce_max(select(valid, x, -far));
    box[64 + t] = reduce_max(select(valid, y, -far));
    box[80 + t] = reduce_max(select(valid, z, -far));
    // About the low corner, so that the squares stay small.
    const F16 dx = select(valid, x - F16(low[0]), zero), dy = select(valid, y - F16(low[1]), zero);
    const F16 dz = select(valid, z - F16(low[2]), zero);
    alignas(64) float rows[16][16], sum[16];
    dx.store(rows[0]), dy.store(rows[1]), dz.store(rows[2]);
    (dx * dx).store(rows[3]), (dx * dy).store(rows[4]), (dx * dz).store(rows[5]);
    (dy * dy).store(rows[6]), (dy * dz).store(rows[7]), (dz * dz).store(rows[8]);
    for (int k = 9; k < 16; ++k) zero.store(rows[k]);
    reduce_rows(rows).store(sum);
    const float inverse = 1.0f / static_cast<float>(n);
    sums[t] = static_cast<float>(n);
    for (int k = 0; k < 3; ++k) sums[16 + 16 * k + t] = low[k] + sum[k] * inverse;
    sums[64 + t] = sum[3] - sum[0] * sum[0] * inverse, sums[80 + t] = sum[4] - sum[0] * sum[1] * inverse;
    sums[96 + t] = sum[5] - sum[0] * sum[2] * inverse, sums[112 + t] = sum[6] - sum[1] * sum[1] * inverse;
    sums[128 + t] = sum[7] - sum[1] * sum[2] * inverse, sums[144 + t] = sum[8] - sum[2] * sum[2] * inverse;
  }
  *full = static_cast<std::uint16_t>(full_mask);
  return total;
}

}  // namespace handhold::HANDHOLD_LANE
