// What a depth image shows in sixteen directions, or at sixteen places, at a time.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// Depths of an image's pixels; 0 outside of it.
struct Pixels {
  const float* depth;
  std::int32_t row_width;
  F16 width, height;
  LANE_FN Pixels(const float* d, std::int32_t w, std::int32_t h)
      : depth(d), row_width(w), width(static_cast<float>(w)), height(static_cast<float>(h)) {}
  LANE_FN F16 at(F16 u, F16 v) const {
    const F16 zero(0.0f);
    const M16 in = (u >= zero) & (v >= zero) & (u < width) & (v < height);
    return select(in, gather(depth, select(in, u, zero), select(in, v, zero), row_width), zero);
  }
};

/// kernels::Kernels::inverse_depths
LANE_FN void find_inverse_depths(const kernels::PlaceQuery& q, float* means) {
  const F16 zero(0.0f), one(1.0f), u = F16::loadu(q.column), v = F16::loadu(q.row);
  const Pixels image(q.depth, q.width, q.height);
  const F16 z[5] = {image.at(u, v), image.at(u + one, v), image.at(u - one, v), image.at(u, v + one),
                    image.at(u, v - one)};
  F16 sum = zero;
  M16 known = zero < one;
  LANE_UNROLL(5)
  for (int k = 0; k < 5; ++k) known = known & (z[k] > zero), sum = sum + one / z[k];
  select(known, F16(0.2f) * sum, zero).storeu(means);
}

/// kernels::Kernels::ray_ends
LANE_FN void find_ray_ends(const kernels::RayQuery& q, float* ends) {
  const F16 zero(0.0f), none(-1.0f), jump(q.jump);
  const Pixels image(q.depth, q.width, q.height);
  const F16 u0(q.column), v0(q.row), du = F16::loadu(q.out_column), dv = F16::loadu(q.out_row);
  F16 last = image.at(u0, v0), before = last, end = none;
  M16 going = last > zero;
  for (std::int32_t k = 1; k <= q.most && any(going); ++k) {
    const auto pixels = static_cast<float>(k);
    const F16 z = image.at(fma(F16(pixels), du, u0), fma(F16(pixels), dv, v0));
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
