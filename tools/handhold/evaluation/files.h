// Results and truth from their JSON files.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "handhold/result.h"
#include "matching.h"

namespace handhold::evaluation {

/// Scenes of a truth file, sorted by name: one JSON object, scene -> list of parts. A part has what, center, axis,
/// radius and length (m, in the frame of the scene's cloud). confidence, centre_line (without it the part is straight),
/// visible, measured, graspable, raised and family may be missing.
/// @throws std::runtime_error, one line, when the file cannot be read or is no truth
std::map<std::string, std::vector<LabelledPart>> read_truth(const std::string& path);

/// Handles and affordances of a result file (handhold localize --json). Of an affordance, center, axis and radius are
/// read. @throws std::runtime_error, one line, when the file cannot be read or is no result
Result read_result(const std::string& path);

}  // namespace handhold::evaluation
