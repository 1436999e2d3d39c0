// Where the hand may take hold of a handle: places along it, directions from which it comes, and its poses there.
#pragma once

#include <vector>

#include "handhold/planner.h"

namespace handhold::plan {

/// A point of a handle's axis, base frame.
struct HandlePlace {
  Vector3 point = {0, 0, 0};  ///< m
  Vector3 axis = {0, 0, 1};   ///< unit
  double shift = 0;           ///< m; along the handle from its centre
};

/// A handle in the base frame, with unit directions. @throws std::invalid_argument when it cannot be one
Handle in_base(const Handle& handle, const Pose& T_base_camera, std::size_t index);

/// In the order of the shares (of half of the length); those that are closer than 5 mm to an earlier one are left out.
std::vector<HandlePlace> places_along(const Handle& handle, const std::vector<double>& shares);

/// A direction in which a hand moves towards a place.
struct Approach {
  Vector3 direction = {0, 0, 1};  ///< unit
  double angle = 0;               ///< rad, -pi .. pi; about the axis, from the paper's
  double tilt = 0;                ///< rad; from across the axis towards it
};
/// The paper's first: along the line from the arm's mount to the place, as far as that is across the axis (section
/// 4.1). Then `seen`, the direction that the localizer gives, then steps of `angle_step` from the paper's, both ways.
/// None is farther than `max_angle` from `seen`. All are across the axis.
std::vector<Approach> approaches_to(const HandlePlace& place, const Vector3& mount, const Vector3& seen,
                                    double angle_step, double max_angle);

Approach tilted(const Approach& approach, const Vector3& axis, double tilt);

/// T_base_tip: z along the approach, y across it and the axis, the origin `depth` beyond the axis. @param flipped  x
/// and y point the other way
Pose hand_pose(const HandlePlace& place, const Vector3& approach, double depth, bool flipped);

}  // namespace handhold::plan
