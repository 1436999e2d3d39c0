// Normal equations of a cylinder fitted to points by their distance from its surface, with Huber weights.
//
// Unknowns, all lengths: displacement of the axis along t1 and t2, its displacement along t1 and t2 at the distance
// `arm` along the axis, and the radius. With e = (D - r) / sigma, D the distance of a point from the axis, its weight
// is 1 up to |e| = 2 and 2 / |e| beyond.
//
// Of the fifteen sums of w a a^T, with a = (e1, e2, h e1, h e2, 1), three follow from others because e1^2 + e2^2 = 1,
// and one stands there twice.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// What the sums need of some of the points.
template <class F>
struct CylinderPoint {
  F e1, e2, h;  ///< unit vector across the axis; height in units of the arm
  F w, we;      ///< Huber's weight; times the residual
  F cost, d2;   ///< Huber's function; squared distance from the surface (m^2)
};

template <class F>
LANE_FN CylinderPoint<F> cylinder_point(F x, F y, F z, const kernels::CylinderQuery& q, float inverse, float per_arm) {
  const F one(1.0f), two(2.0f);
  x = x - F(q.point[0]), y = y - F(q.point[1]), z = z - F(q.point[2]);
  const F u = fma(F(q.t1[0]), x, fma(F(q.t1[1]), y, F(q.t1[2]) * z));
  const F v = fma(F(q.t2[0]), x, fma(F(q.t2[1]), y, F(q.t2[2]) * z));
  CylinderPoint<F> p;
  p.h = fma(F(q.axis[0]), x, fma(F(q.axis[1]), y, F(q.axis[2]) * z)) * F(per_arm);
  const F distance = sqrt(fma(u, u, v * v));
  const F scale = one / max(distance, F(1e-9f));
  p.e1 = u * scale, p.e2 = v * scale;
  const F d = distance - F(q.radius), e = d * F(inverse), size = abs(e);
  p.w = two / max(size, two);
  p.we = p.w * e;
  // w |e| is |e| up to 2, and 2 beyond.
  const F bound = abs(p.we);
  p.cost = bound * (size + size - bound);
  p.d2 = d * d;
  return p;
}

