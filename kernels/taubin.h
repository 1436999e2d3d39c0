// Taubin's fit of an implicit quadric (paper, section 3.1, eq. 1 and 2), one problem per lane.
//
// With l = (x^2, y^2, z^2, xy, yz, xz, x, y, z, 1) the paper solves (M - lambda N) c = 0, 10x10. The fit does not
// depend on where the origin is (gradients do not change when points are shifted), so the moments are first shifted to
// the mean of the points. There N splits: the rows of x, y, z are the identity and do not meet those of the squares,
// and the row of 1 is zero, which eliminates the constant. What is left is a 9x9 problem whose Cholesky factor is that
// of a 6x6:
//
//   A = diag(L, I)^-1 (M' - m m^T) diag(L, I)^-T,  N_squares = L L^T
//
// A is brought to tridiagonal form by Householder reflections. The smallest eigenvalue comes from Laguerre's iteration
// started left of the spectrum: it converges monotonically to the *smallest* root, where inverse iteration or Rayleigh
// quotients may land on the second one (the ratio of the two is often below 1.1 on real data). Inverse iteration with a
// shift just below it then gives the vector.
#pragma once

#include "kernels.h"
#include "lane.h"
#include "moment_shift.h"

namespace handhold::HANDHOLD_LANE {

/// Pivot of N below which the points count as lying on a plane, a line or in one place: there N is exactly singular. A
/// plane with noise of standard deviation s (in units of the radius) has a pivot of about 4 s^2, so 1e-9 is 0.4 um at a
/// radius of 25 mm: far below any sensor, above the rounding of float coordinates at a few metres.
inline constexpr double kFlatPivot = 1e-9;

constexpr int packed(int i, int j) {
  return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
}

/// Exponent of x, y or z (axis 0, 1, 2) in the first nine entries of l. A function, not a table: then a compiler for a
/// GPU knows every index of what is indexed with it.
constexpr int exponent(int i, int axis) {
  return i < 3 ? 2 * (i == axis) : i < 6 ? axis != (i == 3 ? 2 : i == 4 ? 0 : 1) : i - 6 == axis;
}
/// Index of the moment of the product of two of these entries, or of one of them.
constexpr int product_index(int i, int j) {
  return kernels::moment_index(exponent(i, 0) + exponent(j, 0), exponent(i, 1) + exponent(j, 1),
                               exponent(i, 2) + exponent(j, 2));
}
constexpr int entry_index(int i) {
  return kernels::moment_index(exponent(i, 0), exponent(i, 1), exponent(i, 2));
}

template <class R>
struct Eigenproblem {
  R a[45];         ///< symmetric 9x9, packed lower triangle; after `tridiagonalize` the Householder vectors
  R l[21];         ///< Cholesky factor of the 6x6 part of N, off-diagonals
  R l_inverse[6];  ///< inverses of its diagonal
  R d[9], e[8];    ///< tridiagonal form
  R beta[7];       ///< 2 / |v|^2 of the reflections
};

/// Reads the central moments (mean of the monomials), builds and reduces the problem. Returns the mask of flat lanes.
template <class R>
LANE_FN auto reduce_to_standard(const R* mu, Eigenproblem<R>& p) {
  using kernels::moment_index;
  // M' - m m^T; the mean of x, y, z is zero here.
  LANE_UNROLL(9)
  for (int i = 0; i < 9; ++i) {
    LANE_UNROLL(9)
    for (int j = 0; j <= i; ++j) {
      R m = mu[product_index(i, j)];
      if (i < 6) m = fnma(mu[entry_index(i)], mu[entry_index(j)], m);
      p.a[packed(i, j)] = m;
    }
  }
  // N of the squares: the mean of grad l . grad l^T, from second moments only.
  const R xx = mu[4], xy = mu[5], xz = mu[6], yy = mu[7], yz = mu[8], zz = mu[9];
  R* l = p.l;
  const R zero = R(0.0), two = R(2.0), four = R(4.0);
  l[packed(0, 0)] = four * xx;
  l[packed(1, 0)] = zero, l[packed(1, 1)] = four * yy;
  l[packed(2, 0)] = zero, l[packed(2, 1)] = zero, l[packed(2, 2)] = four * zz;
  l[packed(3, 0)] = two * xy, l[packed(3, 1)] = two * xy, l[packed(3, 2)] = zero, l[packed(3, 3)] = xx + yy;
  l[packed(4, 0)] = zero, l[packed(4, 1)] = two * yz, l[packed(4, 2)] = two * yz, l[packed(4, 3)] = xz;
  l[packed(4, 4)] = yy + zz;
  l[packed(5, 0)] = two * xz, l[packed(5, 1)] = zero, l[packed(5, 2)] = two * xz, l[packed(5, 3)] = yz;
  l[packed(5, 4)] = xy, l[packed(5, 5)] = xx + zz;
  // Cholesky.
  auto flat = R(0.0) > R(1.0);
  LANE_UNROLL(6)
  for (int j = 0; j < 6; ++j) {
    R pivot = l[packed(j, j)];
    const auto bad = invert(pivot >= R(kFlatPivot));
    flat = flat | bad;
    pivot = select(bad, R(1.0), pivot);
    const R inverse = R(1.0) / sqrt(pivot);
    p.l_inverse[j] = inverse;
    LANE_UNROLL(6)
    for (int i = j + 1; i < 6; ++i) l[packed(i, j)] = l[packed(i, j)] * inverse;
    LANE_UNROLL(6)
    for (int i = j + 1; i < 6; ++i) {
      LANE_UNROLL(6)
      for (int k = j + 1; k <= i; ++k) {
        l[packed(i, k)] = fnma(l[packed(i, j)], l[packed(k, j)], l[packed(i, k)]);
      }
    }
  }
  // A <- inv(L) A inv(L)^T for the leading 6x6, inv(L) A from one side for the three rows below.
  R* a = p.a;
  LANE_UNROLL(6)
  for (int k = 0; k < 6; ++k) {
    const R s = p.l_inverse[k];
    const R akk = a[packed(k, k)] * s * s;
    a[packed(k, k)] = akk;
    const R half = akk * R(-0.5);
    LANE_UNROLL(6)
    for (int i = k + 1; i < 6; ++i) a[packed(i, k)] = fma(half, l[packed(i, k)], a[packed(i, k)] * s);
    LANE_UNROLL(9)
    for (int i = 6; i < 9; ++i) a[packed(i, k)] = a[packed(i, k)] * s;
    LANE_UNROLL(6)
    for (int i = k + 1; i < 6; ++i) {
      LANE_UNROLL(6)
      for (int j = k + 1; j <= i; ++j) {
        a[packed(i, j)] = fnma(a[packed(i, k)], l[packed(j, k)], a[packed(i, j)]);
        a[packed(i, j)] = fnma(l[packed(i, k)], a[packed(j, k)], a[packed(i, j)]);
      }
    }
    LANE_UNROLL(9)
    for (int i = 6; i < 9; ++i) {
      LANE_UNROLL(6)
      for (int j = k + 1; j < 6; ++j) a[packed(i, j)] = fnma(a[packed(i, k)], l[packed(j, k)], a[packed(i, j)]);
    }
    LANE_UNROLL(6)
    for (int i = k + 1; i < 6; ++i) a[packed(i, k)] = fma(half, l[packed(i, k)], a[packed(i, k)]);
    LANE_UNROLL(6)
    for (int i = k + 1; i < 6; ++i) {
      R x = a[packed(i, k)];
      LANE_UNROLL(6)
      for (int j = k + 1; j < i; ++j) x = fnma(l[packed(i, j)], a[packed(j, k)], x);
      a[packed(i, k)] = x * p.l_inverse[i];
    }
  }
  return flat;
}

/// Householder reduction of the symmetric 9x9 to tridiagonal form.
template <class R>
LANE_FN void tridiagonalize(Eigenproblem<R>& p) {
  R* a = p.a;
  LANE_UNROLL(7)
  for (int k = 0; k < 7; ++k) {
    p.d[k] = a[packed(k, k)];
    R s = a[packed(k + 1, k)] * a[packed(k + 1, k)];
    LANE_UNROLL(9)
    for (int i = k + 2; i < 9; ++i) s = fma(a[packed(i, k)], a[packed(i, k)], s);
    const R norm = sqrt(s);
    const R x0 = a[packed(k + 1, k)];
    const R alpha = select(x0 > R(0.0), -norm, norm);
    p.e[k] = alpha;
    const R v0 = x0 - alpha;
    a[packed(k + 1, k)] = v0;
    // |v|^2 / 2 = s - x0 alpha >= s; a column of zeros needs no reflection.
    const R half = fnma(x0, alpha, s);
    const auto none = invert(half > R(1e-40));
    const R beta = select(none, R(0.0), R(1.0) / select(none, R(1.0), half));
    p.beta[k] = beta;
    R w[9];
    LANE_UNROLL(9)
    for (int i = k + 1; i < 9; ++i) {
      R t = a[packed(i, k + 1)] * a[packed(k + 1, k)];
      LANE_UNROLL(9)
      for (int j = k + 2; j < 9; ++j) t = fma(a[packed(i, j)], a[packed(j, k)], t);
      w[i] = t * beta;
    }
    R kappa = w[k + 1] * a[packed(k + 1, k)];
    LANE_UNROLL(9)
    for (int i = k + 2; i < 9; ++i) kappa = fma(w[i], a[packed(i, k)], kappa);
    kappa = kappa * beta * R(0.5);
    LANE_UNROLL(9)
    for (int i = k + 1; i < 9; ++i) w[i] = fnma(kappa, a[packed(i, k)], w[i]);
    LANE_UNROLL(9)
    for (int i = k + 1; i < 9; ++i) {
      LANE_UNROLL(9)
      for (int j = k + 1; j <= i; ++j) {
        a[packed(i, j)] = fnma(a[packed(i, k)], w[j], a[packed(i, j)]);
        a[packed(i, j)] = fnma(w[i], a[packed(j, k)], a[packed(i, j)]);
      }
    }
  }
  p.d[7] = a[packed(7, 7)];
  p.d[8] = a[packed(8, 8)];
  p.e[7] = a[packed(8, 7)];
}

/// Smallest eigenvalue of the tridiagonal form by Laguerre's iteration from the left. The matrix must be scaled to
/// trace 16: then the nine factors of the characteristic polynomial neither overflow nor vanish.
template <class R>
LANE_FN R smallest_eigenvalue(const R* d, const R* e) {
  R e2[8];
  LANE_UNROLL(8)
  for (int i = 0; i < 8; ++i) e2[i] = e[i] * e[i];
  R sigma = R(-1e-14);
  auto active = R(0.0) < R(1.0);
  for (int iteration = 0; iteration < 16; ++iteration) {
    // Value, first and second derivative of the characteristic polynomial by the three-term recurrence.
    R p0 = R(1.0), p1 = d[0] - sigma;
    R q0 = R(0.0), q1 = R(-1.0);
    R r0 = R(0.0), r1 = R(0.0);
    LANE_UNROLL(8)
    for (int i = 1; i < 9; ++i) {
      const R t = d[i] - sigma;
      const R p2 = fnma(e2[i - 1], p0, t * p1);
      const R q2 = fnma(e2[i - 1], q0, fma(t, q1, -p1));
      const R r2 = fnma(e2[i - 1], r0, fma(t, r1, R(-2.0) * q1));
      p0 = p1, p1 = p2;
      q0 = q1, q1 = q2;
      r0 = r1, r1 = r2;
    }
    // step = 9 p / (-p' + sqrt(8 (8 p'^2 - 9 p p''))); left of all roots p > 0 and p' < 0.
    R discriminant = R(8.0) * fma(R(8.0) * q1, q1, R(-9.0) * p1 * r1);
    discriminant = max(discriminant, R(0.0));
    const R denominator = sqrt(discriminant) - q1;
    // A lane whose polynomial is no longer positive sits on the root to rounding.
    const auto usable = active & (p1 > R(0.0)) & (denominator > R(0.0));
    R step = R(9.0) * p1 / select(usable, denominator, R(1.0));
    // Stay left of the root in spite of rounding.
    step = select(usable, step * R(1.0 - 1e-10), R(0.0));
    sigma = sigma + step;
    active = usable & (step > R(1e-9) * (sigma + R(1e-12)));
    if (!any(active)) break;
  }
  return sigma;
}

/// Eigenvector of the tridiagonal form to the eigenvalue `lambda` by inverse iteration; not normalised.
template <class R>
LANE_FN void tridiagonal_vector(const R* d, const R* e, R lambda, R* x) {
  // Just below the eigenvalue the matrix is positive definite, and LDL^T needs no pivoting. Where rounding puts the
  // shift a hair above, a pivot turns negative: that is as good, as long as none is zero.
  const R shift = lambda - lambda * R(1e-9) - R(1e-14);
  const R tiny = R(1e-17);
  R l[8], inverse[9];
  R pivot = d[0] - shift;
  inverse[0] = R(1.0) / select(abs(pivot) > tiny, pivot, tiny);
  LANE_UNROLL(8)
  for (int i = 0; i < 8; ++i) {
    l[i] = e[i] * inverse[i];
    pivot = fnma(l[i], e[i], d[i + 1] - shift);
    inverse[i + 1] = R(1.0) / select(abs(pivot) > tiny, pivot, tiny);
  }
  // Any start vector that is orthogonal to no likely eigenvector will do.
  constexpr double kStart[9] = {0.31, -0.53, 0.47, 0.42, -0.37, 0.61, 0.83, -0.71, 1.0};
  LANE_UNROLL(9)
  for (int i = 0; i < 9; ++i) x[i] = R(kStart[i]);
  LANE_ROLLED
  for (int round = 0; round < 3; ++round) {
    LANE_UNROLL(8)
    for (int i = 0; i < 8; ++i) x[i + 1] = fnma(l[i], x[i], x[i + 1]);
    LANE_UNROLL(9)
    for (int i = 0; i < 9; ++i) x[i] = x[i] * inverse[i];
    LANE_UNROLL(8)
    for (int i = 7; i >= 0; --i) x[i] = fnma(l[i], x[i + 1], x[i]);
    R norm2 = x[0] * x[0];
    LANE_UNROLL(9)
    for (int i = 1; i < 9; ++i) norm2 = fma(x[i], x[i], norm2);
    const R scale = R(1.0) / sqrt(norm2);
    LANE_UNROLL(9)
    for (int i = 0; i < 9; ++i) x[i] = x[i] * scale;
  }
}

/// Undoes the reflections and the Cholesky factor: x becomes the generalized eigenvector with c^T N c = 1.
template <class R>
LANE_FN void back_transform(const Eigenproblem<R>& p, R* x) {
  LANE_UNROLL(7)
  for (int k = 6; k >= 0; --k) {
    R t = p.a[packed(k + 1, k)] * x[k + 1];
    LANE_UNROLL(9)
    for (int i = k + 2; i < 9; ++i) t = fma(p.a[packed(i, k)], x[i], t);
    t = t * p.beta[k];
    LANE_UNROLL(9)
    for (int i = k + 1; i < 9; ++i) x[i] = fnma(t, p.a[packed(i, k)], x[i]);
  }
  LANE_UNROLL(6)
  for (int i = 5; i >= 0; --i) {
    LANE_UNROLL(6)
    for (int k = i + 1; k < 6; ++k) x[i] = fnma(p.l[packed(k, i)], x[k], x[i]);
    x[i] = x[i] * p.l_inverse[i];
  }
}

/// The fit. moments: sums of monomials about the sample; c: ten coefficients about the sample, c^T N c = 1.
/// Returns the mask of flat lanes, whose coefficients and lambda are zero.
template <class R>
LANE_FN auto taubin_fit(const R* moments, R* c, R& lambda) {
  using kernels::moment_index;
  R mu[35];
  const R inverse_n = R(1.0) / max(moments[0], R(1.0));  // no points at all are flat, not NaN
  LANE_UNROLL(35)
  for (int i = 1; i < 35; ++i) mu[i] = moments[i] * inverse_n;
  const R mx = mu[1], my = mu[2], mz = mu[3];
  mu[0] = R(1.0);
  shift_moments(mu, -mx, -my, -mz);

  Eigenproblem<R> p;
  const auto flat = reduce_to_standard(mu, p);
  tridiagonalize(p);
  R trace = p.d[0];
  LANE_UNROLL(9)
  for (int i = 1; i < 9; ++i) trace = trace + p.d[i];
  const auto no_trace = invert(trace > R(0.0));
  trace = select(no_trace, R(1.0), trace);
  const R scale = R(16.0) / trace;
  LANE_UNROLL(9)
  for (int i = 0; i < 9; ++i) p.d[i] = p.d[i] * scale;
  LANE_UNROLL(8)
  for (int i = 0; i < 8; ++i) p.e[i] = p.e[i] * scale;
  const R smallest = smallest_eigenvalue(p.d, p.e);
  R x[9];
  tridiagonal_vector(p.d, p.e, smallest, x);
  back_transform(p, x);

  // Constant, and back from the mean to the sample: f(y) with y = x - m.
  const auto bad = flat | no_trace;
  const R zero = R(0.0);
  LANE_UNROLL(9)
  for (int i = 0; i < 9; ++i) x[i] = select(bad, zero, x[i]);
  R constant = zero;
  LANE_UNROLL(6)
  for (int i = 0; i < 6; ++i) {
    constant = fnma(x[i], mu[entry_index(i)], constant);
  }
  // grad of the quadratic part at -m, and its value there.
  const R gx = fma(R(2.0) * x[0], mx, fma(x[3], my, x[5] * mz));
  const R gy = fma(R(2.0) * x[1], my, fma(x[3], mx, x[4] * mz));
  const R gz = fma(R(2.0) * x[2], mz, fma(x[4], my, x[5] * mx));
  const R quadratic = R(0.5) * fma(gx, mx, fma(gy, my, gz * mz));
  const R linear = fma(x[6], mx, fma(x[7], my, x[8] * mz));
  LANE_UNROLL(6)
  for (int i = 0; i < 6; ++i) c[i] = x[i];
  c[6] = x[6] - gx;
  c[7] = x[7] - gy;
  c[8] = x[8] - gz;
  c[9] = constant + quadratic - linear;
  lambda = select(bad, zero, max(smallest, zero) * trace * R(1.0 / 16.0));
  return bad;
}

}  // namespace handhold::HANDHOLD_LANE
