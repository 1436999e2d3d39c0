// Each of the twelve objects alone, in four orientations at three places, until it is in the box or three attempts have
// failed (Table 1 of the paper).
#include <algorithm>
#include <array>
#include <iterator>
#include <memory>

#include "experiments.h"
#include "handhold/random_scene.h"
#include "picking_report.h"
#include "text.h"

namespace handhold::experiments {
namespace {

using evaluation::format;

constexpr int kAttempts = 3;
constexpr int kOrientations = 4, kPlaces = 3;

/// Of twelve trials each: grasped on the first attempt, by the second, by the third.
struct Published {
  const char* family;
  const char* name;
  std::array<int, kAttempts> grasped;
};
constexpr Published kPaper[] = {{"blue_bottle", "Blue Bottle", {10, 10, 12}},
                                {"purex_bottle", "White Purex Bottle", {11, 12, 12}},
                                {"all_bottle", "White All Bottle", {9, 12, 12}},
                                {"carrying_case", "Carrying Case", {11, 11, 11}},
                                {"brush_1", "Brush 1", {10, 11, 12}},
                                {"pot", "Pot", {11, 12, 12}},
                                {"plunger", "Plunger", {11, 12, 12}},
                                {"sprayer", "Sprayer", {11, 12, 12}},
                                {"dust_pan", "Dust Pan", {11, 12, 12}},
                                {"brush_2", "Brush 2", {8, 12, 12}},
                                {"sponge", "Sponge", {8, 12, 12}},
                                {"lint_roller", "Lint Roller", {11, 12, 12}}};
constexpr std::size_t kObjects = std::size(kPaper);

struct Arguments {
  std::string objects, orientations, places;
  CommonArguments common;
};

/// One trial: which object, which scene.
struct Trial {
  std::size_t object;
  sensor::SceneFile scene;
  std::uint64_t seed;
  std::vector<AttemptRecord> records;
};

std::vector<bool> objects_of(const std::string& text) {
  std::vector<bool> chosen(kObjects, text.empty());
  std::string known;
  for (const Published& object : kPaper) known += (known.empty() ? "" : ", ") + std::string(object.family);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(", ", begin), text.size());
    const std::string name = text.substr(begin, end - begin);
    begin = end + 1;
    if (name.empty()) continue;
    const auto it =
        std::find_if(std::begin(kPaper), std::end(kPaper), [&](const Published& o) { return o.family == name; });
    if (it == std::end(kPaper)) throw UsageError("--objects: unknown object '" + name + "'; known are: " + known);
    chosen[static_cast<std::size_t>(it - std::begin(kPaper))] = true;
  }
  if (std::none_of(chosen.begin(), chosen.end(), [](bool c) { return c; })) {
    throw UsageError("--objects names none; known are: " + known);
  }
  return chosen;
}

std::vector<Trial> trials_of(const Arguments& a) {
  const std::vector<bool> objects = objects_of(a.objects);
  const int orientations = a.orientations.empty()
                               ? kOrientations
                               : static_cast<int>(whole_number("--orientations", a.orientations, 1, kOrientations));
  const int places = a.places.empty() ? kPlaces : static_cast<int>(whole_number("--places", a.places, 1, kPlaces));
  const int runs = runs_of(a.common, 1);
  const std::uint64_t seed = seed_of(a.common);
  const std::vector<sensor::SceneFile> scenes = sensor::single_object_scenes();
  std::vector<Trial> trials;
  for (int run = 0; run < runs; ++run) {
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const std::size_t object = i / (kOrientations * kPlaces);
      const int orientation = static_cast<int>(i) / kPlaces % kOrientations, place = static_cast<int>(i) % kPlaces;
      if (!objects[object] || orientation >= orientations || place >= places) continue;
      Trial trial{object, scenes[i], seed + 1000 * (i + scenes.size() * static_cast<std::uint64_t>(run)), {}};
      if (runs > 1) trial.scene.name += "_r" + std::to_string(run + 1);
      trials.push_back(std::move(trial));
    }
  }
  return trials;
}

void carry_out(Trial& trial, const std::string& pictures) {
  const std::string family = kPaper[trial.object].family;
  const plan::ElectricGripper gripper = gripper_for({family});
  const Workplace place = workplace(gripper);
  Picker picker(place, things_of(trial.scene, place.T_base_scene), localizer_options(gripper));
  picker.settle();
  for (int i = 1; i <= kAttempts && !picker.left().empty(); ++i) {
    AttemptRecord record{trial.scene.name, gripper, i, family,
                         picker.attempt(trial.seed + static_cast<std::uint64_t>(i))};
    if (record.attempt.ending != Ending::kGrasped && !pictures.empty()) {
      write_failure(pictures, record, picker.look(), picker.world().arm());
    }
    trial.records.push_back(std::move(record));
  }
}

