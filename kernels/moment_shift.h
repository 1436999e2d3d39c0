// Moments after a change of coordinates, one problem per lane. All 35 moments up to degree 4, in place.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// Moments of (x + tx, y + ty, z + tz): Horner's scheme, an axis at a time.
template <class R>
LANE_FN void shift_moments(R* m, R tx, R ty, R tz) {
  using kernels::moment_index;
  LANE_UNROLL(5)
  for (int j = 0; j <= 4; ++j) {
    LANE_UNROLL(5)
    for (int k = 0; j + k <= 4; ++k) {
      const int n = 4 - j - k;
      LANE_UNROLL(4)
      for (int p = 1; p <= n; ++p) {
        LANE_UNROLL(4)
        for (int i = n; i >= p; --i)
          m[moment_index(i, j, k)] = fma(tx, m[moment_index(i - 1, j, k)], m[moment_index(i, j, k)]);
      }
    }
  }
  LANE_UNROLL(5)
  for (int j = 0; j <= 4; ++j) {
    LANE_UNROLL(5)
    for (int k = 0; j + k <= 4; ++k) {
      const int n = 4 - j - k;
      LANE_UNROLL(4)
      for (int p = 1; p <= n; ++p) {
        LANE_UNROLL(4)
        for (int i = n; i >= p; --i)
          m[moment_index(j, i, k)] = fma(ty, m[moment_index(j, i - 1, k)], m[moment_index(j, i, k)]);
      }
    }
  }
  LANE_UNROLL(5)
  for (int j = 0; j <= 4; ++j) {
    LANE_UNROLL(5)
    for (int k = 0; j + k <= 4; ++k) {
      const int n = 4 - j - k;
      LANE_UNROLL(4)
      for (int p = 1; p <= n; ++p) {
        LANE_UNROLL(4)
        for (int i = n; i >= p; --i)
          m[moment_index(j, k, i)] = fma(tz, m[moment_index(j, k, i - 1)], m[moment_index(j, k, i)]);
      }
    }
  }
}

/// Moments of (x, y, z + a x + b y) from those of (x, y, z): the shear is undone one unit of z at a time.
/// Raising the z-exponent from high degree to low keeps every value that is still needed.
template <class R>
LANE_FN void shear_moments(R* m, R a, R b) {
  using kernels::moment_index;
  // E[x^i y^j (z + s)^k] with s = a x + b y: k passes, each replacing one factor z by z + s. After pass p the entry
  // (i, j, k) with k >= p holds E[x^i y^j z^(k-p) (z+s)^p]; a factor s moves a degree from z to x or y.
  // Work on columns of equal degree: v[k] for all (i, j) with i + j = degree - k.
  LANE_UNROLL(4)
  for (int degree = 1; degree <= 4; ++degree) {
    LANE_UNROLL(4)
    for (int pass = 1; pass <= degree; ++pass) {
      // Entries with the most factors z first: they read entries with one factor less that this pass has not touched
      // yet.
      LANE_UNROLL(5)
      for (int k = degree; k >= pass; --k) {
        LANE_UNROLL(5)
        for (int i = degree - k; i >= 0; --i) {
          const int j = degree - k - i;
          R t = m[moment_index(i, j, k)];
          t = fma(a, m[moment_index(i + 1, j, k - 1)], t);
          t = fma(b, m[moment_index(i, j + 1, k - 1)], t);
          m[moment_index(i, j, k)] = t;
        }
      }
    }
  }
}

}  // namespace handhold::HANDHOLD_LANE
