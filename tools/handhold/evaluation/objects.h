// Which object of a scene every handle lies on.
#pragma once

#include <string>
#include <vector>

#include "handhold/sensor.h"
#include "tables.h"

namespace handhold::evaluation {

/// Fills in scene.score.objects and HandleCase::object: the object whose surface is nearest, in the mean, to the side
/// of the handle's cylinder that faces the camera. Handles that were left out have none.
/// @param geometry  complete geometry, in the world's frame
/// @param families  one for each object of the geometry
/// @throws std::invalid_argument when there is not one family for each object
void find_objects(Scene& scene, const sensor::Scene& geometry, const std::vector<std::string>& families,
                  const sensor::Pose& T_world_camera);

}  // namespace handhold::evaluation
