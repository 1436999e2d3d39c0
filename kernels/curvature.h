// Principal curvatures of an implicit quadric, one problem per lane (paper, section 3.1).
//
// With g = grad f, H = its Hessian, n = g/|g| and P = I - n n^T the shape operator is P H P / |g|. Curvatures come from
// its invariants, directions from a 2x2 in a tangent basis.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

template <class R>
struct Vec3 {
  R x, y, z;
};
template <class R>
LANE_FN R dot(const Vec3<R>& a, const Vec3<R>& b) {
  return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}
template <class R>
LANE_FN Vec3<R> cross(const Vec3<R>& a, const Vec3<R>& b) {
  return {fnma(a.z, b.y, a.y * b.z), fnma(a.x, b.z, a.z * b.x), fnma(a.y, b.x, a.x * b.y)};
}
/// a + s b
template <class R>
LANE_FN Vec3<R> add_scaled(const Vec3<R>& a, R s, const Vec3<R>& b) {
  return {fma(s, b.x, a.x), fma(s, b.y, a.y), fma(s, b.z, a.z)};
}

/// A gradient shorter than this (squared) has no direction: a cone's tip, or a fit without a surface.
inline constexpr double kTinyGradient2 = 1e-24;

template <class R>
struct Quadric {
  R xx, yy, zz, xy, yz, xz;  ///< Hessian
  Vec3<R> linear;
  R constant;

  /// From coefficients in the order of l.
  LANE_FN explicit Quadric(const R* c)
      : xx(c[0] + c[0]),
        yy(c[1] + c[1]),
        zz(c[2] + c[2]),
        xy(c[3]),
        yz(c[4]),
        xz(c[5]),
        linear{c[6], c[7], c[8]},
        constant(c[9]) {}

  LANE_FN Vec3<R> hessian_times(const Vec3<R>& v) const {
    return {fma(xx, v.x, fma(xy, v.y, xz * v.z)), fma(xy, v.x, fma(yy, v.y, yz * v.z)),
            fma(xz, v.x, fma(yz, v.y, zz * v.z))};
  }
  LANE_FN Vec3<R> gradient(const Vec3<R>& p) const {
    const Vec3<R> h = hessian_times(p);
    return {h.x + linear.x, h.y + linear.y, h.z + linear.z};
  }
  /// f(p), given the gradient there: x^T H x / 2 + l x + c = (g + l) x / 2 + c.
  LANE_FN R value(const Vec3<R>& p, const Vec3<R>& g) const {
    const Vec3<R> s = {g.x + linear.x, g.y + linear.y, g.z + linear.z};
    return fma(R(0.5), dot(s, p), constant);
  }
  /// The point brought to the surface by two Newton steps along the gradient.
  LANE_FN Vec3<R> foot(Vec3<R> p) const {
    LANE_UNROLL(2)
    for (int step = 0; step < 2; ++step) {
      const Vec3<R> g = gradient(p);
      const R g2 = max(dot(g, g), R(kTinyGradient2));
      p = add_scaled(p, -(value(p, g) / g2), g);
    }
    return p;
  }
};

/// Invariants of the shape operator at a point, and its normal.
template <class R>
struct Shape {
  Vec3<R> normal;  ///< unit, along the gradient
  R inverse_g;     ///< 1 / |g|
};
template <class R>
LANE_FN Shape<R> shape_at(const Quadric<R>& q, const Vec3<R>& p) {
  const Vec3<R> g = q.gradient(p);
  const R inverse = R(1.0) / sqrt(max(dot(g, g), R(kTinyGradient2)));
  return {{g.x * inverse, g.y * inverse, g.z * inverse}, inverse};
}

/// The larger absolute principal curvature at a point, from trace and determinant of the shape operator.
template <class R>
LANE_FN R largest_curvature(const Quadric<R>& q, const Vec3<R>& p) {
  const Shape<R> s = shape_at(q, p);
  const Vec3<R>& n = s.normal;
  const Vec3<R> hn = q.hessian_times(n);
  const R mean = R(0.5) * (q.xx + q.yy + q.zz - dot(n, hn)) * s.inverse_g;
  // n^T adj(H) n
  const R axx = fnma(q.yz, q.yz, q.yy * q.zz), ayy = fnma(q.xz, q.xz, q.xx * q.zz), azz = fnma(q.xy, q.xy, q.xx * q.yy);
  const R axy = fnma(q.xy, q.zz, q.xz * q.yz), axz = fnma(q.xz, q.yy, q.xy * q.yz), ayz = fnma(q.yz, q.xx, q.xy * q.xz);
  R gauss = fma(axx * n.x, n.x, fma(ayy * n.y, n.y, azz * n.z * n.z));
  gauss = fma(R(2.0), fma(axy * n.x, n.y, fma(axz * n.x, n.z, ayz * n.y * n.z)), gauss);
  gauss = gauss * s.inverse_g * s.inverse_g;
  return abs(mean) + sqrt(max(fnma(R(1.0), gauss, mean * mean), R(0.0)));
}

