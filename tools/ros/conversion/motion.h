// Rigid motions: between what transforms say (quaternion and translation) and the library's R p + t.
#pragma once

#include <array>
#include <cmath>

#include "handhold/cloud.h"
#include "handhold/result.h"
#include "handhold/tracker.h"

namespace handhold::ros_bridge {

/// qx, qy, qz, qw of a rotation.
using Quaternion = std::array<double, 4>;

/// T_a_b from a unit quaternion (to rounding) and a translation (m).
inline Motion motion(const Quaternion& q, const Vector3& t) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
           2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),  //
           2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)},
          t};
}

inline Vector3 rotated(const std::array<double, 9>& R, const Vector3& v) {
  return {R[0] * v[0] + R[1] * v[1] + R[2] * v[2], R[3] * v[0] + R[4] * v[1] + R[5] * v[2],
          R[6] * v[0] + R[7] * v[1] + R[8] * v[2]};
}
inline Vector3 moved(const Motion& T, const Vector3& p) {
  const Vector3 v = rotated(T.R, p);
  return {v[0] + T.t[0], v[1] + T.t[1], v[2] + T.t[2]};
}
inline Motion inverse(const Motion& T) {
  const std::array<double, 9>& R = T.R;
  Motion out = {{R[0], R[3], R[6], R[1], R[4], R[7], R[2], R[5], R[8]}, {}};
  const Vector3 t = rotated(out.R, T.t);
  out.t = {-t[0], -t[1], -t[2]};
  return out;
}
/// T_a_c of T_a_b and T_b_c.
inline Motion operator*(const Motion& a, const Motion& b) {
  Motion out;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      out.R[3 * i + j] = a.R[3 * i] * b.R[j] + a.R[3 * i + 1] * b.R[3 + j] + a.R[3 * i + 2] * b.R[6 + j];
    }
  }
  out.t = moved(a, b.t);
  return out;
}

/// The rotation whose z axis is `z` (unit) and whose x axis is as near to `x` as can be; any x when that is along z.
Quaternion quaternion_of(const Vector3& z, const Vector3& x);
/// Of a rotation matrix, by rows.
Quaternion quaternion_of(const std::array<double, 9>& R);

/// Brings everything that a result says into another frame.
void move(Result& result, const Motion& T_target_source);

}  // namespace handhold::ros_bridge
