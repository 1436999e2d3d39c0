// The arm, its hand and where it stands, as a command line gives them.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "handhold/options.h"
#include "handhold/planner.h"

namespace handhold::planning {

/// What the user gave; empty: not given.
struct ArmArguments {
  std::string arm, arm_file, fingers, slot, tip;
  std::string camera_pose, table, start;
  std::string order, grasps;
  bool all = false;
};

void add_arm_flags(CLI::App& app, ArmArguments& a);

/// An arm with its name for the result, and the localizer's options that its hand asks for.
struct ChosenArm {
  std::string name;  ///< "right", "left", or the file
  plan::Arm arm;
  Options options;
};
/// @throws UsageError, or std::invalid_argument with one line about a file
ChosenArm chosen_arm(const ArmArguments& a);

/// T_base_camera. @throws UsageError
plan::Pose camera_pose(const ArmArguments& a);

/// @throws UsageError
plan::PlannerOptions planner_options(const ArmArguments& a, const plan::Arm& arm);

/// Adds what the arguments say is known. @throws UsageError
void add_known(const ArmArguments& a, plan::Obstacles& obstacles);

}  // namespace handhold::planning
