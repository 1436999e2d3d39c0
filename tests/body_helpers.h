// Random bodies, and their distances by means of other mathematics than the engine's.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "handhold/collision.h"
#include "test_clouds.h"

namespace handhold::plan {

using Kind = Shape::Kind;
using Eigen::Vector3d;
using test::Random;

inline Pose pose_of(const Eigen::Matrix3d& R, const Vector3d& t) {
  return {{R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)}, {t[0], t[1], t[2]}};
}
inline Pose random_pose(Random& random, double spread) {
  return pose_of(random.rotation(), random.normal3(spread));
}
inline Eigen::Matrix3d rotation_of(const Body& body) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.T_base_body.R.data());
}
inline Vector3d centre_of(const Body& body) {
  return Vector3d(body.T_base_body.t[0], body.T_base_body.t[1], body.T_base_body.t[2]);
}
inline Vector3 plain(const Vector3d& v) {
  return {v[0], v[1], v[2]};
}

inline Body sphere_at(const Pose& T, double radius) {
  return {Kind::kSphere, radius, 0, {}, T};
}
inline Body capsule_at(const Pose& T, double radius, double length) {
  return {Kind::kCapsule, radius, length, {}, T};
}
inline Body box_at(const Pose& T, const Vector3& size) {
  return {Kind::kBox, 0, 0, size, T};
}

/// About `size` (m) large, about `spread` (m) from the origin. Now and then an edge has no length.
inline Body random_body(Random& random, double size, double spread) {
  const Pose T = random_pose(random, spread);
  const auto length = [&] { return random.index(12) == 0 ? 0 : random.uniform(0.02, 1) * size; };
  switch (random.index(3)) {
    case 0:
      return sphere_at(T, length());
    case 1:
      return capsule_at(T, 0.3 * length(), length());
    default:
      return box_at(T, {length(), length(), length()});
  }
}

/// The point of a body that is nearest to `p`, which is itself inside.
inline Vector3d projected(const Body& body, const Vector3d& p) {
  const Eigen::Matrix3d R = rotation_of(body);
  const Vector3d q = R.transpose() * (p - centre_of(body));
  Vector3d core = Vector3d::Zero();
  if (body.kind == Kind::kBox) {
    for (int k = 0; k < 3; ++k) core[k] = std::max(-body.size[k] / 2, std::min(body.size[k] / 2, q[k]));
    return R * core + centre_of(body);
  }
  if (body.kind == Kind::kCapsule) core[2] = std::max(-body.length / 2, std::min(body.length / 2, q[2]));
  const double off = (q - core).norm();
  return R * (off <= body.radius ? q : Vector3d(core + body.radius / off * (q - core))) + centre_of(body);
}

/// Distance of two bodies between bounds, by projecting to and fro (von Neumann's alternating projections): the way
/// between the last two points from above, the gap along it from below.
struct Bounds {
  double low = 0, high = 0;
};
/// How far a body reaches in a direction (unit): its support function.
inline double support(const Body& body, const Vector3d& direction) {
  const Vector3d d = rotation_of(body).transpose() * direction;
  const double along = direction.dot(centre_of(body));
  switch (body.kind) {
    case Kind::kSphere:
      return along + body.radius;
    case Kind::kCapsule:
      return along + body.radius + std::abs(d[2]) * body.length / 2;
    case Kind::kBox:
      break;
  }
  return along + (std::abs(d[0]) * body.size[0] + std::abs(d[1]) * body.size[1] + std::abs(d[2]) * body.size[2]) / 2;
}
inline Bounds bounds_of_distance(const Body& a, const Body& b, int most = 20000) {
  Vector3d p = projected(a, centre_of(b)), q = projected(b, p);
  Bounds bounds{0, (p - q).norm()};
  for (int i = 0; i < most; ++i) {
    p = projected(a, q), q = projected(b, p);
    bounds.high = std::min(bounds.high, (p - q).norm());
    if (bounds.high < 1e-9) return {0, bounds.high};
    const Vector3d n = (q - p).normalized();
    bounds.low = std::max(bounds.low, -support(b, -n) - support(a, n));
    if (bounds.high - bounds.low < 1e-10) break;
  }
  return bounds;
}

/// Signed distance of a point, from its projection where it is outside, otherwise from the nearest way out.
inline double plain_distance(const Body& body, const Vector3d& p) {
  const double outside = (projected(body, p) - p).norm();
  if (outside > 1e-12) return outside;
  const Vector3d q = rotation_of(body).transpose() * (p - centre_of(body));
  if (body.kind == Kind::kBox) {
    double way = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) way = std::min({way, body.size[k] / 2 - q[k], body.size[k] / 2 + q[k]});
    return -way;
  }
  const double half = body.kind == Kind::kCapsule ? body.length / 2 : 0;
  return (q - Vector3d(0, 0, std::max(-half, std::min(half, q[2])))).norm() - body.radius;
}

}  // namespace handhold::plan
