// What a block knows of its sixteen tiles: boxes, which are full, and low-order sums.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// Coordinates beyond this (m) count as missing: squared distances must stay far from overflow.
inline constexpr float kLargestCoordinate = 1e6f;

/// What a block knows of one of its tiles.
struct TileSummary {
  std::int32_t points;
  float box[6];   ///< low x, y, z, high x, y, z (m)
  float sum[10];  ///< number, mean x y z (m), centred second moments xx xy xz yy yz zz (m^2)
};

/// Sums up a tile, and puts kFar where a point is missing.
LANE_FN TileSummary finish_tile(F16& x, F16& y, F16& z) {
  const F16 far(kernels::kFar), zero(0.0f), limit(kLargestCoordinate);
  const M16 valid = (abs(x) <= limit) & (abs(y) <= limit) & (abs(z) <= limit);
  TileSummary s;
  s.points = count(valid);
  if (s.points == 0) {
    x = y = z = far;
    for (int k = 0; k < 3; ++k) s.box[k] = kernels::kFar, s.box[3 + k] = -kernels::kFar;
    for (int k = 0; k < 10; ++k) s.sum[k] = k >= 1 && k <= 3 ? kernels::kFar : 0.0f;
    return s;
  }
  const F16 hx = select(valid, x, -far), hy = select(valid, y, -far), hz = select(valid, z, -far);
  x = select(valid, x, far), y = select(valid, y, far), z = select(valid, z, far);
  const float low[3] = {reduce_min(x), reduce_min(y), reduce_min(z)};
  for (int k = 0; k < 3; ++k) s.box[k] = low[k];
  s.box[3] = reduce_max(hx), s.box[4] = reduce_max(hy), s.box[5] = reduce_max(hz);
  // About the low corner, so that the squares stay small.
  const F16 dx = select(valid, x - F16(low[0]), zero), dy = select(valid, y - F16(low[1]), zero);
  const F16 dz = select(valid, z - F16(low[2]), zero);
  const F16 terms[9] = {dx, dy, dz, dx * dx, dx * dy, dx * dz, dy * dy, dy * dz, dz * dz};
  float sum[9];
  reduce_each(terms, sum);
  const float inverse = 1.0f / static_cast<float>(s.points);
  s.sum[0] = static_cast<float>(s.points);
  for (int k = 0; k < 3; ++k) s.sum[1 + k] = low[k] + sum[k] * inverse;
  s.sum[4] = sum[3] - sum[0] * sum[0] * inverse, s.sum[5] = sum[4] - sum[0] * sum[1] * inverse;
  s.sum[6] = sum[5] - sum[0] * sum[2] * inverse, s.sum[7] = sum[6] - sum[1] * sum[1] * inverse;
  s.sum[8] = sum[7] - sum[1] * sum[2] * inverse, s.sum[9] = sum[8] - sum[2] * sum[2] * inverse;
  return s;
}

/// kernels::Kernels::finish_block
LANE_FN std::int32_t finish_tiles(float* points, float* box, std::uint16_t* full, float* sums) {
  std::uint32_t full_mask = 0;
  std::int32_t total = 0;
  for (int t = 0; t < kernels::kBlockTiles; ++t) {
    float* p = points + 48 * t;
    F16 x = F16::load(p), y = F16::load(p + 16), z = F16::load(p + 32);
    const TileSummary s = finish_tile(x, y, z);
    x.store(p), y.store(p + 16), z.store(p + 32);
    total += s.points;
    full_mask |= (s.points == kernels::kTilePoints ? 1u : 0u) << t;
    for (int k = 0; k < 6; ++k) box[16 * k + t] = s.box[k];
    for (int k = 0; k < 10; ++k) sums[16 * k + t] = s.sum[k];
  }
  *full = static_cast<std::uint16_t>(full_mask);
  return total;
}

}  // namespace handhold::HANDHOLD_LANE
