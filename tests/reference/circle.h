// Circle across an axis (paper, section 3.2, eq. 3): the algebraic fit of u^2 + v^2 + a u + b v + c = 0 to the points'
// traces in the plane across the axis. With coordinates about their mean it falls apart into a 2x2 system and a mean.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "reference/neighbours.h"

namespace handhold::reference {

struct Circle {
  Vector3d centre = Vector3d::Zero();                       ///< in the plane through the origin across the axis
  double radius = std::numeric_limits<double>::infinity();  ///< infinite: the points lie on a line across the axis
};

/// Below this share of its squared trace, the determinant of the 2x2 scatter counts as zero.
inline constexpr double kSingularScatter = 1e-12;

/// Fits a circle to points in any unit, relative to the sample; `axis` is unit.
inline Circle fit_circle(const Points& points, const Vector3d& axis) {
  Circle circle;
  if (points.empty()) return circle;
  const Vector3d u = axis.unitOrthogonal();
  const Vector3d v = axis.cross(u);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Vector3d& p : points) mean += Eigen::Vector2d(u.dot(p), v.dot(p)) / static_cast<double>(points.size());

  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  Eigen::Vector2d skew = Eigen::Vector2d::Zero();  // sum of q |q|^2
  double mean_square = 0;
  for (const Vector3d& p : points) {
    const Eigen::Vector2d q = Eigen::Vector2d(u.dot(p), v.dot(p)) - mean;
    scatter += q * q.transpose();
    skew += q * q.squaredNorm();
    mean_square += q.squaredNorm() / static_cast<double>(points.size());
  }
  if (!(scatter.determinant() > kSingularScatter * scatter.trace() * scatter.trace())) return circle;
  const Eigen::Vector2d offset = scatter.inverse() * skew / 2;  // of the centre from the mean
  const Eigen::Vector2d centre = mean + offset;
  circle.centre = centre.x() * u + centre.y() * v;
  circle.radius = std::sqrt(offset.squaredNorm() + mean_square);
  return circle;
}

}  // namespace handhold::reference
