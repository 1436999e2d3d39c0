// What `handhold evaluate` prints and writes.
#pragma once

#include <string>
#include <vector>

#include "handhold/result.h"
#include "matching.h"
#include "summary.h"

namespace handhold::evaluation {

/// One scene with all that is known about it.
struct Scene {
  std::string name;
  std::vector<LabelledPart> parts;
  Result result;
  SceneScore score;
};

/// The figures as tables for a person.
std::string summary_text(const Summary& summary);

/// A line for every miss, duplicate and false handle, with its cause; empty when there is none.
std::string cases_text(const std::vector<Scene>& scenes);

/// Comma-separated, one header: a line per scene, per handle and per needed part, told apart by the first column.
std::string csv(const std::vector<Scene>& scenes);

}  // namespace handhold::evaluation
