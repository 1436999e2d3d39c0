// Putting things down on a table without overlap.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "handhold/scene_file.h"

namespace handhold::sensor {

/// A thing at rest, ready to be put somewhere.
struct Resting {
  SceneObject object;             ///< its pose: lowest points at z = 0, centre of mass above the origin
  std::vector<Point2> footprint;  ///< hull of its shadow from above, counter-clockwise (m)
  std::vector<Point2> contacts;   ///< area of support (m)
  std::vector<Point2> top;        ///< flat upper side that carries other things; empty when it has none
  double height = 0;              ///< m
};

/// Whether a family's objects have a closed flat top, so that other things can stand on it.
bool is_block(const std::string& family);

/// Lets an object of a family come to rest from an orientation.
Resting at_rest(const std::string& name, const std::string& family, const Sizes& sizes, const Pose& start);

/// The same moved on the table: turned by `yaw` about its origin, then to (x, y, z).
Resting moved(const Resting& thing, double x, double y, double z, double yaw);

/// Whether convex polygons (counter-clockwise) are at least `gap` apart along the normal of an edge of one of them.
bool apart(const std::vector<Point2>& a, const std::vector<Point2>& b, double gap);
/// Whether a point lies within a convex polygon, at least `margin` from its edges.
bool within(const std::vector<Point2>& polygon, const Point2& p, double margin);

}  // namespace handhold::sensor
