// MuJoCo's model of a world, as MJCF text.
#pragma once

#include <string>
#include <vector>

#include "handhold/physics.h"

namespace handhold::physics {

/// Bodies have the names of the robot's links, "table", "bin", "floor" and thing_name(index); joints and their motors
/// those of the robot's joints. Frames of links and things are those of the URDF and of sensor::make_object.
std::string world_mjcf(const WorldOptions& options, const plan::Arm& arm, const std::vector<Thing>& things);

std::string thing_name(std::size_t thing);

/// The finger joints of one hand: the one that is moved, and the one that mimics it in the opposite direction.
struct FingerJoints {
  std::string moved, mimic;
};
FingerJoints finger_joints(plan::Side side);

/// How far beyond the closed position the fingers' motors are set to press with full force (m).
double full_force_travel(const WorldOptions& options);

// ---- Pieces of text -------------------------------------------------------------------------------------------------

struct RobotText {
  std::string bodies, equalities, motors;
};
RobotText robot_text(const WorldOptions& options, const plan::Arm& arm);

/// With all digits.
std::string text_of(double value);
std::string text_of(const Vector3& v);
/// Attributes `pos` and `xyaxes`, with a blank before each.
std::string place_text(const Pose& pose);

}  // namespace handhold::physics
