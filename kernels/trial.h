// Cylinders fitted to a few points each by their distance from its surface, one cylinder a lane: Levenberg and
// Marquardt's iteration on the normal equations of cylinder.h.
#pragma once

#include "curvature.h"
#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

struct TrialCylinder {
  Vec3<Sum> point, axis;
  Sum radius;
};
/// The equations at a cylinder; t1 and t2: the unit vectors across its axis that they are about.
struct TrialEquations {
  Vec3<Sum> t1, t2;
  Sum A[15], b[5];
  Sum cost, square;
};

LANE_FN Vec3<Sum> select3(Mask<float, kSumLanes> m, const Vec3<Sum>& a, const Vec3<Sum>& b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
LANE_FN Vec3<Sum> load3(const float (*p)[16], int lane) {
  return {Sum::load(p[0] + lane), Sum::load(p[1] + lane), Sum::load(p[2] + lane)};
}
LANE_FN void store3(const Vec3<Sum>& v, float (*p)[16], int lane) {
  v.x.store(p[0] + lane), v.y.store(p[1] + lane), v.z.store(p[2] + lane);
}
LANE_FN Vec3<Sum> unit(const Vec3<Sum>& v) {
  const Sum inverse = Sum(1.0f) / sqrt(dot(v, v));
  return {v.x * inverse, v.y * inverse, v.z * inverse};
}

/// `equations`: A and b are wanted, too.
LANE_FN void trial_equations(const kernels::CylinderTrials& t, int lane, const TrialCylinder& c, bool equations,
                             TrialEquations& out) {
  constexpr int n = kernels::CylinderTrials::kPoints;
  const Sum zero(0.0f), one(1.0f), two(2.0f);
  const Sum inverse = one / Sum::load(t.sigma + lane), per_arm(1.0f / t.arm);
  // Two directions across the axis (Duff et al. 2017).
  const Vec3<Sum>& w = c.axis;
  const Sum sign = select(w.z < zero, Sum(-1.0f), one), s = Sum(-1.0f) / (sign + w.z), xy = w.x * w.y * s;
  out.t1 = {fma(sign * w.x, w.x * s, one), sign * xy, -sign * w.x};
  out.t2 = {xy, fma(w.y, w.y * s, sign), -w.y};
  alignas(64) float e1[n][kSumLanes], e2[n][kSumLanes], h[n][kSumLanes], weight[n][kSumLanes], we[n][kSumLanes];
  Sum cost = zero, square = zero;
  LANE_ROLLED
  for (int i = 0; i < n; ++i) {
    const Vec3<Sum> p = {Sum::load(t.points[i][0] + lane) - c.point.x, Sum::load(t.points[i][1] + lane) - c.point.y,
                         Sum::load(t.points[i][2] + lane) - c.point.z};
    const Sum u = dot(out.t1, p), v = dot(out.t2, p);
    const Sum distance = sqrt(fma(u, u, v * v)), scale = one / max(distance, Sum(1e-9f));
    const Sum d = distance - c.radius, e = d * inverse, size = abs(e);
    const Sum g = two / max(size, two), ge = g * e, bound = abs(ge);
    (u * scale).store(e1[i]), (v * scale).store(e2[i]), (dot(w, p) * per_arm).store(h[i]);
    g.store(weight[i]), ge.store(we[i]);
    cost = fma(bound, size + size - bound, cost), square = fma(d, d, square);
  }
  out.cost = cost, out.square = square;
  if (!equations) {
    LANE_UNROLL(15)
    for (int k = 0; k < 15; ++k) out.A[k] = zero;
    LANE_UNROLL(5)
    for (int k = 0; k < 5; ++k) out.b[k] = zero;
    return;
  }
  Sum s1[9], s2[9];
  LANE_UNROLL(9)
  for (int k = 0; k < 9; ++k) s1[k] = s2[k] = zero;
  LANE_ROLLED
  for (int i = 0; i < n; ++i) {
    const Sum p = Sum::load(e1[i]), r = Sum::load(e2[i]), x = Sum::load(h[i]);
    const Sum v0 = Sum::load(weight[i]), v1 = v0 * x, v2 = v1 * x, p0 = v0 * p, p1 = v1 * p, p2 = v2 * p;
    s1[0] = s1[0] + v0, s1[1] = s1[1] + v1, s1[2] = s1[2] + v2;
    s1[3] = fma(p0, p, s1[3]), s1[4] = fma(p1, p, s1[4]), s1[5] = fma(p2, p, s1[5]);
    s1[6] = fma(p0, r, s1[6]), s1[7] = fma(p1, r, s1[7]), s1[8] = fma(p2, r, s1[8]);
  }
  LANE_ROLLED
  for (int i = 0; i < n; ++i) {
    const Sum p = Sum::load(e1[i]), r = Sum::load(e2[i]), x = Sum::load(h[i]);
    const Sum v0 = Sum::load(weight[i]), v1 = v0 * x, f0 = Sum::load(we[i]), f1 = f0 * x;
    s2[0] = fma(v0, p, s2[0]), s2[1] = fma(v0, r, s2[1]), s2[2] = fma(v1, p, s2[2]), s2[3] = fma(v1, r, s2[3]);
    s2[4] = fma(f0, p, s2[4]), s2[5] = fma(f0, r, s2[5]), s2[6] = fma(f1, p, s2[6]), s2[7] = fma(f1, r, s2[7]);
    s2[8] = s2[8] + f0;
  }
  // As in cylinder_equations.
  const Sum A[15] = {s1[3],                                       //
                     s1[6], s1[0] - s1[3],                        //
                     s1[4], s1[7],         s1[5],                 //
                     s1[7], s1[1] - s1[4], s1[8], s1[2] - s1[5],  //
                     s2[0], s2[1],         s2[2], s2[3],         s1[0]};
  LANE_UNROLL(15)
  for (int k = 0; k < 15; ++k) out.A[k] = A[k];
  LANE_UNROLL(5)
  for (int k = 0; k < 5; ++k) out.b[k] = s2[4 + k];
}

/// Solves (A + damping * diag(A) + ridge * I) x = b by L D L^T; the mask of the lanes in which it is definite.
LANE_FN auto trial_solve(const TrialEquations& q, Sum damping, Sum b_scale, Sum* x) {
  const Sum zero(0.0f), one(1.0f), ridge(1e-3f);
  Sum L[5][5], D[5], inverse[5];
  auto definite = zero < one;
  int k = 0;
  LANE_UNROLL(5)
  for (int i = 0; i < 5; ++i) {
    LANE_UNROLL(5)
    for (int j = 0; j < i; ++j, ++k) {
      Sum v = q.A[k];
      LANE_UNROLL(5)
      for (int m = 0; m < j; ++m) v = fnma(L[i][m] * D[m], L[j][m], v);
      L[i][j] = v * inverse[j];
    }
    D[i] = fma(q.A[k++], one + damping, ridge);
    LANE_UNROLL(5)
    for (int m = 0; m < i; ++m) D[i] = fnma(L[i][m] * L[i][m], D[m], D[i]);
    definite = definite & (D[i] > zero);
    inverse[i] = one / D[i];
  }
  LANE_UNROLL(5)
  for (int i = 0; i < 5; ++i) {
    x[i] = b_scale * q.b[i];
    LANE_UNROLL(5)
    for (int m = 0; m < i; ++m) x[i] = fnma(L[i][m], x[m], x[i]);
  }
  LANE_UNROLL(5)
  for (int i = 4; i >= 0; --i) {
    x[i] = x[i] * inverse[i];
    LANE_UNROLL(5)
    for (int m = i + 1; m < 5; ++m) x[i] = fnma(L[m][i], x[m], x[i]);
  }
  return definite;
}

/// kernels::Kernels::try_cylinders
LANE_FN void fit_trials(kernels::CylinderTrials& t) {
  constexpr int n = kernels::CylinderTrials::kPoints;
  const Sum zero(0.0f), one(1.0f), per_arm(1.0f / t.arm);
  LANE_ROLLED
  for (int lane = 0; lane < 16; lane += kSumLanes) {
    TrialCylinder c = {load3(t.point, lane), load3(t.axis, lane), Sum::load(t.radius + lane)};
    const Sum sigma = Sum::load(t.sigma + lane);
    // Beside the points' mean.
    Vec3<Sum> mean = {zero, zero, zero};
    for (int i = 0; i < n; ++i) {
      mean.x = mean.x + Sum::load(t.points[i][0] + lane), mean.y = mean.y + Sum::load(t.points[i][1] + lane);
      mean.z = mean.z + Sum::load(t.points[i][2] + lane);
    }
    const Sum share(1.0f / n);
    const Sum along =
        dot(c.axis, {fma(mean.x, share, -c.point.x), fma(mean.y, share, -c.point.y), fma(mean.z, share, -c.point.z)});
    c.point = add_scaled(c.point, along, c.axis);
    TrialEquations here, there;
    trial_equations(t, lane, c, t.steps > 0, here);
    Sum damping(1e-3f), failed(0.0f);
    auto going = zero < one;
    for (std::int32_t step = 0; step < t.steps && any(going); ++step) {
      Sum x[5];
      const auto definite = trial_solve(here, damping, sigma, x);
      const auto moved = [&](const Vec3<Sum>& v, Sum a, Sum b)
                             LANE_INLINE { return add_scaled(add_scaled(v, b, here.t2), a, here.t1); };
      const TrialCylinder next = {moved(c.point, x[0], x[1]), unit(moved(c.axis, x[2] * per_arm, x[3] * per_arm)),
                                  c.radius + x[4]};
      trial_equations(t, lane, next, step + 1 < t.steps, there);
      const auto valid = going & definite &
                         (next.radius > Sum(static_cast<float>(kernels::CylinderTrials::kSmallest))) &
                         (next.radius < Sum(static_cast<float>(kernels::CylinderTrials::kLargest)));
      const auto better = valid & (there.cost < here.cost);
      const auto small =
          better & (there.cost > Sum(1.0f - static_cast<float>(kernels::CylinderTrials::kLeastGain)) * here.cost);
      damping = damping * select(better, Sum(0.3f), Sum(10.0f));
      failed = select(better, zero, failed + one);
      c.point = select3(better, next.point, c.point), c.axis = select3(better, next.axis, c.axis);
      c.radius = select(better, next.radius, c.radius);
      here.t1 = select3(better, there.t1, here.t1), here.t2 = select3(better, there.t2, here.t2);
      LANE_UNROLL(15)
      for (int k = 0; k < 15; ++k) here.A[k] = select(better, there.A[k], here.A[k]);
      LANE_UNROLL(5)
      for (int k = 0; k < 5; ++k) here.b[k] = select(better, there.b[k], here.b[k]);
      here.cost = select(better, there.cost, here.cost), here.square = select(better, there.square, here.square);
      going = going & ~small & (failed < Sum(3.0f));
    }
    // The outermost points about the axis; as in turns.h.
    const Vec3<Sum> to = load3(t.towards, lane);
    const Vec3<Sum> flat = add_scaled(to, -dot(to, c.axis), c.axis);
    const Vec3<Sum> ahead = select3(dot(flat, flat) > Sum(1e-12f), unit(flat), here.t1), side = cross(c.axis, ahead);
    Sum least(3.0f), most(-3.0f);
    LANE_ROLLED
    for (int i = 0; i < n; ++i) {
      const Vec3<Sum> p = {Sum::load(t.points[i][0] + lane) - c.point.x, Sum::load(t.points[i][1] + lane) - c.point.y,
                           Sum::load(t.points[i][2] + lane) - c.point.z};
      const Sum a = dot(ahead, p), b = dot(side, p), size = one - a / max(abs(a) + abs(b), Sum(1e-30f));
      const Sum turn = select(b < zero, -size, size);
      least = min(turn, least), most = max(turn, most);
    }
    store3(c.point, t.point, lane), store3(c.axis, t.axis, lane), c.radius.store(t.radius + lane);
    sqrt(here.square * share).store(t.rms + lane);
    least.store(t.least_turn + lane), most.store(t.most_turn + lane);
  }
}

}  // namespace handhold::HANDHOLD_LANE
