// Scenes from and to TOML.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "camera_fields.h"
#include "handhold/random_scene.h"
#include "handhold/scene_file.h"
#include "sensor_test_helpers.h"

namespace handhold::sensor {
namespace {

const char* const kSmall = R"(
name = "two"
[camera]
eye = [0, -0.6, 0.5]
target = [0, 0, 0.1]
preset = "xtion"
width = 320
seed = "18446744073709551615"
[camera.noise]
shadows = false
[[object]]
name = "a"
family = "mug"
position = [0.1, 0, 0]
axis = [0, 0, 1]
angle = 0.5
sizes = {radius = 0.04}
material = {reflectance = 0.2, specular = 0.5}
[[object]]
name = "b"
family = "ball"
position = [-0.1, 0, 0]
)";

std::string error_of(const std::string& text) {
  try {
    parse_scene(text, "s.toml");
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void expect_equal(const SceneFile& a, const SceneFile& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.T_world_camera.R, b.T_world_camera.R);
  EXPECT_EQ(a.T_world_camera.t, b.T_world_camera.t);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (std::size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].name, b.objects[i].name);
    EXPECT_EQ(a.objects[i].family, b.objects[i].family);
    EXPECT_EQ(a.objects[i].sizes, b.objects[i].sizes);
    EXPECT_EQ(a.objects[i].material.reflectance, b.objects[i].material.reflectance);
    EXPECT_EQ(a.objects[i].material.specular, b.objects[i].material.specular);
    EXPECT_EQ(a.objects[i].T_world_object.R, b.objects[i].T_world_object.R);
    EXPECT_EQ(a.objects[i].T_world_object.t, b.objects[i].T_world_object.t);
  }
  EXPECT_EQ(to_toml(a), to_toml(b)) << "camera";
}

TEST(SceneFile, WhatAPersonWrites) {
  const SceneFile file = parse_scene(kSmall, "s.toml");
  EXPECT_EQ(file.name, "two");
  EXPECT_EQ(file.camera.width, 320u);
  EXPECT_EQ(file.camera.seed, 18446744073709551615u);
  EXPECT_EQ(file.camera.fy, CameraOptions::xtion().fy);
  EXPECT_EQ(file.camera.noise.axial_sigma, CameraOptions::xtion().noise.axial_sigma);
  EXPECT_FALSE(file.camera.noise.shadows);
  const Pose looking = look_at({0, -0.6, 0.5}, {0, 0, 0.1});
  EXPECT_EQ(file.T_world_camera.R, looking.R);
  const Scene scene = build(file);
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.objects[0].name, "a");
  EXPECT_EQ(scene.objects[0].material.specular, 0.5);
  EXPECT_EQ(scene.objects[1].material.reflectance, Material{}.reflectance);
  // The mug's handle points to +x, turned by 0.5 rad.
  const Eigen::Vector3d handle = eigen(scene.objects[0].parts[0].center);
  EXPECT_NEAR(std::atan2(handle[1], handle[0] - 0.1), 0.5, 1e-9);
}

TEST(SceneFile, ReadsBackBitForBit) {
  expect_equal(parse_scene(to_toml(parse_scene(kSmall, "s.toml")), "again"), parse_scene(kSmall, "s.toml"));
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const SceneFile file = random_scene(seed, RandomSceneOptions::of_half(FamilyHalf::kBoth));
    expect_equal(parse_scene(to_toml(file), "again"), file);
  }
}

TEST(SceneFile, EveryCameraOptionIsKept) {
  SceneFile file = parse_scene(kSmall, "s.toml");
  double value = 0.0101;
  const auto change = [&](const char*, auto& field) {
    using Field = std::decay_t<decltype(field)>;
    if constexpr (std::is_same_v<Field, bool>) {
      field = !field;
    } else if constexpr (std::is_integral_v<Field>) {
      field += 7;
    } else {
      field = value += 0.0101;
    }
  };
  visit_camera(file.camera, change);
  visit_noise(file.camera.noise, change);
  file.camera.max_range = 3;
  file.camera.noise.signal_full = 2;
  file.camera.validate();
  const SceneFile again = parse_scene(to_toml(file), "again");
  expect_equal(again, file);
  EXPECT_EQ(again.camera.noise.axial_slant, file.camera.noise.axial_slant);
  EXPECT_EQ(again.camera.noise.shadows, file.camera.noise.shadows);
}

