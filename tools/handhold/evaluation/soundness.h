// Every handle and affordance of a result against the complete geometry of its scene.
#pragma once

#include "handhold/grasp_check.h"
#include "tables.h"

namespace handhold::evaluation {

/// Fills in HandleCase::sound and unsound, SceneScore::affordances and sound_affordances of scene.score. Works in the
/// caller's TBB arena. Handles that were left out are not checked.
/// @throws std::invalid_argument for a mesh or a hand that cannot be
void check_soundness(Scene& scene, const sensor::Scene& geometry, const sensor::Pose& T_world_camera,
                     const sensor::Hand& hand);

}  // namespace handhold::evaluation
