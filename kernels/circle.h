// Circle across an axis from the moments of degree 3 and less, one problem per lane (paper, section 3.2, eq. 3).
//
// The algebraic fit minimises sum (rho^2 - 2 u a - 2 v b - c)^2 over the points' coordinates (u, v) across the axis.
// About the mean of the points its normal equations are a 2x2:
//   [Suu Suv; Suv Svv] (a, b) = (sum u (u^2 + v^2), sum v (u^2 + v^2)) / 2
// and the squared radius is a^2 + b^2 + (Suu + Svv) / n. Working about the mean is what keeps it accurate. Nothing has
// to be summed again: u^2 + v^2 = |p|^2 - (w . p)^2 is a contraction of the moments of degree 3.
#pragma once

#include "curvature.h"
#include "kernels.h"
#include "lane.h"
#include "moment_shift.h"

namespace handhold::HANDHOLD_LANE {

/// moments: sums of monomials about the sample; w: unit axis. centre: point of the circle's axis in the plane through
/// the sample; radius: infinity where the points lie on a line across the axis.
template <class R>
LANE_FN void circle_fit(const R* moments, const Vec3<R>& w, Vec3<R>& centre, R& radius) {
  const R inverse_n = R(1.0) / moments[0];
  const Vec3<R> m = {moments[1] * inverse_n, moments[2] * inverse_n, moments[3] * inverse_n};
  const R rxx = moments[4] * inverse_n, rxy = moments[5] * inverse_n, rxz = moments[6] * inverse_n;
  const R ryy = moments[7] * inverse_n, ryz = moments[8] * inverse_n, rzz = moments[9] * inverse_n;
  const R cxx = fnma(m.x, m.x, rxx), cxy = fnma(m.x, m.y, rxy), cxz = fnma(m.x, m.z, rxz);
  const R cyy = fnma(m.y, m.y, ryy), cyz = fnma(m.y, m.z, ryz), czz = fnma(m.z, m.z, rzz);
  // Third central moments: E[abc] - m_a E[bc] - m_b E[ac] - m_c E[ab] + 2 m_a m_b m_c.
  const auto third = [&](int index, R ma, R mb, R mc, R bc, R ac, R ab) LANE_INLINE {
    R t = moments[index] * inverse_n;
    t = fnma(ma, bc, t), t = fnma(mb, ac, t), t = fnma(mc, ab, t);
    return fma(R(2.0) * ma, mb * mc, t);
  };
  const R xxx = third(10, m.x, m.x, m.x, rxx, rxx, rxx), xxy = third(11, m.x, m.x, m.y, rxy, rxy, rxx);
  const R xxz = third(12, m.x, m.x, m.z, rxz, rxz, rxx), xyy = third(13, m.x, m.y, m.y, ryy, rxy, rxy);
  const R xyz = third(14, m.x, m.y, m.z, ryz, rxz, rxy), xzz = third(15, m.x, m.z, m.z, rzz, rxz, rxz);
  const R yyy = third(16, m.y, m.y, m.y, ryy, ryy, ryy), yyz = third(17, m.y, m.y, m.z, ryz, ryz, ryy);
  const R yzz = third(18, m.y, m.z, m.z, rzz, ryz, ryz), zzz = third(19, m.z, m.z, m.z, rzz, rzz, rzz);
  // q = E[rho^2 p] = E[|p|^2 p] - E[(w.p)^2 p]
  const R wxx = w.x * w.x, wyy = w.y * w.y, wzz = w.z * w.z;
  const R wxy = R(2.0) * w.x * w.y, wxz = R(2.0) * w.x * w.z, wyz = R(2.0) * w.y * w.z;
  const auto contract = [&](R xx, R xy, R xz, R yy, R yz, R zz) LANE_INLINE {
    R t = xx + yy + zz;
    t = fnma(wxx, xx, t), t = fnma(wyy, yy, t), t = fnma(wzz, zz, t);
    t = fnma(wxy, xy, t), t = fnma(wxz, xz, t);
    return fnma(wyz, yz, t);
  };
  const Vec3<R> q = {contract(xxx, xxy, xxz, xyy, xyz, xzz), contract(xxy, xyy, xyz, yyy, yyz, yzz),
                     contract(xxz, xyz, xzz, yyz, yzz, zzz)};
  // A basis across the axis.
  const R sign = select(w.z < R(0.0), R(-1.0), R(1.0));
  const R s = R(-1.0) / (sign + w.z);
  const R t = w.x * w.y * s;
  const Vec3<R> u = {fma(sign * w.x, w.x * s, R(1.0)), sign * t, -sign * w.x};
  const Vec3<R> v = {t, fma(w.y, w.y * s, sign), -w.y};
  const auto covariance_times = [&](const Vec3<R>& p) LANE_INLINE {
    return Vec3<R>{fma(cxx, p.x, fma(cxy, p.y, cxz * p.z)), fma(cxy, p.x, fma(cyy, p.y, cyz * p.z)),
                   fma(cxz, p.x, fma(cyz, p.y, czz * p.z))};
  };
  const Vec3<R> cu = covariance_times(u), cv = covariance_times(v);
  const R suu = dot(u, cu), suv = dot(u, cv), svv = dot(v, cv);
  const R bu = R(0.5) * dot(q, u), bv = R(0.5) * dot(q, v);
  const R determinant = fnma(suv, suv, suu * svv), trace = suu + svv;
  const auto line = invert(determinant > R(1e-12) * trace * trace);
  const R inverse = R(1.0) / select(line, R(1.0), determinant);
  const R a = fnma(suv, bv, svv * bu) * inverse, b = fnma(suv, bu, suu * bv) * inverse;
  radius = select(line, R(infinity()), sqrt(fma(a, a, fma(b, b, trace))));
  // Centre, moved along the axis into the plane through the sample.
  centre = add_scaled(add_scaled(m, select(line, R(0.0), a), u), select(line, R(0.0), b), v);
  centre = add_scaled(centre, -dot(centre, w), w);
}

}  // namespace handhold::HANDHOLD_LANE
