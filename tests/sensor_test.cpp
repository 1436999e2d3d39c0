// The simulated camera against its own description: analytic surfaces, and statistics with confidence bounds.
#include "handhold/sensor.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "sensor_test_helpers.h"

namespace handhold::sensor {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.141592653589793;

/// Closest distance to a triangle (Ericson, Real-Time Collision Detection, 5.1.5, by cases over the plane and the
/// edges).
double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a);
  const auto inside = [&](const Vector3d& from, const Vector3d& to) { return n.cross(to - from).dot(p - from) >= 0; };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(n.normalized().dot(p - a));
  const auto to_edge = [&](const Vector3d& from, const Vector3d& to) {
    const Vector3d d = to - from;
    const double s = std::min(1.0, std::max(0.0, d.dot(p - from) / d.squaredNorm()));
    return (p - from - s * d).norm();
  };
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

double distance_to_mesh(const Vector3d& p, const Mesh& mesh) {
  double best = HUGE_VAL;
  for (const auto& t : mesh.triangles) {
    best = std::min(best, distance_to_triangle(p, eigen(mesh.vertices[t[0]]), eigen(mesh.vertices[t[1]]),
                                               eigen(mesh.vertices[t[2]])));
  }
  return best;
}

// ---- Camera without noise -------------------------------------------------------------------------------------------

TEST(DepthCamera, RayOfAPixelProjectsOntoThatPixel) {
  CameraOptions options;
  options.fx = 570;
  options.fy = 580;
  options.cx = 310.25;
  options.cy = 244.5;
  const DepthCamera camera(options);
  for (double u : {0.0, 17.0, 320.0, 639.0}) {
    for (double v : {0.0, 200.5, 479.0}) {
      const Vector3 d = camera.ray(u, v);
      const auto pixel = camera.project({1.7 * d[0], 1.7 * d[1], 1.7 * d[2]});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR((*pixel)[0], u, 1e-10);
      EXPECT_NEAR((*pixel)[1], v, 1e-10);
    }
  }
  EXPECT_FALSE(camera.project({0, 0, 0}));
  EXPECT_FALSE(camera.project({0.1, 0, -1}));
}

TEST(DepthCamera, PointsOfTheCloudLieOnTheirPixelsRays) {
  for (const bool noisy : {false, true}) {
    CameraOptions options = noisy ? CameraOptions::kinect() : CameraOptions{};
    const DepthCamera camera(options);
    const Frame frame = camera.capture(table_scene(), table_scene_camera());
    std::size_t n = 0;
    for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
      ASSERT_EQ(measured(frame.cloud, i), frame.object[i] >= 0);
      if (!measured(frame.cloud, i)) continue;
      const Vector3d p = point(frame.cloud, i);
      const auto pixel = camera.project({p.x(), p.y(), p.z()});
      ASSERT_TRUE(pixel);
      ASSERT_NEAR((*pixel)[0], static_cast<double>(i % options.width), 1e-3);
      ASSERT_NEAR((*pixel)[1], static_cast<double>(i / options.width), 1e-3);
      ++n;
    }
    EXPECT_GT(n, 100000u);
  }
}

TEST(DepthCamera, PointsLieOnTheSurfaceOfTheirObject) {
  const DepthCamera camera(small_camera());
  const Scene scene = table_scene();
  const Pose T = table_scene_camera();
  const Frame frame = camera.capture(scene, T);
  std::map<int, int> looked_at;
  for (std::size_t i = 0; i < frame.cloud.size(); i += 7) {
    if (!measured(frame.cloud, i)) continue;
    const Vector3d p = point(frame.cloud, i);
    const Vector3 world = T.point({p.x(), p.y(), p.z()});
    ASSERT_LT(distance_to_mesh(eigen(world), scene.objects[frame.object[i]].mesh), 2e-6) << "pixel " << i;
    ++looked_at[frame.object[i]];
  }
  EXPECT_EQ(looked_at.size(), scene.objects.size()) << "every object is in view";
}

TEST(DepthCamera, SurfacesHideWhatIsBehindThem) {
  Scene scene = wall(2);
  scene.add({"sphere",
             revolve([] {
               std::vector<Point2> arc;
               for (int i = 0; i <= 64; ++i) {
                 const double a = kPi * i / 64;
                 arc.push_back({i % 64 ? 0.2 * std::sin(a) : 0, -0.2 * std::cos(a)});
               }
               return arc;
             }()),
             {}},
            translation(0, 0, 1));
  CameraOptions options = small_camera();
  const Frame frame = DepthCamera(options).capture(scene, Pose{});
  for (std::uint32_t v = 0; v < options.height; ++v) {
    for (std::uint32_t u = 0; u < options.width; ++u) {
      const Vector3d d = eigen(DepthCamera(options).ray(u, v)).normalized();
      const double closest = d.cross(Vector3d(0, 0, 1)).norm();  // of the ray to the sphere's centre
      const int object = frame.object[v * options.width + u];
      if (closest < 0.198) {
        ASSERT_EQ(object, 1) << u << " " << v;
      }
      if (closest > 0.2) {
        ASSERT_EQ(object, 0) << u << " " << v;
      }
    }
  }
}

