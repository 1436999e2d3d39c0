#include "picking_report.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "picture.h"
#include "plan_output.h"
#include "text.h"

namespace handhold::experiments {

using evaluation::format;

Options localizer_options(const plan::ElectricGripper& gripper) {
  Options options = Options::baxter();
  options.hand_aperture = gripper.opening_open();
  options.hand_minimum = std::max(0.0, gripper.opening_closed());
  options.threads = 1;  // scenes run side by side
  return options;
}

std::string gripper_text(const plan::ElectricGripper& gripper) {
  return format("slot %d, %s tips", gripper.slot,
                gripper.tip == plan::ElectricGripper::Tip::kHard ? "hard" : "half round");
}

std::string gripper_reasons(const std::vector<std::pair<std::string, plan::ElectricGripper>>& used) {
  std::map<std::string, std::set<std::string>> by_gripper;
  std::map<std::string, plan::ElectricGripper> grippers;
  for (const auto& [object, gripper] : used) {
    by_gripper[gripper_text(gripper)].insert(object);
    grippers[gripper_text(gripper)] = gripper;
  }
  std::string text =
      "Gripper (standard narrow fingers; the stroke is 41.7 mm in every slot, so no slot holds everything):\n";
  for (const auto& [name, objects] : by_gripper) {
    const plan::ElectricGripper& gripper = grippers[name];
    text += format("  %s, opening %.1f to %.1f mm, for ", name.c_str(), 1000 * std::max(0.0, gripper.opening_closed()),
                   1000 * gripper.opening_open());
    const char* separator = "";
    for (const std::string& object : objects) text += separator + object, separator = ", ";
    text += "\n";
  }
  return text;
}

std::string attempts_csv(const std::vector<AttemptRecord>& records) {
  std::string text = "scene,attempt,object,slot,tip,ending,why,pushed_m,simulated_s\n";
  for (const AttemptRecord& record : records) {
    std::string why = record.attempt.why;
    std::replace(why.begin(), why.end(), ',', ';');
    text += format("%s,%d,%s,%d,%s,%s,%s,%.4f,%.2f\n", record.scene.c_str(), record.number, record.object.c_str(),
                   record.gripper.slot, record.gripper.tip == plan::ElectricGripper::Tip::kHard ? "hard" : "half_round",
                   to_string(record.attempt.ending), why.c_str(), record.attempt.pushed, record.attempt.seconds);
  }
  return text;
}

std::string failures_text(const std::vector<AttemptRecord>& records) {
  static constexpr const char* kMeaning[kEndings] = {
      "",
      "no handle was found in the cloud",
      "no handle had a grasp that the arm could carry out",
      "the fingers closed beside the part",
      "it was between the fingers, and got lost on the way to the box",
      "it was lifted, but the arm found no way to the box and put it down again",
      "it was carried, but does not lie in the box",
      "the simulation broke down"};
  std::string text;
  for (int ending = 1; ending < kEndings; ++ending) {
    std::map<std::string, int> objects;
    int count = 0;
    for (const AttemptRecord& record : records) {
      if (record.attempt.ending != static_cast<Ending>(ending)) continue;
      ++objects[record.object.empty() ? record.scene : record.object];
      ++count;
    }
    if (count == 0) continue;
    text += format("  %s, %d: %s (", to_string(static_cast<Ending>(ending)), count, kMeaning[ending]);
    const char* separator = "";
    for (const auto& [object, times] : objects) {
      text += separator + object + (times > 1 ? format(" %d times", times) : std::string());
      separator = ", ";
    }
    text += ")\n";
  }
  return text.empty() ? "No attempt failed.\n" : "Attempts that failed:\n" + text;
}

void write_failure(const std::string& folder, const AttemptRecord& record, const Look& look, const plan::Arm& arm) {
  PictureOptions options;
  options.affordances = false;
  options.lines = planning::plan_lines(arm, look.plan, look.T_base_camera);
  const std::string name = record.scene + "_attempt_" + std::to_string(record.number) + ".png";
  write_picture((std::filesystem::path(folder) / name).string(), look.cloud.view(), look.cloud.rgb, look.result,
                options);
}

}  // namespace handhold::experiments
