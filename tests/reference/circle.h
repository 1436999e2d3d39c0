// Circle across an axis (paper, section 3.2, eq. 3): the algebraic fit of u^2 + v^2 + a u + b v + c = 0 to the points'
// traces in the plane across the axis. With coordinates about their mean it falls apart into a 2x2 system and a mean.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
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
Circle fit_circle(const Points& points, const Vector3d& axis);

}  // namespace handhold::reference
