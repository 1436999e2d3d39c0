// Convex bodies as boxes with rounded edges, and what is checked about them.
#pragma once

#include <string>

#include "handhold/collision.h"

namespace handhold::plan {

/// All points within `radius` of a box: of no size in a sphere, of no width and height in a capsule.
struct Core {
  Pose T_base_core;
  Vector3 half = {0, 0, 0};  ///< m; half of the edges' lengths
  double radius = 0;         ///< m
  bool edged = false;        ///< a box; otherwise its core is a segment on z or a point
};
Core core_of(const Body& body);

/// Distance (m) of a point from a body's surface; negative inside.
double distance(const Core& core, const Vector3& point);
/// Distance (m) between two bodies; 0 when they touch or overlap.
double distance(const Core& a, const Core& b);
/// Radius (m) of the ball about a body's origin that just holds it.
double reach(const Core& core);

/// Sizes, places and poses beyond this (m) are refused: single precision knows no millimetres there.
inline constexpr double kFarthest = 1e6;

/// @param what  names the pose in the message
/// @throws std::invalid_argument for a pose that is none or farther than kFarthest
void check(const Pose& pose, const char* what);
/// The same for a body. `name` may be empty.
void check(const Body& body, const char* what, const std::string& name = {});

}  // namespace handhold::plan
