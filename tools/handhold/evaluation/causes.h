// A sentence for every miss and every false handle: why, as far as the result tells.
#pragma once

#include <string>
#include <vector>

#include "handhold/result.h"
#include "matching.h"

namespace handhold::evaluation {

/// Why part `index` has no handle: one that was left out or is askew, or the affordances near it.
std::string why_missed(std::size_t index, const std::vector<LabelledPart>& parts, const Result& result,
                       const SceneScore& score);

/// Why handle `index` is on no part, or on one that has a handle; which object it lies on, and whether a hand would
/// hold something there.
std::string why_false(std::size_t index, const std::vector<LabelledPart>& parts, const Result& result,
                      const SceneScore& score);

}  // namespace handhold::evaluation
