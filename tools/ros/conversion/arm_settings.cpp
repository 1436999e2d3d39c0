#include "arm_settings.h"

#include <cctype>
#include <stdexcept>
#include <utility>

namespace handhold::ros_bridge {

std::string about_parameters(std::string message) {
  for (std::size_t at = message.find("--"); at != std::string::npos; at = message.find("--", at)) {
    message.erase(at, 2);
    for (; at < message.size() && (std::islower(static_cast<unsigned char>(message[at])) || message[at] == '-'); ++at) {
      if (message[at] == '-') message[at] = '_';
    }
  }
  return message;
}

ArmSettings arm_settings(const Texts& arm) {
  using planning::ArmArguments;
  constexpr std::pair<const char*, std::string ArmArguments::*> kMembers[] = {
      {"arm", &ArmArguments::arm},     {"arm_file", &ArmArguments::arm_file}, {"fingers", &ArmArguments::fingers},
      {"slot", &ArmArguments::slot},   {"tip", &ArmArguments::tip},           {"start", &ArmArguments::start},
      {"table", &ArmArguments::table}, {"order", &ArmArguments::order},       {"grasps", &ArmArguments::grasps}};
  ArmArguments arguments;
  for (const auto& [name, member] : kMembers) {
    const auto given = arm.find(name);
    if (given != arm.end()) arguments.*member = given->second;
  }
  try {
    planning::ChosenArm chosen = planning::chosen_arm(arguments);
    plan::PlannerOptions options = planning::planner_options(arguments, chosen.arm);
    plan::GraspPlanner planner(chosen.arm, options);  // looks at all of it
    planning::add_known(arguments, planner.obstacles());
    return {std::move(chosen), std::move(options), std::move(arguments)};
  } catch (const std::exception& error) {
    throw std::invalid_argument(about_parameters(error.what()));
  }
}

}  // namespace handhold::ros_bridge
