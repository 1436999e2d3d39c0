// Which places beside a part were seen to be empty, sixteen columns of a finger at a time.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// kernels::Kernels::free_places
LANE_FN void count_free_places(const kernels::FreeQuery& q, float* free) {
  const F16 zero(0.0f), one(1.0f), half(0.5f), nearest(0.02f), tolerance(q.tolerance);
  const F16 width(static_cast<float>(q.width)), height(static_cast<float>(q.height));
  for (std::int32_t first = q.first; first < q.columns; first += 16) {
    const F16 column = lane_numbers() + F16(static_cast<float>(first));
    const F16 a0 = fma(column, F16(q.out[0]), F16(q.corner[0])), b0 = fma(column, F16(q.out[1]), F16(q.corner[1]));
    const F16 d0 = fma(column, F16(q.out[2]), F16(q.corner[2]));
    F16 sum = zero;
    for (std::int32_t r = 0; r < q.rows; ++r) {
      const F16 row(static_cast<float>(r));
      const F16 a1 = fma(row, F16(q.up[0]), a0), b1 = fma(row, F16(q.up[1]), b0), d1 = fma(row, F16(q.up[2]), d0);
      for (std::int32_t l = 0; l < q.layers; ++l) {
        const F16 layer(static_cast<float>(l));
        const F16 depth = fma(layer, F16(q.along[2]), d1), inverse = one / depth;
        const F16 u = fma(fma(layer, F16(q.along[0]), a1), inverse, half);
        const F16 v = fma(fma(layer, F16(q.along[1]), b1), inverse, half);
        const M16 in = (depth > nearest) & (u >= zero) & (v >= zero) & (u < width) & (v < height);
        const F16 seen = gather(q.depth, select(in, u, zero), select(in, v, zero), q.width);
        sum = add_where(in & (seen > depth + tolerance), sum, one);
      }
    }
    sum.storeu(free + first);
  }
}

}  // namespace handhold::HANDHOLD_LANE
