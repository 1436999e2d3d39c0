// Which random scenes a user means.
#pragma once

#include <string>

#include "handhold/random_scene.h"

namespace handhold {

/// Families for random scenes: "all" (or nothing), "tuning" or "report", or a list of families ("mug,hammer,ball") of
/// which the graspable ones are targets and all are clutter.
/// @param negatives  scenes with nothing to hold: the plain families are the targets
/// @throws UsageError naming --families
sensor::RandomSceneOptions families_named(const std::string& text, bool negatives = false);

}  // namespace handhold
