#include "motion.h"

#include <algorithm>

namespace handhold::ros_bridge {
namespace {

double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// An axis has no sign: its largest component is positive.
void fix_sign(Vector3& axis) {
  const auto largest =
      std::max_element(axis.begin(), axis.end(), [](double a, double b) { return std::fabs(a) < std::fabs(b); });
  if (*largest < 0) axis = {-axis[0], -axis[1], -axis[2]};
}

/// The part of v across z, of length one; false when there is none.
bool across(const Vector3& z, const Vector3& v, Vector3& x) {
  const double along = dot(z, v);
  x = {v[0] - along * z[0], v[1] - along * z[1], v[2] - along * z[2]};
  const double length = std::sqrt(dot(x, x));
  if (!(length > 1e-6)) return false;
  x = {x[0] / length, x[1] / length, x[2] / length};
  return true;
}

}  // namespace

Quaternion quaternion_of(const Vector3& z, const Vector3& wanted) {
  Vector3 x;
  if (!across(z, wanted, x) && !across(z, {1, 0, 0}, x)) across(z, {0, 1, 0}, x);
  const Vector3 y = cross(z, x);
  return quaternion_of({x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]});
}

Quaternion quaternion_of(const std::array<double, 9>& R) {
  // The largest of the four is found from the diagonal, the others by their products with it.
  const double trace = R[0] + R[4] + R[8];
  Quaternion q;
  if (trace >= std::max({R[0], R[4], R[8]})) {
    q = {R[7] - R[5], R[2] - R[6], R[3] - R[1], 1 + trace};
  } else if (R[0] >= R[4] && R[0] >= R[8]) {
    q = {1 + R[0] - R[4] - R[8], R[1] + R[3], R[2] + R[6], R[7] - R[5]};
  } else if (R[4] >= R[8]) {
    q = {R[1] + R[3], 1 - R[0] + R[4] - R[8], R[5] + R[7], R[2] - R[6]};
  } else {
    q = {R[2] + R[6], R[5] + R[7], 1 - R[0] - R[4] + R[8], R[3] - R[1]};
  }
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& component : q) component /= length;
  return q;
}

void move(Result& result, const Motion& T) {
  for (Handle& handle : result.handles) {
    handle.center = moved(T, handle.center);
    handle.axis = rotated(T.R, handle.axis);
    fix_sign(handle.axis);
    handle.approach = rotated(T.R, handle.approach);
    for (Vector3& point : handle.path) point = moved(T, point);
  }
  for (Affordance& affordance : result.affordances) {
    affordance.center = moved(T, affordance.center);
    affordance.axis = rotated(T.R, affordance.axis);
    fix_sign(affordance.axis);
    affordance.normal = rotated(T.R, affordance.normal);
  }
}

}  // namespace handhold::ros_bridge
