// Curved thin parts among the affordances.
#pragma once

#include <vector>

#include "bow.h"
#include "budget.h"
#include "depth_image.h"
#include "handhold/result.h"
#include "part_check.h"

namespace handhold {

/// Appends a group about the middle of each part that bends all along, traced from the best affordances on; `bows`
/// holds what the groups point to. When the budget is spent the rest is left out.
void find_bows(const std::vector<Affordance>& affordances, const DepthImage& image, std::vector<PartGroup>& groups,
               std::vector<Bow>& bows, const Budget& budget = {});

/// Whether a straight piece is of a curved handle: near its path and along it, and about as thick.
bool of_bow(const Handle& bow, const Handle& piece);

}  // namespace handhold
