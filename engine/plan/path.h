// Straight ways in joint space.
#pragma once

#include <vector>

#include "handhold/arm.h"

namespace handhold::plan {

/// Samples between two postures, both included; between two of them no joint moves more than `step`.
std::vector<JointVector> straight_path(const JointVector& from, const JointVector& to, double step);
/// Goes on from the end of `path`, which is not empty.
void extend_straight(std::vector<JointVector>& path, const JointVector& to, double step);

/// Times (s) along a path that is at rest at both ends. Its length is the time at full speed: of each piece, that of
/// the joint that takes longest. The speed grows evenly for `acceleration_time`, and falls as long at the end.
std::vector<double> path_times(const std::vector<JointVector>& path, const std::vector<Joint>& joints, double speed,
                               double acceleration_time);

}  // namespace handhold::plan
