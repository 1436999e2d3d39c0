// The scenes of the paper's experiments: the same on every run.
#include <cmath>

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
    const Resting thing = at_rest(place.family, place.family, {}, {});
    file.objects.push_back(moved(thing, place.x, place.y, 0, place.yaw * kDegree).object);
  }
  file.T_world_camera = look_at(eye, target);
  file.camera = CameraOptions::xtion();
  file.camera.seed = seed;
  return file;
}

}  // namespace

std::vector<SceneFile> paper_scenes() {
  return {};
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
