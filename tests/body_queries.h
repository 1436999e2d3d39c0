// Random bodies as the kernels are asked about them, and their distances from points in plain double precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels.h"
#include "test_clouds.h"

namespace handhold::test {

/// A point, a segment, a plate or a box up to 0.4 m long; without a limit.
inline kernels::BodyQuery random_query(Random& random, const Vector3d& about, double spread) {
  kernels::BodyQuery q{};
  const Vector3d c = about + random.normal3(spread);
  const Matrix3d R = random.rotation();
  const int edges = static_cast<int>(random.index(4));
  for (int i = 0; i < 3; ++i) {
    q.centre[i] = static_cast<float>(c[i]);
    q.half[i] = i < edges ? static_cast<float>(random.uniform(0, 0.2)) : 0.0f;
    for (int k = 0; k < 3; ++k) q.R_body_cloud[3 * i + k] = static_cast<float>(R(k, i));
  }
  q.limit = kernels::kMostDistance;
  return q;
}

inline double plain_distance(const kernels::BodyQuery& q, const Vector3f& p) {
  double excess[3], sum = 0;
  for (int i = 0; i < 3; ++i) {
    double along = 0;
    for (int k = 0; k < 3; ++k) {
      along += static_cast<double>(q.R_body_cloud[3 * i + k]) *
               (static_cast<double>(p[k]) - static_cast<double>(q.centre[k]));
    }
    excess[i] = std::fabs(along) - static_cast<double>(q.half[i]);
    sum += excess[i] > 0 ? excess[i] * excess[i] : 0;
  }
  return sum > 0 ? std::sqrt(sum) : std::max({excess[0], excess[1], excess[2]});
}

/// Whether a point is one: the kernels leave out what is not finite or beyond 1e6 m.
inline bool counts(const Vector3f& p) {
  return std::fabs(p[0]) <= 1e6f && std::fabs(p[1]) <= 1e6f && std::fabs(p[2]) <= 1e6f;
}

/// Infinity: there is no point.
inline double plain_nearest(const kernels::BodyQuery& q, const FloatPoints& points) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3f& p : points) {
    if (counts(p)) least = std::min(least, plain_distance(q, p));
  }
  return least;
}

/// Of the distances that single precision computes, for bodies within some metres.
inline double rounding(double distance) {
  return 4e-7 * (std::fabs(distance) + 1);
}

}  // namespace handhold::test
