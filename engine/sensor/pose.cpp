#include <stdexcept>

#include "handhold/sensor.h"
#include "vec.h"

namespace handhold::sensor {

Vector3 Pose::direction(const Vector3& d) const {
  return {R[0] * d[0] + R[1] * d[1] + R[2] * d[2], R[3] * d[0] + R[4] * d[1] + R[5] * d[2],
          R[6] * d[0] + R[7] * d[1] + R[8] * d[2]};
}

Vector3 Pose::point(const Vector3& p) const {
  return direction(p) + t;
}

Pose Pose::inverse() const {
  Pose result;
  result.R = {R[0], R[3], R[6], R[1], R[4], R[7], R[2], R[5], R[8]};
  result.t = -1.0 * result.direction(t);
  return result;
}

Pose Pose::operator*(const Pose& other) const {
  Pose result;
  for (int column = 0; column < 3; ++column) {
    const Vector3 c = direction({other.R[column], other.R[3 + column], other.R[6 + column]});
    for (int row = 0; row < 3; ++row) result.R[3 * row + column] = c[row];
  }
  result.t = point(other.t);
  return result;
}

Pose translation(double x, double y, double z) {
  Pose result;
  result.t = {x, y, z};
  return result;
}

Pose rotation(const Vector3& axis, double angle) {
  if (!(norm(axis) > 0)) throw std::invalid_argument("rotation: the axis is zero or not finite; give a direction");
  const Vector3 a = unit(axis);
  const double c = std::cos(angle), s = std::sin(angle), k = 1 - c;
  Pose result;
  result.R = {c + a[0] * a[0] * k,        a[0] * a[1] * k - a[2] * s, a[0] * a[2] * k + a[1] * s,
              a[1] * a[0] * k + a[2] * s, c + a[1] * a[1] * k,        a[1] * a[2] * k - a[0] * s,
              a[2] * a[0] * k - a[1] * s, a[2] * a[1] * k + a[0] * s, c + a[2] * a[2] * k};
  return result;
}

Pose look_at(const Vector3& eye, const Vector3& target, const Vector3& up) {
  const Vector3 forward = target - eye;
  const Vector3 right = cross(forward, up);
  if (!(norm(right) > 1e-9 * norm(forward) * norm(up))) {
    throw std::invalid_argument("look_at: the view direction is zero or parallel to up; move the eye or turn up");
  }
  const Vector3 z = unit(forward), x = unit(right), y = cross(z, x);
  Pose result;
  result.R = {x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]};
  result.t = eye;
  return result;
}

}  // namespace handhold::sensor
