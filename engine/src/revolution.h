// The axis of a surface of revolution: a bottle, or a can with its cap.
#pragma once

#include <cstddef>
#include <vector>

#include "cylinder.h"
#include "part_points.h"

namespace handhold {

/// Slices with fewer points say nothing about the axis.
inline constexpr double kLeastOfSlice = 5;

struct RevolutionSums {
  double w = 0, d = 0;                        ///< points; sum of their distances from the axis (m)
  double a[4] = {}, aa[10] = {}, ad[4] = {};  ///< of the derivatives, their products, and those with the distance
};

/// Moves the axis of `c` by one Gauss-Newton step on the distances of the marked points, which points.select(c, ...)
/// has located, from the mean distance in their slice, with Huber weights beyond 2 `sigma` (m): every slice has its own
/// radius, so that steps between pieces do not tilt the axis. `n` slices of `width` from `low` along the axis (m).
/// The radius stays. False, and nothing changes: there are fewer than three slices with enough points.
bool step_axis_of_revolution(const PartPoints& points, double low, double width, std::size_t n, double sigma,
                             std::vector<RevolutionSums>& scratch, Cylinder& c);

}  // namespace handhold