/// Trials that had succeeded by each attempt.
struct Row {
  int trials = 0;
  std::array<int, kAttempts> grasped{};

  void add(const Trial& trial) {
    ++trials;
    for (const AttemptRecord& record : trial.records) {
      if (record.attempt.ending != Ending::kGrasped) continue;
      for (int k = record.number - 1; k < kAttempts; ++k) ++grasped[static_cast<std::size_t>(k)];
    }
  }
  Json json() const {
    return {{"trials", trials}, {"first", grasped[0]}, {"second", grasped[1]}, {"third", grasped[2]}};
  }
};

std::string cells(const std::array<int, kAttempts>& grasped, int trials) {
  std::string text;
  for (const int n : grasped) text += format("  %8s", format("%d/%d", n, trials).c_str());
  return text;
}
std::string cells(const Row& row) {
  return cells(row.grasped, row.trials);
}

Report report_of(const std::vector<Trial>& trials) {
  std::vector<Row> rows(kObjects);
  Row all;
  std::vector<AttemptRecord> records;
  std::vector<std::pair<std::string, plan::ElectricGripper>> grippers;
  for (const Trial& trial : trials) {
    rows[trial.object].add(trial);
    all.add(trial);
    records.insert(records.end(), trial.records.begin(), trial.records.end());
    grippers.emplace_back(kPaper[trial.object].family, gripper_for({kPaper[trial.object].family}));
  }
  Report report;
  report.text = format("%-20s  grasped by attempt              the paper\n%-20s  %8s  %8s  %8s  %8s  %8s  %8s\n", "",
                       "", "1st", "2nd", "3rd", "1st", "2nd", "3rd");
  report.json = all.json();
  report.json["experiment"] = "table1";
  report.json["objects"] = Json::array();
  PlotPanel panel;
  panel.title = "Grasped on the first attempt";
  panel.y_label = "share of trials";
  panel.highest = 1;
  panel.series = {{"here, in simulation", {0.00f, 0.45f, 0.70f}, {}, {}, {}},
                  {"paper", {0.60f, 0.60f, 0.60f}, {}, {}, {}}};
  std::array<int, kAttempts> published{};
  int published_trials = 0;
  for (std::size_t i = 0; i < kObjects; ++i) {
    const Row& row = rows[i];
    if (row.trials == 0) continue;
    report.text += format("%-20s%s%s\n", kPaper[i].name, cells(row).c_str(), cells(kPaper[i].grasped, 12).c_str());
    Json json = {{"name", kPaper[i].family}};
    json.update(row.json());
    report.json["objects"].push_back(json);
    panel.groups.push_back(kPaper[i].family);
    panel.series[0].y.push_back(static_cast<double>(row.grasped[0]) / row.trials);
    panel.series[1].y.push_back(kPaper[i].grasped[0] / 12.0);
    for (std::size_t k = 0; k < kAttempts; ++k) published[k] += kPaper[i].grasped[k];
    published_trials += 12;
  }
  report.text += format("%-20s%s%s\n\n", "all", cells(all).c_str(), cells(published, published_trials).c_str());
  report.text += failures_text(records) + gripper_reasons(grippers);
  report.csv = attempts_csv(records);
  report.panels = {panel};
  return report;
}

int run(const Arguments& a) {
  std::vector<Trial> trials = trials_of(a);
  const Outputs outputs(a.common, "table1");
  carry_out_all(trials, threads_of(a.common), "trial", [&](Trial& trial) { carry_out(trial, a.common.folder); });
  outputs.write(report_of(trials));
  return 0;
}

}  // namespace

Subcommand add_table1(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("table1", "Grasp single objects with Baxter's arm in physics (Table 1)");
  app->allow_extras();
  auto a = std::make_shared<Arguments>();
  const char* what = "What is tried";
  add_text_flag(*app, "--objects", a->objects, "LIST", "Families of objects [the paper's twelve]", what);
  add_text_flag(*app, "--orientations", a->orientations, "N", "Orientations of each object, 1 to 4 [4]", what);
  add_text_flag(*app, "--places", a->places, "N", "Places of each object on the table, 1 to 3 [3]", what);
  add_common_flags(*app, a->common, "Runs of each trial, with other noise [1]");
  return {app, [a] { return run(*a); }};
}

}  // namespace handhold::experiments
