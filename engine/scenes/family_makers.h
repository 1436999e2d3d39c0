// Where the families are made: one list for each kind of thing, joined in families.cpp.
#pragma once

#include <utility>
#include <vector>

#include "shape.h"

namespace handhold::sensor {

struct FamilyMaker {
  Family family;
  /// All sizes are given and in range.
  Shape (*make)(const Sizes&);
};

std::vector<FamilyMaker> bottle_families();
std::vector<FamilyMaker> kitchen_families();
std::vector<FamilyMaker> tool_families();
std::vector<FamilyMaker> cleaning_families();
std::vector<FamilyMaker> carried_families();
std::vector<FamilyMaker> bow_families();
std::vector<FamilyMaker> plain_families();

/// Shorthand for makers.
inline double at(const Sizes& sizes, const char* name) {
  return sizes.at(name);
}

inline constexpr double kRightAngle = 1.5707963267948966;

}  // namespace handhold::sensor