TEST(SceneFile, MistakesAreNamedWithTheirLine) {
  const auto expect_error = [](const std::string& from, const std::string& to, const std::string& part) {
    const std::string error = error_of(replaced(kSmall, from, to));
    EXPECT_EQ(error.rfind("s.toml, line ", 0), 0u) << error;
    EXPECT_NE(error.find(part), std::string::npos) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  };
  expect_error("name = \"two\"", "name = two", "line 2");
  expect_error("name = \"two\"", "nam = \"two\"", "name is missing");
  expect_error("name = \"two\"", "name = \"../two\"", "letters");
  expect_error("name = \"two\"", "name = \"two\"\nextra = 1",
               "line 3: unknown key 'extra'; must be one of name, camera");
  expect_error("[camera]", "[kamera]", "unknown key 'kamera'; must be one of name, camera, object");
  expect_error("[camera]\neye = [0, -0.6, 0.5]", "[camera]", "camera.eye and target are missing");
  expect_error("eye = [0, -0.6, 0.5]", "eye = [0, -0.6]", "eye must be 3 numbers");
  expect_error("target = [0, 0, 0.1]", "target = [0, -0.6, 0.5]", "look_at");
  expect_error("\"xtion\"", "\"xtoin\"", "kinect, xtion or bare");
  expect_error("width = 320", "width = 0", "width must be a whole number from 1 to 16384");
  expect_error("width = 320", "wdth = 320", "camera.unknown key 'wdth'");
  expect_error("width = 320", "fx = -1.0", "fx");
  expect_error("shadows = false", "shadows = 1", "true or false");
  expect_error("shadows = false", "shadow = false", "unknown key 'shadow'");
  expect_error("family = \"mug\"", "family = \"mugg\"", "object 1: unknown family 'mugg'");
  expect_error("radius = 0.04", "radius = 0.4", "size radius of family 'mug' is 0.4 m");
  expect_error("radius = 0.04", "diameter = 0.08", "unknown size 'diameter'");
  expect_error("radius = 0.04", "radius = \"big\"", "finite number");
  expect_error("reflectance = 0.2", "reflectance = 1.2", "reflectance must be 0 to 1");
  expect_error("angle = 0.5", "angel = 0.5", "angle is missing");
  expect_error("angle = 0.5", "rotation = [1, 0, 0, 0, 1, 0, 0, 0, 1]", "both given");
  expect_error("axis = [0, 0, 1]\nangle = 0.5", "rotation = [1, 0, 0, 0, 1, 0, 0, 0, 2]", "rotation matrix");
  expect_error("axis = [0, 0, 1]\nangle = 0.5", "rotation = [1, 0, 0, 0, 1, 0, 0, 0, -1]", "rotation matrix");
  expect_error("name = \"b\"", "name = \"a\"", "'a' is taken");
  expect_error("position = [-0.1, 0, 0]", "", "position is missing");
  expect_error("position = [-0.1, 0, 0]", "position = [nan, 0, 0]", "finite");
  EXPECT_THROW(read_scene("no/such/scene.toml"), std::runtime_error);
  EXPECT_THROW(read_scene("."), std::runtime_error);
}

TEST(SceneFile, BuildNamesTheObjectThatCannotBe) {
  SceneFile file = parse_scene(kSmall, "s.toml");
  file.objects[1].family = "bal";
  try {
    build(file);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what()).rfind("object 'b': unknown family 'bal'", 0), 0u) << error.what();
  }
}

}  // namespace
}  // namespace handhold::sensor
