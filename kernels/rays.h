// Where a surface of a depth image is narrowest, in eight directions and their opposites at a time.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// Of each lane the one eight lanes away.
LANE_FN F16 opposite(F16 a) {
  alignas(64) float lanes[32];
  a.store(lanes), a.store(lanes + 16);
  return F16::loadu(lanes + 8);
}

/// kernels::Kernels::narrowest
LANE_FN std::int32_t find_narrowest(const kernels::RayQuery& q, float* least) {
  const F16 zero(0.0f), none(-1.0f), jump(q.jump);
  const F16 width(static_cast<float>(q.width)), height(static_cast<float>(q.height));
  const F16 u0(q.column), v0(q.row), du = F16::loadu(q.out_column), dv = F16::loadu(q.out_row);
  const auto seen = [&](F16 u, F16 v) __attribute__((always_inline)) {
    const M16 in = (u >= zero) & (v >= zero) & (u < width) & (v < height);
    return select(in, gather(q.depth, select(in, u, zero), select(in, v, zero), q.width), zero);
  };
  F16 last = seen(u0, v0), before = last;
  // Where each direction's surface ends; -1: not yet, -2: it or its opposite does not.
  F16 end = none;
  M16 going = last > zero;
  const float wider = static_cast<float>(q.most) + 1.0f;
  F16 best(wider);
  for (std::int32_t k = 1; k <= q.most && any(going); ++k) {
    const auto pixels = static_cast<float>(k);
    const F16 z = seen(fma(F16(pixels), du, u0), fma(F16(pixels), dv, v0));
    const M16 lost = ~(z > zero) | (z < last - jump), step = z > last + jump;
    // A pixel on the edge may mix both depths.
    const M16 stops = going & (lost | step | (z > before + jump));
    before = last, last = z;
    if (!any(stops)) continue;
    end = select(stops, select(lost, F16(-2.0f), select(step, F16(pixels - 0.5f), F16(pixels - 1.0f))), end);
    const F16 other = opposite(end);
    end = select(other < none, other, end);
    const F16 both = select((end >= zero) & (other >= zero), end + other, best);
    best = F16(reduce_min(min(both, best)));
    // What goes on ends there at the earliest.
    going = going & ~stops & (end >= none) & (max(other, zero) + F16(pixels) <= best);
  }
  const F16 other = opposite(end);
  const F16 both = select((end >= zero) & (other >= zero), end + other, F16(wider));
  *least = reduce_min(both);
  return *least < wider ? __builtin_ctz(bits(both <= F16(*least))) : -1;
}

}  // namespace handhold::HANDHOLD_LANE
