// The scenes of the paper's experiments: the same on every run.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "draw.h"
#include "handhold/random_scene.h"
#include "placement.h"

namespace handhold::sensor {
namespace {

constexpr double kDegree = 3.141592653589793 / 180;

/// A thing of default size on the table.
struct Place {
  const char* family;
  double x, y;  ///< m
  double yaw;   ///< degrees
  bool lying = false;
};

SceneObject table_top() {
  SceneObject table;
  table.name = "table";
  table.family = "board";
  table.sizes = {{"width", 1.4}, {"depth", 1.0}, {"thickness", 0.03}};
  return table;
}

SceneFile scene_of(const std::string& name, const std::vector<Place>& places, const Vector3& eye, const Vector3& target,
                   std::uint64_t seed) {
  SceneFile file;
  file.name = name;
  file.objects.push_back(table_top());
  for (const Place& place : places) {
    // As it was made it stands, or tips over onto the side on which it is used.
    const Pose start = place.lying ? rotation({0, 1, 0}, 90 * kDegree) : Pose{};
    const Resting thing = at_rest(place.family, place.family, {}, start);
    file.objects.push_back(moved(thing, place.x, place.y, 0, place.yaw * kDegree).object);
  }
  file.T_world_camera = look_at(eye, target);
  file.camera = CameraOptions::xtion();
  file.camera.seed = seed;
  return file;
}

/// `count` of them, each at most once.
std::vector<std::string> drawn(std::vector<std::string> families, Draw& draw, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) std::swap(families[i], families[i + draw.index(families.size() - i)]);
  families.resize(count);
  return families;
}

/// Puts an object beside the others; false when no place was found.
bool put(SceneFile& file, const std::string& family, std::vector<Resting>& others, Draw& draw) {
  constexpr double kGap = 0.03, kHalfWidth = 0.24, kNear = -0.15, kFar = 0.15;  // m
  const Resting thing = at_rest(family, family, {}, {});
  for (int i = 0; i < 200; ++i) {
    const double x = draw.uniform(-kHalfWidth, kHalfWidth), y = draw.uniform(kNear, kFar);
    // Handles point to +x in their objects; the camera stands at -y.
    const Resting here = moved(thing, x, y, 0, draw.uniform(-155, -15) * kDegree);
    const auto clear = [&](const Resting& other) { return apart(here.footprint, other.footprint, kGap); };
    if (!std::all_of(others.begin(), others.end(), clear)) continue;
    others.push_back(here);
    file.objects.push_back(here.object);
    return true;
  }
  return false;
}

}  // namespace

std::vector<SceneFile> clear_table_scenes(const std::vector<std::string>& families, std::uint64_t seed, int count) {
  constexpr std::size_t kThings = 5, kMostTries = 1000;
  if (families.size() < kThings) {
    throw std::invalid_argument("clear_table_scenes: " + std::to_string(families.size()) +
                                " families; at least five are needed");
  }
  for (std::size_t i = 0; i < families.size(); ++i) {
    family(families[i]);
    if (std::count(families.begin(), families.end(), families[i]) > 1) {
      throw std::invalid_argument("clear_table_scenes: '" + families[i] + "' is named twice");
    }
  }
  if (count < 0) throw std::invalid_argument("clear_table_scenes: a count of " + std::to_string(count) + " scenes");
  std::vector<SceneFile> scenes;
  for (std::uint32_t series = 1; scenes.size() < static_cast<std::size_t>(count); ++series) {
    if (series > kMostTries * (scenes.size() + 1)) {
      throw std::invalid_argument("clear_table_scenes: no five of the families find room on the table");
    }
    Draw draw(seed, series);
    SceneFile file = scene_of("clear_" + std::to_string(scenes.size() + 1), {}, {0, -0.62, 0.60}, {0, 0, 0.05},
                              seed + scenes.size());
    std::vector<Resting> things;
    bool all = true;
    for (const std::string& name : drawn(families, draw, kThings)) all = all && put(file, name, things, draw);
    if (all) scenes.push_back(std::move(file));
  }
  return scenes;
}

