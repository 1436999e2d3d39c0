// Which affordances are aligned with which (paper, section 3.3), sixteen at a time.
#pragma once

#include "kernels.h"
#include "lane.h"
#include "neighbours.h"

namespace handhold::HANDHOLD_LANE {

/// What affordance i is aligned with. With unit axes v and centres h: d_o = |(I - v_i v_i^T) v_j| = |v_i x v_j|,
/// d_c = |(I - v_i v_i^T)(h_i - h_j)|, which is not symmetric, so the larger of the two ways counts, d_r = |r_i - r_j|.
class AlignedWith {
 public:
  LANE_FN AlignedWith(const kernels::AffordanceArrays& a, std::int32_t i, const kernels::AlignLimits& limits)
      : a_(a),
        x_(a.x[i]),
        y_(a.y[i]),
        z_(a.z[i]),
        vx_(a.ax[i]),
        vy_(a.ay[i]),
        vz_(a.az[i]),
        r_(a.radius[i]),
        sin2_(limits.max_sin * limits.max_sin),
        offset2_(limits.max_offset * limits.max_offset),
        radius_(limits.max_radius) {}

  /// Of affordances j .. j + 15.
  LANE_FN std::uint32_t bits_from(std::int32_t j) const {
    const F16 wx = F16::load(a_.ax + j), wy = F16::load(a_.ay + j), wz = F16::load(a_.az + j);
    const F16 dx = F16::load(a_.x + j) - x_, dy = F16::load(a_.y + j) - y_, dz = F16::load(a_.z + j) - z_;
    const F16 cx = fnma(vz_, wy, vy_ * wz), cy = fnma(vx_, wz, vz_ * wx), cz = fnma(vy_, wx, vx_ * wy);
    const F16 s = fma(vx_, dx, fma(vy_, dy, vz_ * dz)), t = fma(wx, dx, fma(wy, dy, wz * dz));
    const F16 one = squared_norm(fnma(s, vx_, dx), fnma(s, vy_, dy), fnma(s, vz_, dz));
    const F16 other = squared_norm(fnma(t, wx, dx), fnma(t, wy, dy), fnma(t, wz, dz));
    return bits((squared_norm(cx, cy, cz) <= sin2_) & (one <= offset2_) & (other <= offset2_) &
                (abs(F16::load(a_.radius + j) - r_) <= radius_));
  }

 private:
  const kernels::AffordanceArrays& a_;
  F16 x_, y_, z_, vx_, vy_, vz_, r_, sin2_, offset2_, radius_;
};

/// kernels::Kernels::align
LANE_FN std::int32_t align_row(const kernels::AffordanceArrays& a, std::int32_t i, const kernels::AlignLimits& limits,
                               std::uint32_t* row) {
  const AlignedWith with(a, i, limits);
  for (std::int32_t word = 0; word < (a.padded + 31) / 32; ++word) row[word] = 0;
  std::int32_t n = 0;
  for (std::int32_t j = 0; j < a.padded; j += 16) {
    std::uint32_t aligned = with.bits_from(j);
    if (j == i / 16 * 16) aligned |= 1u << (i % 16);  // rounding may put an axis at an angle to itself
    row[j / 32] |= aligned << (j % 32);
    n += count_bits(aligned);
  }
  return n;
}

/// The number of bits in that row.
LANE_FN std::int32_t count_row(const kernels::AffordanceArrays& a, std::int32_t i, const kernels::AlignLimits& limits) {
  const AlignedWith with(a, i, limits);
  std::int32_t n = 0;
  LANE_SIDE_BY_SIDE
  for (std::int32_t j = 0; j < a.padded; j += 16) {
    std::uint32_t aligned = with.bits_from(j);
    if (j == i / 16 * 16) aligned |= 1u << (i % 16);
    n += count_bits(aligned);
  }
  return n;
}

}  // namespace handhold::HANDHOLD_LANE
