// Curved handles - of a mug, a jug, a pot - come out as straight pieces: end to end, one thick, each turned a little
// from the last. Here they become one.
#pragma once

#include <vector>

#include "handhold/result.h"

namespace handhold {

/// Joins handles (best confidence first) whose ends meet at an angle. What is joined has a `path`: the middle of it is
/// the handle's center, its tangent there the axis. Order and all others stay.
void join_curved(std::vector<Handle>& handles);

}  // namespace handhold