std::vector<SceneFile> paper_scenes() {
  // Places for which the camera sees all parts of every object, found by trying many.
  const std::vector<std::vector<Place>> layouts = {
      {{"purex_bottle", 0.04, -0.01, -125},
       {"carrying_case", 0.17, 0.19, -20},
       {"brush_1", 0.20, -0.10, -125},
       {"plunger", -0.09, -0.17, -155},
       {"dust_pan", -0.26, 0.05, -135}},
      {{"all_bottle", -0.26, 0.16, -70},
       {"sponge", 0.16, 0.05, -140},
       {"brush_2", -0.02, -0.07, -35},
       {"pot", -0.23, -0.21, 5}},
      {{"lint_roller", -0.03, -0.22, -90}, {"sprayer", 0.23, 0.14, -20}, {"dust_pan", -0.22, 0.11, -55}},
      {{"purex_bottle", 0.04, 0.11, -135},
       {"plunger", 0.06, -0.08, -95},
       {"sponge", 0.26, 0.00, -25},
       {"pot", -0.13, -0.21, -20}},
      {{"all_bottle", -0.12, 0.07, -80},
       {"carrying_case", 0.24, -0.18, 40},
       {"brush_1", 0.15, 0.13, -155},
       {"sprayer", 0.29, 0.09, -10}},
      {{"purex_bottle", 0.13, 0.20, 0},
       {"carrying_case", -0.40, -0.05, -10},
       {"brush_1", 0.32, 0.09, -105},
       {"plunger", -0.12, -0.24, -165},
       {"dust_pan", -0.21, 0.25, -45},
       {"brush_2", 0.06, -0.09, -70},
       {"sponge", 0.22, -0.19, -55},
       {"lint_roller", -0.36, -0.24, -145}},
      {{"blue_bottle", -0.06, 0.26, -5},
       {"purex_bottle", 0.37, 0.21, -155},
       {"brush_1", 0.08, -0.17, -140},
       {"plunger", 0.20, 0.15, -125},
       {"brush_2", -0.08, 0.04, -150},
       {"sponge", -0.12, -0.20, -110},
       {"dust_pan", 0.39, -0.26, -135}},
  };
  std::vector<SceneFile> scenes;
  for (const std::vector<Place>& layout : layouts) {
    const std::size_t number = scenes.size() + 1;
    const Vector3 eye = number <= 5 ? Vector3{0, -0.62, 0.66} : Vector3{0, -0.68, 0.80};
    scenes.push_back(scene_of("paper_" + std::to_string(number), layout, eye, {0, -0.01, 0.05}, number));
  }
  return scenes;
}

std::vector<SceneFile> single_object_scenes() {
  constexpr const char* kObjects[] = {"blue_bottle", "purex_bottle", "all_bottle", "carrying_case",
                                      "brush_1",     "pot",          "plunger",    "sprayer",
                                      "dust_pan",    "brush_2",      "sponge",     "lint_roller"};
  // Handles point to +x in their objects; the camera stands at -y: half a turn's range shows them to it.
  constexpr double kYaws[] = {-150, -110, -65, -20};
  constexpr Point2 kPositions[] = {{0, 0}, {-0.16, 0.08}, {0.15, -0.06}};
  std::vector<SceneFile> scenes;
  for (const char* object : kObjects) {
    for (int orientation = 0; orientation < 4; ++orientation) {
      for (int position = 0; position < 3; ++position) {
        const std::string name = std::string("single_") + object + "_o" + std::to_string(orientation + 1) + "_p" +
                                 std::to_string(position + 1);
        scenes.push_back(scene_of(name,
                                  {{object, kPositions[position][0], kPositions[position][1], kYaws[orientation]}},
                                  {0, -0.62, 0.60}, {0, 0, 0.05}, scenes.size() + 1));
      }
    }
  }
  return scenes;
}

}  // namespace handhold::sensor
