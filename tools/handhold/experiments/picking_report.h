// What the experiments with a grasping robot share: flags, attempts as CSV, failures in words and as pictures.
#pragma once

#include <string>
#include <vector>

#include "common.h"
#include "picking.h"

namespace handhold::experiments {

/// An attempt with where it belongs.
struct AttemptRecord {
  std::string scene;
  plan::ElectricGripper gripper;
  int number = 1;      ///< in its scene, from 1 on
  std::string object;  ///< family of what was tried; empty: nothing
  Attempt attempt;
};

/// Options of the localizer for a gripper.
Options localizer_options(const plan::ElectricGripper& gripper);

/// "slot 2, hard tips"
std::string gripper_text(const plan::ElectricGripper& gripper);
/// Which gripper was used for which objects, and why.
std::string gripper_reasons(const std::vector<std::pair<std::string, plan::ElectricGripper>>& used);

std::string attempts_csv(const std::vector<AttemptRecord>& records);
/// A sentence for every way in which attempts failed.
std::string failures_text(const std::vector<AttemptRecord>& records);

/// What the robot saw and meant to do, FOLDER/SCENE_attempt_N.png.
void write_failure(const std::string& folder, const AttemptRecord& record, const Look& look, const plan::Arm& arm);

}  // namespace handhold::experiments
