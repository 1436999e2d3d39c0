// Which affordances are aligned with which (paper, section 3.3), sixteen at a time.
#pragma once

#include "kernels.h"
#include "lane.h"
#include "neighbours.h"

namespace handhold::HANDHOLD_LANE {

/// kernels::Kernels::align. With unit axes v and centres h: d_o = |(I - v_i v_i^T) v_j| = |v_i x v_j|,
/// d_c = |(I - v_i v_i^T)(h_i - h_j)|, which is not symmetric, so the larger of the two ways counts, d_r = |r_i - r_j|.
LANE_FN void align_row(const kernels::AffordanceArrays& a, std::int32_t i, const kernels::AlignLimits& limits,
                       std::uint32_t* row) {
  const F16 x(a.x[i]), y(a.y[i]), z(a.z[i]), vx(a.ax[i]), vy(a.ay[i]), vz(a.az[i]), r(a.radius[i]);
  const F16 sin2(limits.max_sin * limits.max_sin), offset2(limits.max_offset * limits.max_offset);
  const F16 radius(limits.max_radius);
  for (std::int32_t word = 0; word < (a.padded + 31) / 32; ++word) row[word] = 0;
  for (std::int32_t j = 0; j < a.padded; j += 16) {
    const F16 wx = F16::load(a.ax + j), wy = F16::load(a.ay + j), wz = F16::load(a.az + j);
    const F16 dx = F16::load(a.x + j) - x, dy = F16::load(a.y + j) - y, dz = F16::load(a.z + j) - z;
    const F16 cx = fnma(vz, wy, vy * wz), cy = fnma(vx, wz, vz * wx), cz = fnma(vy, wx, vx * wy);
    const F16 s = fma(vx, dx, fma(vy, dy, vz * dz)), t = fma(wx, dx, fma(wy, dy, wz * dz));
    const F16 one = squared_norm(fnma(s, vx, dx), fnma(s, vy, dy), fnma(s, vz, dz));
    const F16 other = squared_norm(fnma(t, wx, dx), fnma(t, wy, dy), fnma(t, wz, dz));
    const M16 aligned = (squared_norm(cx, cy, cz) <= sin2) & (one <= offset2) & (other <= offset2) &
                        (abs(F16::load(a.radius + j) - r) <= radius);
    row[j / 32] |= bits(aligned) << (j % 32);
  }
  row[i / 32] |= 1u << (i % 32);  // rounding may put an axis at an angle to itself
}

}  // namespace handhold::HANDHOLD_LANE
