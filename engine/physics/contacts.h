// Fewer contacts of the same effect.
#pragma once

#include <mujoco/mujoco.h>

namespace handhold::physics {

/// Where two bodies touch in many points of one plane, only those that bound the area stay, and the deepest: the forces
/// of the others could be replaced by theirs. A thing cut into convex pieces touches a table with each of them.
void keep_bounding_contacts(const mjModel& model, mjData& data);

}  // namespace handhold::physics
