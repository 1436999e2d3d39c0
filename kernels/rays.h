// Where the surface at a place of a depth image ends, in sixteen directions at a time.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// kernels::Kernels::ray_ends
LANE_FN void find_ray_ends(const kernels::RayQuery& q, float* ends) {
  const F16 zero(0.0f), none(-1.0f), jump(q.jump);
  const F16 width(static_cast<float>(q.width)), height(static_cast<float>(q.height));
  const F16 u0(q.column), v0(q.row), du = F16::loadu(q.out_column), dv = F16::loadu(q.out_row);
  const auto seen = [&](F16 u, F16 v) __attribute__((always_inline)) {
    const M16 in = (u >= zero) & (v >= zero) & (u < width) & (v < height);
    return select(in, gather(q.depth, select(in, u, zero), select(in, v, zero), q.width), zero);
  };
  F16 last = seen(u0, v0), before = last, end = none;
  M16 going = last > zero;
  for (std::int32_t k = 1; k <= q.most && any(going); ++k) {
    const auto pixels = static_cast<float>(k);
    const F16 z = seen(fma(F16(pixels), du, u0), fma(F16(pixels), dv, v0));
    const M16 lost = ~(z > zero) | (z < last - jump), step = z > last + jump;
    // A pixel on the edge may mix both depths.
    const M16 stops = going & (lost | step | (z > before + jump));
    end = select(stops, select(lost, none, select(step, F16(pixels - 0.5f), F16(pixels - 1.0f))), end);
    going = going & ~stops;
    before = last, last = z;
  }
  end.storeu(ends);
}

}  // namespace handhold::HANDHOLD_LANE
