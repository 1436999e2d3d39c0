// Convex hull of points in space.
#pragma once

#include <vector>

#include "handhold/sensor.h"

namespace handhold::sensor {

/// Closed mesh of the convex hull. Points are moved by up to 0.1 micrometre first (always by the same amounts), so that
/// no four lie in a plane exactly and the hull of a box's corners is as well defined as any other.
/// @throws std::invalid_argument when all points lie in one plane
Mesh convex_hull(const std::vector<Vector3>& points);

/// Convex hull in the plane, counter-clockwise, without points on its edges; fewer than 3 points when all lie on a
/// line. Corners within a micrometre of each other are one.
std::vector<Point2> convex_hull(std::vector<Point2> points);

}  // namespace handhold::sensor
