// The truth about a scene's parts, and the grasp conditions that the demonstration scene promises.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "handhold/io.h"
#include "handhold/scene_file.h"
#include "handhold/sensor.h"
#include "sensor_test_helpers.h"

namespace handhold::sensor {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.141592653589793;

// ---- Truth ----------------------------------------------------------------------------------------------------------

TEST(Truth, PartsAreCarriedIntoTheCamerasFrame) {
  const DepthCamera camera(table_scene_camera_options());
  const Scene scene = table_scene();
  const Pose T = table_scene_camera();
  const std::vector<Part> truth = camera.truth(scene, T);
  std::size_t i = 0;
  for (const Object& object : scene.objects) {
    for (const Part& part : object.parts) {
      ASSERT_LT(i, truth.size());
      EXPECT_EQ(truth[i].what, part.what);
      EXPECT_NEAR((eigen(T.point(truth[i].center)) - eigen(part.center)).norm(), 0, 1e-12);
      EXPECT_NEAR(std::abs(eigen(T.direction(truth[i].axis)).dot(eigen(part.axis))), 1, 1e-12);
      const Vector3d axis = eigen(truth[i].axis);
      int largest = 0;
      axis.cwiseAbs().maxCoeff(&largest);
      EXPECT_GT(axis[largest], 0) << part.what;
      EXPECT_EQ(truth[i].radius, part.radius);
      EXPECT_NEAR((eigen(truth[i].centre_line.back()) - eigen(truth[i].centre_line.front())).norm(), part.length, 1e-9);
      EXPECT_GE(truth[i].visible, 0);
      EXPECT_LE(truth[i].visible, 1);
      ++i;
    }
  }
  EXPECT_EQ(i, truth.size());
}

TEST(Truth, VisibleIsTheShareThatNothingHides) {
  Object rod = {"rod", cylinder(0.02, 0.2), {}};
  rod.parts.push_back({"rod", {0, 0, 0.1}, {0, 0, 1}, 0.02, 0.16, 1, {{0, 0, 0.02}, {0, 0, 0.18}}, 1, true});
  Scene scene;
  scene.add(rod, translation(0, 0, 1) * rotation({1, 0, 0}, kPi / 2) * translation(0, 0, -0.1));
  const DepthCamera camera;
  EXPECT_NEAR(camera.truth(scene, Pose{})[0].visible, 1, 1e-6);
  // A screen close to the rod over everything with y < 0, which is half of it.
  Scene screened = scene;
  screened.add({"screen", box(1, 1, 0.01), {}}, translation(0, -0.5, 0.9));
  EXPECT_NEAR(camera.truth(screened, Pose{})[0].visible, 0.5, 0.05);
  EXPECT_NEAR(camera.truth(scene, translation(5, 0, 0))[0].visible, 0, 1e-9) << "out of view";
}

TEST(Truth, JsonHasThePartsOfEveryScene) {
  Part part = {"a \"rod\"", {0.1, -0.25, 1}, {0, 0, 1}, 0.02, 0.16, 1, {{0, 0, 0}, {-1e-9, 0, 0.5}}, 0.75, false};
  Part owned = part;
  owned.family = "mug";
  EXPECT_NE(truth_json({{"one", {owned}}}).find("    {\"family\": \"mug\", \"what\": "), std::string::npos);
  EXPECT_EQ(truth_json({{"one", {part}}, {"none", {}}}),
            "{\n  \"one\": [\n"
            "    {\"what\": \"a \\\"rod\\\"\", \"center\": [0.1, -0.25, 1], \"axis\": [0, 0, 1],\n"
            "     \"radius\": 0.02, \"length\": 0.16, \"confidence\": 1,\n"
            "     \"centre_line\": [[0, 0, 0], [0, 0, 0.5]],\n"
            "     \"visible\": 0.75, \"measured\": true, \"raised\": true, \"graspable\": false}\n"
            "  ],\n  \"none\": []\n}\n");
}

// ---- The demonstration scene ----------------------------------------------------------------------------------------

/// Whether no point lies between r and r + 10 mm of the axis for an r within an 80 mm hand, over 20 mm about `at`.
/// Half a per cent of the slab's points may, for noise.
bool has_empty_ring(const std::vector<Vector3d>& points, const Vector3d& at, const Vector3d& axis, double radius) {
  constexpr double kHalfWidth = 0.010, kThickness = 0.010, kHalfAperture = 0.040;
  std::vector<double> rho;
  for (const Vector3d& p : points) {
    const Vector3d d = p - at;
    const double along = d.dot(axis);
    if (std::abs(along) > kHalfWidth) continue;
    rho.push_back((d - along * axis).norm());
  }
  for (double r = radius; r <= kHalfAperture + 0.004; r += 0.0005) {
    int in_ring = 0, within = 0;
    for (const double x : rho) {
      in_ring += x > r && x < r + kThickness;
      within += x <= r;
    }
    if (within > 30 && in_ring <= 0.005 * within) return true;
  }
  return false;
}

TEST(TableScene, GraspablePartsHaveAnEmptyRingForTheFingers) {
  const DepthCamera camera(table_scene_camera_options());
  const Frame frame = camera.capture(table_scene(), table_scene_camera());
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
    if (measured(frame.cloud, i)) points.push_back(point(frame.cloud, i));
  }
  int graspable = 0;
  for (const Part& part : camera.truth(table_scene(), table_scene_camera())) {
    double free_length = 0;
    for (double s = -part.length / 2; s <= part.length / 2; s += 0.002) {
      const Vector3d at = eigen(part.center) + s * eigen(part.axis);
      free_length += has_empty_ring(points, at, eigen(part.axis), part.radius) ? 0.002 : 0;
    }
    if (part.graspable) {
      EXPECT_GE(free_length, 0.020) << part.what;
      EXPECT_GT(part.visible, 0.9) << part.what;
      EXPECT_LE(2 * part.radius, 0.08) << part.what;
      ++graspable;
    }
    if (2 * part.radius > 0.08) {
      EXPECT_FALSE(part.graspable) << part.what;
    }
  }
  EXPECT_EQ(graspable, 5);
}

TEST(TableScene, FilesInDataAreWhatTheCameraGives) {
  const DepthCamera camera(table_scene_camera_options());
  std::ifstream file(HANDHOLD_DATA "/table_scene.truth.json");
  ASSERT_TRUE(file) << "cannot read " HANDHOLD_DATA "/table_scene.truth.json";
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const Frame frame = camera.capture(table_scene(), table_scene_camera());
  const std::vector<Part> truth = captured_truth(table_scene(), table_scene_camera(), camera.options(), frame);
  EXPECT_EQ(text, truth_json({{"table_scene", truth}}));

  const Cloud stored = read_cloud(HANDHOLD_DATA "/table_scene.pcd");
  ASSERT_EQ(stored.width, frame.cloud.width);
  ASSERT_EQ(stored.height, frame.cloud.height);
  std::size_t different = 0;
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const bool same =
        measured(stored, i) ? (point(stored, i) - point(frame.cloud, i)).norm() < 1e-6 : !measured(frame.cloud, i);
    different += !same;
  }
  // Another machine's logarithm may differ in the last bit, and tip a value over the edge of a quantization step.
  EXPECT_LE(different, 10u);
}

}  // namespace
}  // namespace handhold::sensor