/// Principal directions and curvatures at a point.
template <class R>
struct Principal {
  Vec3<R> normal;
  Vec3<R> minor_axis;  ///< unit; direction of the smaller absolute curvature
  Vec3<R> major_axis;  ///< unit; the other one
  R minor, major;      ///< signed: positive where the surface bends away from the gradient, as a sphere's outside does
};
template <class R>
LANE_FN Principal<R> principal_at(const Quadric<R>& q, const Vec3<R>& p) {
  const Shape<R> s = shape_at(q, p);
  const Vec3<R>& n = s.normal;
  // A tangent basis without branches (Duff et al., "Building an orthonormal basis, revisited", 2017).
  const R sign = select(n.z < R(0.0), R(-1.0), R(1.0));
  const R u = R(-1.0) / (sign + n.z);
  const R v = n.x * n.y * u;
  const Vec3<R> t1 = {fma(sign * n.x, n.x * u, R(1.0)), sign * v, -sign * n.x};
  const Vec3<R> t2 = {v, fma(n.y, n.y * u, sign), -n.y};
  const Vec3<R> h1 = q.hessian_times(t1), h2 = q.hessian_times(t2);
  const R a = dot(t1, h1) * s.inverse_g, b = dot(t1, h2) * s.inverse_g, d = dot(t2, h2) * s.inverse_g;
  const R mean = R(0.5) * (a + d), half = R(0.5) * (a - d);
  const R h = sqrt(fma(half, half, b * b));
  const auto positive = mean >= R(0.0);
  Principal<R> out;
  out.normal = n;
  out.major = select(positive, mean + h, mean - h);
  out.minor = select(positive, mean - h, mean + h);
  // Eigenvector of the minor curvature: of the two rows of (S - minor I) the one without cancellation.
  const R rest = out.minor - mean;  // -h or +h
  const auto first = half * rest >= R(0.0);
  R e1 = select(first, rest + half, b);
  R e2 = select(first, b, rest - half);
  const R length2 = fma(e1, e1, e2 * e2);
  const auto isotropic = invert(length2 > R(1e-60));
  const R inverse = R(1.0) / sqrt(select(isotropic, R(1.0), length2));
  e1 = select(isotropic, R(1.0), e1 * inverse);
  e2 = select(isotropic, R(0.0), e2 * inverse);
  out.minor_axis = {fma(e1, t1.x, e2 * t2.x), fma(e1, t1.y, e2 * t2.y), fma(e1, t1.z, e2 * t2.z)};
  out.major_axis = cross(n, out.minor_axis);
  return out;
}

/// Orders two values.
template <class R>
LANE_FN void exchange(R& a, R& b) {
  const R low = min(a, b);
  b = max(a, b);
  a = low;
}

/// Median of nine by a network of nineteen exchanges.
template <class R>
LANE_FN R median9(R* v) {
  exchange(v[1], v[2]), exchange(v[4], v[5]), exchange(v[7], v[8]);
  exchange(v[0], v[1]), exchange(v[3], v[4]), exchange(v[6], v[7]);
  exchange(v[1], v[2]), exchange(v[4], v[5]), exchange(v[7], v[8]);
  exchange(v[0], v[3]), exchange(v[5], v[8]), exchange(v[4], v[7]);
  exchange(v[3], v[6]), exchange(v[1], v[4]), exchange(v[2], v[5]);
  exchange(v[4], v[7]), exchange(v[4], v[2]), exchange(v[6], v[4]);
  exchange(v[4], v[2]);
  return v[4];
}

/// The median of the largest curvature over nine points spread over the neighbourhood. The paper takes random points of
/// the surface; these are fixed: the sample's foot and steps of 1.2 standard deviations of the points from it along the
/// principal directions, each brought to the surface. (The points' mean is no place to start from: of a rod that is
/// seen all around it lies on the axis, where the gradient vanishes.)
template <class R>
LANE_FN R median_curvature(const Quadric<R>& q, const R* moments, const Vec3<R>& centre, const Principal<R>& p) {
  const R inverse_n = R(1.0) / moments[0];
  const Vec3<R> mean = {moments[1] * inverse_n, moments[2] * inverse_n, moments[3] * inverse_n};
  const R cxx = fnma(mean.x, mean.x, moments[4] * inverse_n), cxy = fnma(mean.x, mean.y, moments[5] * inverse_n);
  const R cxz = fnma(mean.x, mean.z, moments[6] * inverse_n), cyy = fnma(mean.y, mean.y, moments[7] * inverse_n);
  const R cyz = fnma(mean.y, mean.z, moments[8] * inverse_n), czz = fnma(mean.z, mean.z, moments[9] * inverse_n);
  const auto spread = [&](const Vec3<R>& a) LANE_INLINE {
    const Vec3<R> ca = {fma(cxx, a.x, fma(cxy, a.y, cxz * a.z)), fma(cxy, a.x, fma(cyy, a.y, cyz * a.z)),
                        fma(cxz, a.x, fma(cyz, a.y, czz * a.z))};
    return R(1.2) * sqrt(max(dot(a, ca), R(0.0)));
  };
  const R along = spread(p.minor_axis), across = spread(p.major_axis);
  R kappa[9];
  LANE_ROLLED
  for (int i = 0; i < 3; ++i) {
    LANE_ROLLED
    for (int j = 0; j < 3; ++j) {
      const Vec3<R> y =
          add_scaled(add_scaled(centre, R(i - 1.0) * along, p.minor_axis), R(j - 1.0) * across, p.major_axis);
      kappa[3 * i + j] = largest_curvature(q, q.foot(y));
    }
  }
  return median9(kappa);
}

}  // namespace handhold::HANDHOLD_LANE