TEST(DepthCamera, LoneCylinderGivesItsRadiusAndNormalsAcrossItsAxis) {
  constexpr double kRadius = 0.03;
  Scene scene;
  const Pose T_world_object = translation(0.02, -0.05, 0.7) * rotation({1, 0.3, 0.2}, 1.2);
  scene.add({"cylinder", cylinder(kRadius, 0.2, 512), {}}, T_world_object);
  const Frame frame = DepthCamera(CameraOptions{}).capture(scene, Pose{});
  const Vector3d axis = eigen(T_world_object.direction({0, 0, 1})), base = eigen(T_world_object.t);
  // Kasa circle fit in the plane across the axis, and normals from neighbouring pixels.
  const Vector3d e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  int n = 0, normals = 0;
  for (std::uint32_t v = 1; v + 1 < 480; ++v) {
    for (std::uint32_t u = 1; u + 1 < 640; ++u) {
      const std::size_t i = v * 640 + u;
      const auto on_side = [&](std::size_t k) {
        const double along = axis.dot(point(frame.cloud, k) - base);
        return measured(frame.cloud, k) && along > 0.001 && along < 0.199;
      };
      if (!on_side(i)) continue;
      const Vector3d d = point(frame.cloud, i) - base;
      const Vector3d l(d.dot(e1), d.dot(e2), 1);
      A += l * l.transpose();
      b += l * (l.x() * l.x() + l.y() * l.y());
      ++n;
      if (!on_side(i - 1) || !on_side(i + 1) || !on_side(i - 640) || !on_side(i + 640)) continue;
      const Vector3d normal = (point(frame.cloud, i + 1) - point(frame.cloud, i - 1))
                                  .cross(point(frame.cloud, i - 640) - point(frame.cloud, i + 640))
                                  .normalized();
      const Vector3d radial = (d - d.dot(axis) * axis).normalized();
      // A chord's normal lags where the surface turns away quickly.
      if (radial.dot(-point(frame.cloud, i).normalized()) > 0.5) {
        ASSERT_GT(std::abs(normal.dot(radial)), 0.995);
        ASSERT_LT(std::abs(normal.dot(axis)), 0.02);
        ++normals;
      }
    }
  }
  ASSERT_GT(n, 3000);
  ASSERT_GT(normals, 2000);
  const Vector3d c = A.ldlt().solve(b);
  EXPECT_NEAR(std::sqrt(c.z() + c.x() * c.x() / 4 + c.y() * c.y() / 4), kRadius, 5e-6);
  EXPECT_NEAR(std::hypot(c.x() / 2, c.y() / 2), 0, 1e-5);
}

TEST(DepthCamera, SeesNothingFromInsideASolidOrInEmptySpace) {
  Scene inside;
  inside.add({"room", box(2, 2, 2), {}});
  EXPECT_EQ(measured_points(DepthCamera(small_camera()).capture(inside, Pose{}).cloud), 0u);
  EXPECT_EQ(measured_points(DepthCamera(small_camera()).capture(Scene{}, Pose{}).cloud), 0u);
  Scene behind;
  behind.add({"box", box(1, 1, 1), {}}, translation(0, 0, -2));
  EXPECT_EQ(measured_points(DepthCamera(small_camera()).capture(behind, Pose{}).cloud), 0u);
}

TEST(DepthCamera, MeasuresOnlyWithinItsRange) {
  CameraOptions options = small_camera();
  options.min_range = 0.5;
  options.max_range = 1.5;
  const DepthCamera camera(options);
  EXPECT_EQ(measured_points(camera.capture(wall(0.49), Pose{}).cloud), 0u);
  EXPECT_EQ(measured_points(camera.capture(wall(1), Pose{}).cloud), camera.options().width * camera.options().height);
  EXPECT_EQ(measured_points(camera.capture(wall(1.51), Pose{}).cloud), 0u);
}

