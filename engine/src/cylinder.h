// A cylinder fitted to points by their geometric distance.
#pragma once

#include <cstddef>

#include "vec3.h"

namespace handhold {

struct Cylinder {
  Vector3 point{};  ///< of the axis
  Vector3 axis{};   ///< unit
  double radius = 0;

  /// Vector from the axis to p, across it.
  Vector3 across(const Vector3& p) const {
    const Vector3 d = p - point;
    return d - dot(d, axis) * axis;
  }
};

/// Coordinates of points (m) as separate arrays, near the origin for the sake of single precision; 15 more floats may
/// be read behind each.
struct PointArrays {
  const float *x, *y, *z;
  std::size_t n;
  Vector3 operator[](std::size_t i) const {
    return {static_cast<double>(x[i]), static_cast<double>(y[i]), static_cast<double>(z[i])};
  }
};

/// Improves a cylinder by at most `steps` Levenberg-Marquardt steps on the distances of the points from its surface,
/// with Huber weights beyond 2 `sigma` (metres). `point` comes to stand beside the points' mean. Returns the root mean
/// square distance of the points.
double refine_cylinder(const PointArrays& points, double sigma, int steps, Cylinder& cylinder);

/// Tilts of a cylinder in a fit are its displacement at this distance along the axis (m), so that all unknowns are
/// lengths.
inline constexpr double kTiltArm = 0.02;

/// The angle (rad) of a turn, kernels::TurnQuery.
double turn_angle(float turn);

/// Angle (rad) about the axis within which the points lie as seen from it, without the outermost 3 % on either side;
/// measured about the direction `towards`.
double arc_of(const PointArrays& points, const Cylinder& cylinder, const Vector3& towards);

}  // namespace handhold
