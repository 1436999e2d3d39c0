#include "handhold/sensor.h"

namespace handhold::sensor {

Scene table_scene() {
  constexpr Vector3 kUp = {0, 0, 1};
  Scene scene;
  scene.add(table(0.62, 0.46));
  // Nothing stands in another object's shadow, and shells about the graspable parts stay 20 mm clear of neighbours.
  scene.add(mug(), translation(0.16, -0.08, 0) * rotation(kUp, -0.45));
  scene.add(mallet(), translation(-0.24, -0.13, 0) * rotation(kUp, 0.08));
  scene.add(bottle(), translation(-0.15, 0.10, 0));
  scene.add(bowl(), translation(0.03, 0.08, 0));
  scene.add(carton(), translation(0.21, 0.15, 0) * rotation(kUp, 0.5));
  return scene;
}

Pose table_scene_camera() {
  // As a robot's head looks at a table: 0.8 m away, 39 degrees down.
  return look_at({0.02, -0.62, 0.56}, {0, 0, 0.05});
}

CameraOptions table_scene_camera_options() {
  CameraOptions options;
  options.max_range = 4.0;
  options.noise.axial_sigma = 0.0008;
  options.noise.axial_growth = 0.0019;
  options.noise.disparity_step = 0.125;
  options.noise.dropout_from = 1.22;
  options.noise.dropout_to = 1.48;
  return options;
}

}  // namespace handhold::sensor
