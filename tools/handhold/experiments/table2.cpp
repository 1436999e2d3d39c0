// Five objects on a table, grasped one after the other until it is clear (Table 2 of the paper).
#include <algorithm>
#include <memory>
#include <optional>

#include "experiments.h"
#include "handhold/random_scene.h"
#include "picking_report.h"
#include "text.h"

namespace handhold::experiments {
namespace {

using evaluation::format;

/// Objects grasped of five, and attempts to grasp, in the ten runs of the paper. Its table gives nine figures of
/// attempts without saying which run lacks one: the heads of the columns lack the first.
constexpr int kPaperGrasped[] = {5, 4, 5, 4, 5, 4, 5, 5, 4, 5};
constexpr int kPaperAttempts[] = {0, 5, 5, 7, 7, 6, 5, 5, 5, 8};
constexpr int kRuns = 10;
/// The paper's runs took up to eight.
constexpr int kMostAttempts = 10;
/// Looks in a row that lead to no attempt, before the robot gives up.
constexpr int kMostLooks = 3;

struct Run {
  sensor::SceneFile scene;
  std::uint64_t seed = 0;
  plan::ElectricGripper gripper;
  std::vector<std::string> families;
  std::vector<AttemptRecord> records;
  int of = 0, grasped = 0, attempts = 0;
};

void carry_out(Run& run, const std::string& pictures) {
  const Workplace place = workplace(run.gripper);
  Picker picker(place, things_of(run.scene, place.T_base_scene), localizer_options(run.gripper));
  picker.settle();
  run.of = static_cast<int>(picker.world().things().size());
  int looks = 0;
  for (int i = 1; !picker.left().empty() && run.attempts < kMostAttempts && looks < kMostLooks; ++i) {
    AttemptRecord record{run.scene.name, run.gripper, i, "", picker.attempt(run.seed + static_cast<std::uint64_t>(i))};
    const bool tried = record.attempt.thing.has_value();
    if (tried) record.object = picker.world().things()[*record.attempt.thing].family;
    run.attempts += tried;
    looks = tried ? 0 : looks + 1;
    if (record.attempt.ending != Ending::kGrasped && !pictures.empty()) {
      write_failure(pictures, record, picker.look(), picker.world().arm());
    }
    run.records.push_back(std::move(record));
  }
  for (std::size_t i = 0; i < picker.world().things().size(); ++i) run.grasped += picker.world().in_bin(i);
}

std::string row(const char* name, const std::vector<std::string>& cells) {
  std::string text = format("%-18s", name);
  for (const std::string& cell : cells) text += format(" %5s", cell.c_str());
  return text + "\n";
}

Report report_of(const std::vector<Run>& runs) {
  std::vector<std::string> number, grasped, attempts, paper_grasped, paper_attempts;
  std::vector<AttemptRecord> records;
  std::vector<std::pair<std::string, plan::ElectricGripper>> grippers;
  int sum_of = 0, sum_grasped = 0, sum_attempts = 0;
  Report report;
  report.json = {{"experiment", "table2"}, {"of", 0}, {"grasped", 0}, {"attempts", 0}, {"runs", Json::array()}};
  PlotPanel panel;
  panel.title = "Clear the table";
  panel.y_label = "objects, attempts";
  panel.series = {{"objects grasped", {0.00f, 0.45f, 0.70f}, {}, {}, {}},
                  {"attempts", {0.84f, 0.37f, 0.00f}, {}, {}, {}}};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Run& run = runs[i];
    number.push_back(std::to_string(i + 1));
    grasped.push_back(format("%d/%d", run.grasped, run.of));
    attempts.push_back(std::to_string(run.attempts));
    if (i < kRuns) {
      paper_grasped.push_back(format("%d/5", kPaperGrasped[i]));
      paper_attempts.push_back(kPaperAttempts[i] ? std::to_string(kPaperAttempts[i]) : "–");
    }
    sum_of += run.of, sum_grasped += run.grasped, sum_attempts += run.attempts;
    records.insert(records.end(), run.records.begin(), run.records.end());
    std::string objects;
    for (const std::string& family : run.families) objects += (objects.empty() ? "" : " + ") + family;
    grippers.emplace_back("run " + std::to_string(i + 1) + " (" + objects + ")", run.gripper);
    report.json["runs"].push_back({{"of", run.of},
                                   {"grasped", run.grasped},
                                   {"attempts", run.attempts},
                                   {"slot", run.gripper.slot},
                                   {"objects", run.families}});
    panel.groups.push_back(std::to_string(i + 1));
    panel.series[0].y.push_back(run.grasped), panel.series[1].y.push_back(run.attempts);
  }
  report.json["of"] = sum_of, report.json["grasped"] = sum_grasped, report.json["attempts"] = sum_attempts;
  report.text = row("run", number) + row("objects grasped", grasped) + row("attempts", attempts) +
                row("paper: grasped", paper_grasped) + row("paper: attempts", paper_attempts) +
                format("%d of %d objects in %d attempts (paper: 46 of 50)\n\n", sum_grasped, sum_of, sum_attempts) +
                failures_text(records) + gripper_reasons(grippers);
  report.csv = attempts_csv(records);
  report.panels = {panel};
  return report;
}

int run(const CommonArguments& common) {
  const std::uint64_t seed = seed_of(common);
  const int count = runs_of(common, kRuns);
  const Outputs outputs(common, "table2");
  std::vector<std::string> families;
  for (const physics::ObjectFacts& object : physics::paper_objects()) families.push_back(object.family);
  std::vector<Run> runs;
  for (sensor::SceneFile& scene : sensor::clear_table_scenes(families, seed, count)) {
    Run run;
    for (const sensor::SceneObject& object : scene.objects) {
      if (object.family != "board") run.families.push_back(object.family);
    }
    run.scene = std::move(scene);
    run.seed = seed + 1000 * runs.size();
    run.gripper = gripper_for(run.families);
    runs.push_back(std::move(run));
  }
  carry_out_all(runs, threads_of(common), "run", [&](Run& run) { carry_out(run, common.folder); });
  outputs.write(report_of(runs));
  return 0;
}

}  // namespace

Subcommand add_table2(CLI::App& parent) {
  CLI::App* app =
      parent.add_subcommand("table2", "Clear a table of five objects with Baxter's arm in physics (Table 2)");
  app->allow_extras();
  auto a = std::make_shared<CommonArguments>();
  add_common_flags(*app, *a, "Tables to clear [10]");
  return {app, [a] { return run(*a); }};
}

}  // namespace handhold::experiments
