// Small vector arithmetic on Vector3.
#pragma once

#include <cmath>

#include "handhold/cloud.h"

namespace handhold {

inline Vector3 operator+(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vector3 operator-(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vector3 operator*(double s, const Vector3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
inline double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double norm(const Vector3& a) {
  return std::sqrt(dot(a, a));
}
inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Unit vector, or `otherwise` where there is no direction.
inline Vector3 normalized(const Vector3& a, const Vector3& otherwise = {0, 0, 1}) {
  const double n = norm(a);
  return n > 0 ? (1 / n) * a : otherwise;
}
/// The sign that makes an axis unique: its largest component is positive (the first of equal ones).
inline Vector3 canonical_axis(const Vector3& a) {
  int largest = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::fabs(a[k]) > std::fabs(a[largest])) largest = k;
  }
  return a[largest] < 0 ? -1.0 * a : a;
}
/// A unit vector perpendicular to the unit vector `a`.
inline Vector3 any_perpendicular(const Vector3& a) {
  const Vector3 e = std::fabs(a[0]) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
  return normalized(e - dot(e, a) * a);
}

}  // namespace handhold
