// The plane of least squares through the tiles of a neighbourhood, one neighbourhood per lane, and which neighbourhoods
// are flat.
#pragma once

#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// Low-order sums about the sample: n, x y z, xx xy xz yy yz zz (m, m^2).
inline constexpr int kLowSums = 10;

template <class R>
struct RoughPlane {
  R up;         ///< height axis: 0, 1 or 2 for x, y or z
  R a, b;       ///< shear: height = w - a u - b v, with u and v the two axes after `up` in cyclic order
  R residual2;  ///< mean squared distance from the plane (m^2)
  R narrow2;    ///< variance along the plane's short side (m^2)
};

template <class R>
LANE_FN R squared_length(R x, R y, R z) {
  return fma(x, x, fma(y, y, z * z));
}

/// Smallest eigenvalue of the covariance by Newton's iteration from zero (monotone, since all roots are real and not
/// negative), normal from the cross product of two rows.
template <class R>
LANE_FN RoughPlane<R> rough_plane(const R* sums, float radius) {
  const R zero(0.0f), one(1.0f);
  const R n = sums[0];
  const R inverse = one / max(n, one);
  const R s1 = inverse * R(1.0f / radius), s2 = s1 * R(1.0f / radius);
  const R mx = sums[1] * s1, my = sums[2] * s1, mz = sums[3] * s1;
  const R a = fnma(mx, mx, sums[4] * s2), b = fnma(mx, my, sums[5] * s2);
  const R c = fnma(mx, mz, sums[6] * s2), d = fnma(my, my, sums[7] * s2);
  const R e = fnma(my, mz, sums[8] * s2), f = fnma(mz, mz, sums[9] * s2);
  const R trace = a + d + f;
  const R minors = fnma(b, b, a * d) + fnma(c, c, a * f) + fnma(e, e, d * f);
  const R determinant = a * fnma(e, e, d * f) - b * fnma(c, e, b * f) + c * fnma(c, d, b * e);
  R lambda = zero;
  LANE_ROLLED
  for (int i = 0; i < 8; ++i) {
    // p = det - lambda minors + lambda^2 trace - lambda^3
    const R p = fnma(minors - lambda * (trace - lambda), lambda, determinant);
    const R slope = minors - lambda * (R(2.0f) * trace - R(3.0f) * lambda);
    lambda = lambda + select(slope > R(1e-12f), p / max(slope, R(1e-12f)), zero);
  }
  lambda = max(lambda, zero);
  RoughPlane<R> out;
  out.residual2 = lambda * R(radius * radius);
  // The other two roots have the sum t and the product p; the smaller one.
  const R t = trace - lambda, p = fnma(lambda, t, minors);
  const R middle = R(0.5f) * t - sqrt(max(fnma(one, p, R(0.25f) * t * t), zero));
  out.narrow2 = middle * R(radius * radius);
  // Normal: the longest cross product of two rows of (C - lambda I).
  const R ra = a - lambda, rd = d - lambda, rf = f - lambda;
  const R x0 = b * e - c * rd, y0 = c * b - ra * e, z0 = ra * rd - b * b;  // row 0 x row 1
  const R x1 = b * rf - c * e, y1 = c * c - ra * rf, z1 = ra * e - b * c;  // row 0 x row 2
  const R x2 = rd * rf - e * e, y2 = e * c - b * rf, z2 = b * e - rd * c;  // row 1 x row 2
  R nx = x0, ny = y0, nz = z0, best = squared_length(x0, y0, z0);
  const R l1 = squared_length(x1, y1, z1), l2 = squared_length(x2, y2, z2);
  auto better = l1 > best;
  nx = select(better, x1, nx), ny = select(better, y1, ny), nz = select(better, z1, nz),
  best = select(better, l1, best);
  better = l2 > best;
  nx = select(better, x2, nx), ny = select(better, y2, ny), nz = select(better, z2, nz),
  best = select(better, l2, best);
  const auto none = invert(best > R(1e-30f));
  nx = select(none, zero, nx), ny = select(none, zero, ny), nz = select(none, one, nz);
  // Height along the coordinate axis nearest the normal; u, v are the other two in cyclic order.
  const R ax = abs(nx), ay = abs(ny), az = abs(nz);
  const auto is_z = (az >= ax) & (az >= ay);
  const auto is_y = invert(is_z) & (ay >= ax);
  const R w = select(is_z, nz, select(is_y, ny, nx));
  const R u = select(is_z, nx, select(is_y, nz, ny));
  const R v = select(is_z, ny, select(is_y, nx, nz));
  out.up = select(is_z, R(2.0f), select(is_y, one, zero));
  out.a = -(u / w);
  out.b = -(v / w);
  return out;
}

/// Whether a neighbourhood of about `points` points holds nothing but a plane; see kernels::NeighbourhoodBatch.
LANE_FN bool is_flat(float points, float residual2, float narrow2, float radius, float flat_rms, float flat_slope) {
  float flat = flat_rms;
  if (flat_slope > 0.0f && flat_slope * narrow2 < flat) flat = flat_slope * narrow2;
  // Twelve points are enough to tell a plane; fewer go on and are judged by their exact number.
  // Points on a line are flat, too: float sums cannot tell what lies beside it.
  const bool line = flat_slope > 0.0f && narrow2 <= 1e-5f * radius * radius;
  return points >= 12.0f && (line || residual2 < flat * flat);
}

}  // namespace handhold::HANDHOLD_LANE
