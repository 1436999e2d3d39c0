// How a thing comes to rest on a table.
#pragma once

#include "handhold/sensor.h"

namespace handhold::sensor {

/// Where a solid comes to rest when it is put down with orientation `start` (its position does not matter) and tips
/// over, without momentum or slipping, until its centre of mass stands above what touches the table.
struct Rest {
  Pose T_world_object;           ///< lowest points at z = 0, centre of mass above the origin
  std::vector<Point2> contacts;  ///< counter-clockwise corners of the area of support (m, world)
};

/// @throws std::invalid_argument for a mesh without volume
Rest settle(const Mesh& mesh, const Pose& start);

/// Centroid of the volume that a closed mesh encloses (m). @throws std::invalid_argument for a mesh without volume
Vector3 center_of_mass(const Mesh& mesh);

}  // namespace handhold::sensor