/// kernels::Kernels::cylinder
LANE_FN void cylinder_equations(const float* px, const float* py, const float* pz, std::int32_t n,
                                const kernels::CylinderQuery& q, kernels::CylinderEquations& out) {
  constexpr int kChunkPoints = 256;
  const float inverse = 1.0f / q.sigma, per_arm = 1.0f / q.arm;
  alignas(64) float rows[32][16];  // the last ones stay zero
  LANE_UNROLL(32)
  for (int k = 0; k < 32; ++k) F16(0.0f).store(rows[k]);
  // First what each point has, then its sums in groups that the registers hold.
  alignas(64) float e1[kChunkPoints], e2[kChunkPoints], h[kChunkPoints], w[kChunkPoints], we[kChunkPoints];
  for (std::int32_t first = 0; first < n; first += kChunkPoints) {
    const std::int32_t m = n - first < kChunkPoints ? n - first : kChunkPoints;
    LANE_ROLLED
    for (int lane = 0; lane < 16; lane += kSumLanes) {
      Sum cost = Sum::load(rows[18] + lane), square = Sum::load(rows[19] + lane);
      const auto keep = [&](const CylinderPoint<Sum>& p, std::int32_t at) LANE_INLINE {
        p.e1.store(e1 + at), p.e2.store(e2 + at), p.h.store(h + at), p.w.store(w + at), p.we.store(we + at);
        cost = cost + p.cost, square = square + p.d2;
      };
      const float *x = px + first, *y = py + first, *z = pz + first;
      std::int32_t i = lane;
      LANE_ROLLED
      for (; i + 16 - lane <= m; i += 16)
        keep(cylinder_point(Sum::loadu(x + i), Sum::loadu(y + i), Sum::loadu(z + i), q, inverse, per_arm), i);
      if (i - lane < m) {
        // What lies behind the last point may be anything, also NaN: there stands a point of the axis, without weight.
        const auto in = Sum::load(kLaneNumbers + lane) < Sum(static_cast<float>(m - i + lane));
        const Sum zero(0.0f);
        CylinderPoint<Sum> p = cylinder_point(select(in, Sum::loadu(x + i), Sum(q.point[0])),
                                              select(in, Sum::loadu(y + i), Sum(q.point[1])),
                                              select(in, Sum::loadu(z + i), Sum(q.point[2])), q, inverse, per_arm);
        p.w = select(in, p.w, zero), p.we = select(in, p.we, zero);
        p.cost = select(in, p.cost, zero), p.d2 = select(in, p.d2, zero);
        keep(p, i);
      }
      cost.store(rows[18] + lane), square.store(rows[19] + lane);
    }
    if (q.skip_above > 0 && n <= kChunkPoints) {
      out.cost = reduce_add(F16::load(rows[18]));
      out.square = reduce_add(F16::load(rows[19]));
      if (out.cost > q.skip_above) return;
    }
    LANE_ROLLED
    for (int lane = 0; lane < 16; lane += kSumLanes) {
      std::int32_t i = lane;
      // w, w h, w h^2; the same times e1^2; times e1 e2.
      Sum s[9];
      LANE_UNROLL(9)
      for (int k = 0; k < 9; ++k) s[k] = Sum::load(rows[k] + lane);
      LANE_ROLLED
      for (i = lane; i - lane < m; i += 16) {
        const Sum p = Sum::load(e1 + i), t = Sum::load(h + i);
        const Sum v0 = Sum::load(w + i), v1 = v0 * t, v2 = v1 * t;
        const Sum p0 = v0 * p, p1 = v1 * p, p2 = v2 * p, r = Sum::load(e2 + i);
        s[0] = s[0] + v0, s[1] = s[1] + v1, s[2] = s[2] + v2;
        s[3] = fma(p0, p, s[3]), s[4] = fma(p1, p, s[4]), s[5] = fma(p2, p, s[5]);
        s[6] = fma(p0, r, s[6]), s[7] = fma(p1, r, s[7]), s[8] = fma(p2, r, s[8]);
      }
      LANE_UNROLL(9)
      for (int k = 0; k < 9; ++k) s[k].store(rows[k] + lane);
      // (w, w h) times (e1, e2); w e times (e1, e2, h e1, h e2, 1).
      LANE_UNROLL(9)
      for (int k = 0; k < 9; ++k) s[k] = Sum::load(rows[9 + k] + lane);
      LANE_ROLLED
      for (i = lane; i - lane < m; i += 16) {
        const Sum p = Sum::load(e1 + i), r = Sum::load(e2 + i), t = Sum::load(h + i);
        const Sum v0 = Sum::load(w + i), v1 = v0 * t, f0 = Sum::load(we + i), f1 = f0 * t;
        s[0] = fma(v0, p, s[0]), s[1] = fma(v0, r, s[1]), s[2] = fma(v1, p, s[2]), s[3] = fma(v1, r, s[3]);
        s[4] = fma(f0, p, s[4]), s[5] = fma(f0, r, s[5]), s[6] = fma(f1, p, s[6]), s[7] = fma(f1, r, s[7]);
        s[8] = s[8] + f0;
      }
      LANE_UNROLL(9)
      for (int k = 0; k < 9; ++k) s[k].store(rows[9 + k] + lane);
    }
  }
  alignas(64) float t[32];
  reduce_rows(rows).store(t), reduce_rows(rows + 16).store(t + 16);
  // Rows of the lower triangle: (e1), (e2), (h e1), (h e2), (1).
  const float A[15] = {t[3],                                   //
                       t[6], t[0] - t[3],                      //
                       t[4], t[7],        t[5],                //
                       t[7], t[1] - t[4], t[8],  t[2] - t[5],  //
                       t[9], t[10],       t[11], t[12],       t[0]};
  for (int k = 0; k < 15; ++k) out.A[k] = A[k];
  for (int k = 0; k < 5; ++k) out.b[k] = t[13 + k];
  out.cost = t[18];
  out.square = t[19];
}

}  // namespace handhold::HANDHOLD_LANE
