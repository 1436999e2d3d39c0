#include "arm_arguments.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "command_line.h"
#include "usage_error.h"

namespace handhold::planning {
namespace {

constexpr double kUnbounded = 1e6;  // m, rad: whatever fits is for the planner to say

template <class T, std::size_t N>
T by_name(const char* flag, const std::string& text, const std::pair<const char*, T> (&names)[N]) {
  std::string known;
  for (const auto& [name, value] : names) {
    if (text == name) return value;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  throw UsageError(std::string(flag) + ": unknown name '" + text + "'; known are: " + known);
}

std::vector<double> exactly(const char* flag, const std::string& text, std::size_t count, const char* what) {
  std::vector<double> values = numbers(flag, text, -kUnbounded, kUnbounded, "");
  if (values.size() == count) return values;
  throw UsageError(std::string(flag) + " = '" + text + "': must be " + what);
}

plan::ElectricGripper gripper_of(const ArmArguments& a) {
  using Gripper = plan::ElectricGripper;
  using Finger = Gripper::Finger;
  using Tip = Gripper::Tip;
  Gripper gripper;
  if (!a.fingers.empty()) {
    gripper.finger = by_name<Finger>("--fingers", a.fingers,
                                     {{"standard-narrow", Finger::kStandardNarrow},
                                      {"standard-wide", Finger::kStandardWide},
                                      {"extended-narrow", Finger::kExtendedNarrow},
                                      {"extended-wide", Finger::kExtendedWide}});
  }
  if (!a.slot.empty()) gripper.slot = static_cast<int>(whole_number("--slot", a.slot, 1, 4));
  if (!a.tip.empty()) {
    gripper.tip = by_name<Tip>(
        "--tip", a.tip,
        {{"hard", Tip::kHard}, {"soft", Tip::kSoft}, {"paddle", Tip::kPaddle}, {"half-round", Tip::kHalfRound}});
  }
  return gripper;
}

/// What the localizer has to know of a hand: its stroke, and how far its fingers reach.
Options options_of(const plan::Hand& hand, double finger_depth) {
  Options options = Options::baxter();
  options.hand_aperture = hand.opening_max;
  options.hand_minimum = hand.opening_min;
  options.finger_depth = finger_depth;
  return options;
}

}  // namespace

void add_arm_flags(CLI::App& app, ArmArguments& a) {
  const auto text = [&app](const char* flag, std::string& target, const char* value, const char* help,
                           const char* group) { add_text_flag(app, flag, target, value, help, group); };
  const char* arm = "Arm";
  text("--arm", a.arm, "right|left", "Baxter's arm [right]", arm);
  text("--fingers", a.fingers, "NAME",
       "Of Baxter's electric gripper: standard-narrow, standard-wide, extended-narrow, extended-wide "
       "[standard-narrow]",
       arm);
  text("--slot", a.slot, "1..4", "Where its fingers are screwed on, from the middle outwards [3]", arm);
  text("--tip", a.tip, "NAME", "Of its fingers: hard, soft, paddle, half-round [hard]", arm);
  text("--arm-file", a.arm_file, "F.toml", "Another arm: urdf, base, tip and hand, see the README", arm);
  text("--start", a.start, "Q...",
       "Where the arm stands: a position for each joint, base first (rad; m for one that slides) [its rest]", arm);
  text("--camera-pose", a.camera_pose, "X Y Z QX QY QZ QW",
       "T_base_camera: where the camera stands (m) and how it is turned (quaternion), optical frame; needed", arm);
  text("--table", a.table, "XMIN XMAX YMIN YMAX Z",
       "A table that is known: its top, in the base frame (m); nothing goes below it there", arm);
  const char* grasps = "Grasps";
  text("--order", a.order, "NAME",
       "Which handle comes first: nearest (to the arm's mount), confidence or highest [nearest]", grasps);
  text("--grasps", a.grasps, "N", "End after so many, one a handle; 0: one for every handle that has one [0]", grasps);
  app.add_flag("--all", a.all, "Look at every way to hold every handle, and list them all in --json")
      ->disable_flag_override()
      ->group(grasps);
}

ChosenArm chosen_arm(const ArmArguments& a) {
  if (!a.arm_file.empty()) {
    for (const auto& [flag, value] : {std::pair("--arm", a.arm), std::pair("--fingers", a.fingers),
                                      std::pair("--slot", a.slot), std::pair("--tip", a.tip)}) {
      if (!value.empty()) throw UsageError(std::string(flag) + " is for Baxter; it does not go with --arm-file");
    }
    plan::Arm arm = plan::read_arm(a.arm_file);
    const Options options = options_of(arm.hand(), Options().finger_depth);
    return {a.arm_file, std::move(arm), options};
  }
  const std::string name = a.arm.empty() ? "right" : a.arm;
  const auto side = by_name<plan::Side>("--arm", name, {{"right", plan::Side::kRight}, {"left", plan::Side::kLeft}});
  const plan::ElectricGripper gripper = gripper_of(a);
  plan::Arm arm = plan::Arm::baxter(side, gripper);
  // Of the standard fingers, Options::baxter() has it; longer ones reach as much farther.
  const double finger_depth =
      Options::baxter().finger_depth + gripper.finger_length() - plan::ElectricGripper().finger_length();
  const Options options = options_of(arm.hand(), finger_depth);
  return {name, std::move(arm), options};
}

plan::Pose camera_pose(const ArmArguments& a) {
  if (a.camera_pose.empty()) {
    throw UsageError(
        "--camera-pose is missing: where the camera stands in the robot's base frame, X Y Z (m) QX QY QZ QW");
  }
  const std::vector<double> v = exactly("--camera-pose", a.camera_pose, 7, "seven numbers: X Y Z (m) QX QY QZ QW");
  const double length = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
  if (!(std::fabs(length - 1) < 0.01)) {
    throw UsageError("--camera-pose = '" + a.camera_pose + "': QX QY QZ QW must be a unit quaternion");
  }
  const double x = v[3] / length, y = v[4] / length, z = v[5] / length, w = v[6] / length;
  plan::Pose pose;
  pose.R = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
            2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
            2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  pose.t = {v[0], v[1], v[2]};
  return pose;
}

plan::PlannerOptions planner_options(const ArmArguments& a, const plan::Arm& arm) {
  plan::PlannerOptions options;
  options.max_grasps = a.grasps.empty() ? 0 : whole_number("--grasps", a.grasps, 0, 1'000'000);
  options.all = a.all;
  if (!a.order.empty()) {
    options.order = by_name<plan::Order>("--order", a.order,
                                         {{"nearest", plan::Order::kNearest},
                                          {"confidence", plan::Order::kConfidence},
                                          {"highest", plan::Order::kHighest}});
  }
  if (!a.start.empty()) {
    const std::string what = std::to_string(arm.joints().size()) + " numbers, one for each joint (rad)";
    options.start = exactly("--start", a.start, arm.joints().size(), what.c_str());
    for (std::size_t i = 0; i < options.start.size(); ++i) {
      const plan::Joint& joint = arm.joints()[i];
      if (options.start[i] >= joint.lower && options.start[i] <= joint.upper) continue;
      throw UsageError("--start: joint '" + joint.name + "' must be from " + std::to_string(joint.lower) + " to " +
                       std::to_string(joint.upper) + " rad");
    }
  }
  return options;
}

void add_known(const ArmArguments& a, plan::Obstacles& obstacles) {
  if (a.table.empty()) return;
  const std::vector<double> v = exactly("--table", a.table, 5, "five numbers: XMIN XMAX YMIN YMAX Z (m)");
  if (!(v[0] < v[1] && v[2] < v[3])) {
    throw UsageError("--table = '" + a.table + "': XMIN must be below XMAX, and YMIN below YMAX");
  }
  constexpr double kHeight = 0.5;  // m; nobody reaches below
  plan::Body table;
  table.kind = plan::Shape::Kind::kBox;
  table.size = {v[1] - v[0], v[3] - v[2], kHeight};
  table.T_base_body.t = {(v[0] + v[1]) / 2, (v[2] + v[3]) / 2, v[4] - kHeight / 2};
  obstacles.add("table", table);
}

}  // namespace handhold::planning
