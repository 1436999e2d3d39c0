// Arms and planning from parameters. Part of the node only where handhold::plan is built.
#pragma once

#include "arm_arguments.h"
#include "settings.h"

namespace handhold::ros_bridge {

/// An arm that is ready to plan.
struct ArmSettings {
  planning::ChosenArm chosen;
  plan::PlannerOptions planner;
  planning::ArmArguments arguments;  ///< for planning::add_known()
};

/// The arm of the parameters `arm`, `arm_file`, `fingers`, `slot`, `tip`, `start`, `table`, `order` and `grasps`; they
/// have the texts and meanings of `handhold plan`'s flags.
/// @throws std::exception naming the parameter, its text and what would be right
ArmSettings arm_settings(const Texts& arm);

/// A message about flags, about parameters: "--arm-file is for ..." -> "arm_file is for ...".
std::string about_parameters(std::string message);

}  // namespace handhold::ros_bridge
