// Normal equations of a cylinder fitted to points by their distance from its surface, with Huber weights.
//
// Unknowns, all lengths: displacement of the axis along t1 and t2, its displacement along t1 and t2 at the distance
// `arm` along the axis, and the radius. With e = (D - r) / sigma, D the distance of a point from the axis, its weight
// is 1 up to |e| = 2 and 2 / |e| beyond.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// kernels::Kernels::cylinder
LANE_FN void cylinder_equations(const float* px, const float* py, const float* pz, std::int32_t n,
                                const kernels::CylinderQuery& q, kernels::CylinderEquations& out) {
  alignas(64) static constexpr float kLane[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const F16 zero(0.0f), one(1.0f), two(2.0f), lane = F16::load(kLane);
  const F16 cx(q.point[0]), cy(q.point[1]), cz(q.point[2]);
  const F16 ax(q.axis[0]), ay(q.axis[1]), az(q.axis[2]);
  const F16 ux(q.t1[0]), uy(q.t1[1]), uz(q.t1[2]), vx(q.t2[0]), vy(q.t2[1]), vz(q.t2[2]);
  const F16 radius(q.radius), inverse(1.0f / q.sigma), per_arm(1.0f / q.arm);
  F16 A[15], b[5], cost = zero, square = zero;
#pragma GCC unroll 15
  for (int i = 0; i < 15; ++i) A[i] = zero;
#pragma GCC unroll 5
  for (int i = 0; i < 5; ++i) b[i] = zero;
  for (std::int32_t i = 0; i < n; i += 16) {
    const M16 in = lane < F16(static_cast<float>(n - i));
    // What lies behind the last point may be anything, also NaN.
    const F16 x = select(in, F16::loadu(px + i), cx) - cx, y = select(in, F16::loadu(py + i), cy) - cy;
    const F16 z = select(in, F16::loadu(pz + i), cz) - cz;
    const F16 u = fma(ux, x, fma(uy, y, uz * z)), v = fma(vx, x, fma(vy, y, vz * z));
    const F16 h = fma(ax, x, fma(ay, y, az * z)) * per_arm;
    const F16 distance = sqrt(fma(u, u, v * v));
    const F16 scale = one / max(distance, F16(1e-9f));
    const F16 e1 = u * scale, e2 = v * scale;
    const F16 d = select(in, distance - radius, zero);
    const F16 e = d * inverse, size = abs(e);
    const M16 near = size < two;
    const F16 weight = select(in, select(near, one, two / max(size, two)), zero);
    square = fma(d, d, square);
    cost = cost + select(near, e * e, two * (size + size - two));
    const F16 a[5] = {e1, e2, h * e1, h * e2, one};
    const F16 we = weight * e;
#pragma GCC unroll 5
    for (int j = 0; j < 5; ++j) {
      const F16 wa = weight * a[j];
      b[j] = fma(we, a[j], b[j]);
#pragma GCC unroll 5
      for (int k = 0; k <= j; ++k) A[j * (j + 1) / 2 + k] = fma(wa, a[k], A[j * (j + 1) / 2 + k]);
    }
  }
#pragma GCC unroll 15
  for (int i = 0; i < 15; ++i) out.A[i] = reduce_add(A[i]);
#pragma GCC unroll 5
  for (int i = 0; i < 5; ++i) out.b[i] = reduce_add(b[i]);
  out.cost = reduce_add(cost);
  out.square = reduce_add(square);
}

}  // namespace handhold::HANDHOLD_LANE