TEST(DepthCamera, CloudIsOrganizedAndSeenFromTheOrigin) {
  const Frame frame = DepthCamera(small_camera()).capture(wall(1), translation(0, 0, 0.25));
  EXPECT_EQ(frame.cloud.width, 160u);
  EXPECT_EQ(frame.cloud.height, 120u);
  EXPECT_EQ(frame.cloud.xyz.size(), 3u * 160 * 120);
  ASSERT_TRUE(frame.cloud.viewpoint);
  EXPECT_EQ(*frame.cloud.viewpoint, (Vector3{0, 0, 0}));
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) ASSERT_NEAR(point(frame.cloud, i).z(), 0.75, 1e-6);
}

TEST(DepthCamera, BadMeshThrows) {
  Scene scene;
  scene.add({"broken", {{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, {{0, 1, 3}}}, {}});
  EXPECT_THROW(DepthCamera().capture(scene, Pose{}), std::invalid_argument);
  scene.objects[0].mesh = {{{0, 0, 1}, {1, 0, NAN}, {0, 1, 1}}, {{0, 1, 2}}};
  EXPECT_THROW(DepthCamera().capture(scene, Pose{}), std::invalid_argument);
}

TEST(DepthCamera, BadMaterialThrowsAndNamesTheObject) {
  for (const Material& material : {Material{-0.1, 0}, Material{0.5, 1.5}, Material{NAN, 0}}) {
    Scene scene = wall(1);
    scene.objects[0].material = material;
    try {
      DepthCamera().capture(scene, Pose{});
      ADD_FAILURE() << "was accepted";
    } catch (const std::invalid_argument& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find("'wall' has material."), std::string::npos) << what;
      EXPECT_NE(what.find("must be 0 to 1"), std::string::npos) << what;
    }
  }
}

// ---- Options --------------------------------------------------------------------------------------------------------

TEST(CameraOptions, BadValuesThrowAndNameTheOption) {
  const std::vector<std::pair<const char*, std::function<void(CameraOptions&)>>> cases = {
      {"width", [](CameraOptions& o) { o.width = 0; }},
      {"height", [](CameraOptions& o) { o.height = 20000; }},
      {"fx", [](CameraOptions& o) { o.fx = 0; }},
      {"fy", [](CameraOptions& o) { o.fy = -575; }},
      {"cx", [](CameraOptions& o) { o.cx = NAN; }},
      {"min_range", [](CameraOptions& o) { o.min_range = 0; }},
      {"max_range", [](CameraOptions& o) { o.max_range = 0.2; }},
      {"noise.axial_sigma", [](CameraOptions& o) { o.noise.axial_sigma = -1e-3; }},
      {"noise.axial_growth", [](CameraOptions& o) { o.noise.axial_growth = NAN; }},
      {"noise.axial_slant", [](CameraOptions& o) { o.noise.axial_slant = -1; }},
      {"noise.lateral_sigma", [](CameraOptions& o) { o.noise.lateral_sigma = HUGE_VAL; }},
      {"noise.lateral_slant", [](CameraOptions& o) { o.noise.lateral_slant = NAN; }},
      {"noise.correlation_u", [](CameraOptions& o) { o.noise.correlation_u = 17; }},
      {"noise.correlation_v", [](CameraOptions& o) { o.noise.correlation_v = -1; }},
      {"noise.glare_width", [](CameraOptions& o) { o.noise.glare_width = 2; }},
      {"noise.signal_none", [](CameraOptions& o) { o.noise.signal_none = NAN; }},
      {"noise.signal_full", [](CameraOptions& o) { o.noise.signal_none = 0.2, o.noise.signal_full = 0.1; }},
      {"noise.edge_step", [](CameraOptions& o) { o.noise.edge_step = 0; }},
      {"noise.edge_dropout", [](CameraOptions& o) { o.noise.edge_dropout = 1.1; }},
      {"noise.mixed", [](CameraOptions& o) { o.noise.edge_dropout = 0.6, o.noise.mixed = 0.5; }},
      {"noise.disparity_step", [](CameraOptions& o) { o.noise.disparity_step = -0.125; }},
      {"noise.disparity_focal", [](CameraOptions& o) { o.noise.disparity_focal = 0; }},
      {"noise.baseline", [](CameraOptions& o) { o.noise.baseline = HUGE_VAL; }},
      {"noise.dropout_from", [](CameraOptions& o) { o.noise.dropout_from = 80; }},
      {"noise.dropout_to", [](CameraOptions& o) { o.noise.dropout_from = 1.2, o.noise.dropout_to = 1.1; }},
  };
  for (const auto& [name, spoil] : cases) {
    CameraOptions options;
    spoil(options);
    try {
      DepthCamera camera(options);
      ADD_FAILURE() << name << " was accepted";
    } catch (const std::invalid_argument& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(std::string("camera option ") + name + " = "), std::string::npos) << what;
      EXPECT_NE(what.find("must be"), std::string::npos) << what;
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    }
  }
}

}  // namespace
}  // namespace handhold::sensor
