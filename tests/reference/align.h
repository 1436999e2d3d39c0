// Alignment of two affordances (paper, section 3.3).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "reference/neighbours.h"

namespace handhold::reference {

struct AxisCircle {
  Vector3d center;    ///< m
  Vector3d axis;      ///< unit; sign means nothing
  double radius = 0;  ///< m
};

struct AlignLimits {
  double max_sin = 0;     ///< d_o: sine of the angle between the axes
  double max_offset = 0;  ///< d_c: m; the larger of the two ways
  double max_radius = 0;  ///< d_r: m
};

/// The three distances of the paper between two affordances.
struct AlignDistances {
  double sin = 0;     ///< of the angle between the axes
  double offset = 0;  ///< m; across the axis, the larger of "j's centre from i's axis" and "i's centre from j's axis"
  double radius = 0;  ///< m
};

inline AlignDistances align_distances(const AxisCircle& i, const AxisCircle& j) {
  const Vector3d d = j.center - i.center;
  AlignDistances distances;
  distances.sin = i.axis.cross(j.axis).norm();
  distances.offset = std::max((d - i.axis * i.axis.dot(d)).norm(), (d - j.axis * j.axis.dot(d)).norm());
  distances.radius = std::abs(i.radius - j.radius);
  return distances;
}

inline bool aligned(const AxisCircle& i, const AxisCircle& j, const AlignLimits& limits) {
  const AlignDistances d = align_distances(i, j);
  return d.sin <= limits.max_sin && d.offset <= limits.max_offset && d.radius <= limits.max_radius;
}

}  // namespace handhold::reference
