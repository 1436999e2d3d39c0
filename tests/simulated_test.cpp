// The localizer against scenes whose answer is known: surfaces of one formula under random motions, noise and
// densities, and the demonstration scene of the simulated camera.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "handhold/localizer.h"
#include "handhold/sensor.h"
#include "paper_options.h"
#include "reference/circle.h"
#include "test_clouds.h"

namespace handhold {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::FloatPoints;
using test::Random;

Vector3d eigen(const Vector3& v) {
  return {v[0], v[1], v[2]};
}

/// How a surface was sampled.
struct Sampling {
  double density;  ///< points per m^2; a Kinect at 0.7 m gives 660,000 head-on
  double noise;    ///< m; standard deviation of each coordinate
};

std::vector<Sampling> samplings() {
  return {{400e3, 0}, {400e3, 0.5e-3}, {400e3, 1e-3}, {1500e3, 0}, {1500e3, 1e-3}};
}

std::string describe(const Sampling& s) {
  return std::to_string(s.density * 1e-3) + "k points per m^2, noise " + std::to_string(s.noise * 1e3) + " mm";
}

int points_on(double area, const Sampling& s) {
  return static_cast<int>(area * s.density);
}

/// A rigid motion that puts the origin 0.7 m before the viewpoint (0, 0, 0), with +x of the shape towards it.
struct Motion {
  Matrix3d R;
  Vector3d t;
  Vector3d back(const Vector3& p) const { return R.transpose() * (eigen(p) - t); }
  Vector3d back_direction(const Vector3& d) const { return R.transpose() * eigen(d); }
};

Motion random_motion(Random& random) {
  const Matrix3d R = random.rotation();
  return {R, -0.7 * R.col(0)};
}

/// Localizes points of a shape after the motion.
Result localize(const FloatPoints& shape, const Motion& motion, Options options = test::paper_options()) {
  const FloatPoints points = test::transformed(shape, motion.R, motion.t);
  CloudView view;
  view.data = points.data()->data();
  view.width = static_cast<std::uint32_t>(points.size());
  options.samples = 2000;
  return Localizer(options).localize(view);
}

double degrees(double radians) {
  return radians * 180 / M_PI;
}

/// Angle between two undirected axes (degrees).
double angle_between(const Vector3d& a, const Vector3d& b) {
  return degrees(std::acos(std::min(1.0, std::abs(a.normalized().dot(b.normalized())))));
}

std::string funnel(const Result& r) {
  const Funnel& f = r.funnel;
  return "samples " + std::to_string(f.samples) + ", too few points " + std::to_string(f.too_few_points) + ", flat " +
         std::to_string(f.flat) + ", curvature low " + std::to_string(f.curvature_low) + ", no gap " +
         std::to_string(f.no_gap) + ", shell empty " + std::to_string(f.shell_empty) + ", affordances " +
         std::to_string(f.affordances) + ", not aligned " + std::to_string(f.not_aligned) + ", too short " +
         std::to_string(f.too_short) + ", low confidence " + std::to_string(f.low_confidence);
}

// ---- What can be held -----------------------------------------------------------------------------------------------

/// How far off (m) the paper's circle is that gets the true axis and the neighbourhood of (radius, 0, 0). An algebraic
/// fit of a short noisy arc is too small: 29 mm instead of 34 with 1 mm of noise, and more points do not help.
double algebraic_error(const FloatPoints& cylinder, double radius) {
  const Vector3d sample(radius, 0, 0);
  std::vector<Vector3d> neighbourhood;
  for (const Vector3d& p : test::to_double(cylinder)) {
    if ((p - sample).norm() <= test::paper_options().effective_radius().front()) neighbourhood.push_back(p - sample);
  }
  return std::abs(reference::fit_circle(neighbourhood, Vector3d::UnitZ()).radius - radius);
}

TEST(Simulated, CylinderInFreeSpaceIsOneHandle) {
  constexpr double kLength = 0.15;
  Random random(11);
  for (const double radius : {0.010, 0.015, 0.025, 0.034}) {
    for (const Sampling& s : samplings()) {
      for (const double arc : {2 * M_PI, 0.8 * M_PI}) {  // from all around, and as one camera sees it
        SCOPED_TRACE("radius " + std::to_string(radius) + ", arc " + std::to_string(degrees(arc)) + ", " + describe(s));
        const Motion motion = random_motion(random);
        const int n = points_on(arc * radius * kLength, s);
        const FloatPoints cylinder = test::cylinder(random, n, radius, kLength, s.noise, arc);
        const double algebraic = algebraic_error(cylinder, radius);
        const Result result = localize(cylinder, motion);
        ASSERT_EQ(result.handles.size(), 1u) << funnel(result);
        const Handle& handle = result.handles[0];
        const Vector3d center = motion.back(handle.center);
        EXPECT_NEAR(handle.radius, radius, 0.001 + algebraic);
        // Half as much again: neighbourhoods at the ends of the arc hold a shorter arc.
        EXPECT_LT(center.head<2>().norm(), 0.001 + 1.5 * algebraic);
        EXPECT_LT(std::abs(center.z()), 0.02);
        EXPECT_LT(angle_between(motion.back_direction(handle.axis), Vector3d::UnitZ()), 4);
        EXPECT_GT(handle.length, 0.6 * kLength);
        EXPECT_LT(handle.length, 1.2 * kLength);
        EXPECT_GE(handle.confidence, 0.5);
        EXPECT_LE(handle.confidence, 1);
      }
    }
  }
}

TEST(Simulated, TorusIsHeldAlongItsTube) {
  constexpr double kRing = 0.06, kTube = 0.010;
  Random random(12);
  for (const Sampling& s : samplings()) {
    SCOPED_TRACE(describe(s));
    const Motion motion = random_motion(random);
    const int n = points_on(4 * M_PI * M_PI * kRing * kTube, s);
    const Result result = localize(test::torus(random, n, kRing, kTube, s.noise), motion);
    ASSERT_GE(result.handles.size(), 2u) << funnel(result);
    for (const Handle& handle : result.handles) {
      const Vector3d center = motion.back(handle.center);
      // An axis is straight and the tube is not: a handle of half length 20 mm cuts the corner by 3.5 mm.
      EXPECT_NEAR(center.head<2>().norm(), kRing, 0.005);
      EXPECT_NEAR(center.z(), 0, 0.003);
      const Vector3d tangent(-center.y(), center.x(), 0);
      EXPECT_LT(angle_between(motion.back_direction(handle.axis), tangent), 12);
      EXPECT_NEAR(handle.radius, kTube, 0.003);
    }
  }
}

TEST(Simulated, ConeIsHeldWithTheRadiusOfItsHeight) {
  constexpr double kSlope = 0.1, kFrom = 0.12, kTo = 0.26;
  Random random(13);
  for (const Sampling& s : samplings()) {
    SCOPED_TRACE(describe(s));
    const Motion motion = random_motion(random);
    const double slant = std::sqrt(1 + kSlope * kSlope);
    const int n = points_on(M_PI * kSlope * slant * (kTo * kTo - kFrom * kFrom), s);
    const Result result = localize(test::cone(random, n, kSlope, kFrom, kTo, s.noise), motion);
    ASSERT_GE(result.handles.size(), 1u) << funnel(result);
    for (const Handle& handle : result.handles) {
      const Vector3d center = motion.back(handle.center);
      EXPECT_LT(center.head<2>().norm(), 0.004);
      EXPECT_GT(center.z(), kFrom);
      EXPECT_LT(center.z(), kTo);
      // Least curvature runs along the generator, 5.7 degrees off the cone's axis.
      EXPECT_LT(angle_between(motion.back_direction(handle.axis), Vector3d::UnitZ()), 8);
      EXPECT_NEAR(handle.radius, kSlope * center.z(), 0.003);
    }
  }
}

TEST(Simulated, TwoCylindersAreTwoHandles) {
  Random random(14);
  const Motion motion = random_motion(random);
  const Sampling s = {800e3, 0.5e-3};
  const int n = points_on(2 * M_PI * 0.015 * 0.12, s);
  FloatPoints points = test::cylinder(random, n, 0.015, 0.12, s.noise);
  const FloatPoints other =
      test::transformed(test::cylinder(random, n, 0.015, 0.12, s.noise), Matrix3d::Identity(), Vector3d(0, 0.12, 0));
  points = test::joined(points, other);
  const Result result = localize(points, motion);
  ASSERT_EQ(result.handles.size(), 2u) << funnel(result);
  const double y0 = motion.back(result.handles[0].center).y(), y1 = motion.back(result.handles[1].center).y();
  EXPECT_NEAR(std::min(y0, y1), 0, 0.003);
  EXPECT_NEAR(std::max(y0, y1), 0.12, 0.003);
}

TEST(Simulated, HandsDifferInWhatTheyCanHold) {
  Random random(15);
  const Motion motion = random_motion(random);
  const Sampling s = {800e3, 0};
  const FloatPoints rod = test::cylinder(random, points_on(2 * M_PI * 0.02 * 0.15, s), 0.02, 0.15);
  Options narrow;
  narrow.hand_aperture = 0.035;
  EXPECT_TRUE(localize(rod, motion, narrow).handles.empty()) << "40 mm do not go into 35 mm";
  Options coarse;
  coarse.hand_minimum = 0.045;
  EXPECT_TRUE(localize(rod, motion, coarse).handles.empty()) << "the hand does not close on 40 mm";
  Options fitting;
  fitting.hand_aperture = 0.05;
  fitting.hand_minimum = 0.035;
  EXPECT_EQ(localize(rod, motion, fitting).handles.size(), 1u);
}

// ---- What cannot ----------------------------------------------------------------------------------------------------

TEST(Simulated, NothingToHoldOnAPlaneABallOrAWideCylinder) {
  Random random(16);
  for (const Sampling& s : samplings()) {
    SCOPED_TRACE(describe(s));
    const Motion motion = random_motion(random);
    const Result plane = localize(test::plane(random, points_on(0.09, s), 0.3, s.noise), motion);
    EXPECT_EQ(plane.status, Status::kOk);
    EXPECT_TRUE(plane.handles.empty()) << funnel(plane);
    const Result ball = localize(test::sphere(random, points_on(4 * M_PI * 0.07 * 0.07, s), 0.07, s.noise), motion);
    EXPECT_TRUE(ball.handles.empty()) << funnel(ball);
    const Result drum =
        localize(test::cylinder(random, points_on(2 * M_PI * 0.06 * 0.15, s), 0.06, 0.15, s.noise), motion);
    EXPECT_TRUE(drum.handles.empty()) << funnel(drum);
  }
}

TEST(Simulated, FullShellRefusesARodThatLiesOnATable) {
  Random random(17);
  const Sampling s = {800e3, 0.5e-3};
  const Motion motion = random_motion(random);
  const FloatPoints rod = test::cylinder(random, points_on(2 * M_PI * 0.015 * 0.15, s), 0.015, 0.15, s.noise);
  // The plane z = 0 turned to x = -15 mm, below the rod as seen from the viewpoint.
  Matrix3d R;
  R << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const FloatPoints table = test::transformed(test::plane(random, points_on(0.09, s), 0.3, s.noise), R, {-0.015, 0, 0});
  Options paper;
  paper.method = Method::kPaper;
  EXPECT_EQ(localize(rod, motion, paper).handles.size(), 1u);
  const Result result = localize(test::joined(rod, table), motion, paper);
  EXPECT_TRUE(result.handles.empty());
  EXPECT_GT(result.funnel.no_gap, 0) << funnel(result);
}

TEST(Simulated, FunnelAccountsForEverySample) {
  Random random(18);
  const Sampling s = {800e3, 0.5e-3};
  const Motion motion = random_motion(random);
  FloatPoints points = test::cylinder(random, points_on(2 * M_PI * 0.015 * 0.15, s), 0.015, 0.15, s.noise);
  points = test::joined(points, test::transformed(test::plane(random, points_on(0.09, s), 0.3, s.noise),
                                                  Matrix3d::Identity(), Vector3d(0, 0, 0.25)));
  const Result result = localize(points, motion);
  const Funnel& f = result.funnel;
  EXPECT_EQ(f.samples, 2000);
  EXPECT_EQ(f.affordances, static_cast<std::int64_t>(result.affordances.size()));
  EXPECT_EQ(f.not_aligned + f.too_short + f.low_confidence + f.in_handles, f.affordances);
}

// ---- The demonstration scene ----------------------------------------------------------------------------------------

/// Near enough to its part for a hand to close on it: 20 mm beyond its ends, half its radius and 10 mm off its axis.
bool matches(const Handle& handle, const sensor::Part& part) {
  const Vector3d d = eigen(handle.center) - eigen(part.center);
  const double along = d.dot(eigen(part.axis));
  const double across = std::sqrt(std::max(0.0, d.squaredNorm() - along * along));
  return std::abs(along) <= part.length / 2 + 0.020 && across <= part.radius / 2 + 0.010 &&
         std::abs(eigen(handle.axis).dot(eigen(part.axis))) >= 0.8 &&
         std::abs(handle.radius - part.radius) <= std::max(0.005, 0.4 * part.radius);
}

/// Distance (m) to a horizontal circle about a point of the scene.
double distance_to_rim(const Vector3d& p, const Vector3d& center, double radius) {
  return std::hypot((p - center).head<2>().norm() - radius, p.z() - center.z());
}

TEST(Simulated, DemonstrationSceneGivesItsGraspableParts) {
  const sensor::Scene scene = sensor::table_scene();
  const sensor::Pose T_world_camera = sensor::table_scene_camera();
  const Vector3d mug_rim(0.16, -0.08, 0.105), bowl_rim(0.03, 0.08, 0.055);
  for (const sensor::CameraOptions& options : {sensor::CameraOptions{}, sensor::table_scene_camera_options()}) {
    SCOPED_TRACE(options.noise.axial_sigma > 0 ? "with noise" : "without noise");
    const sensor::DepthCamera camera(options);
    const std::vector<sensor::Part> truth = camera.truth(scene, T_world_camera);
    const Result result = Localizer(test::paper_options()).localize(camera.capture(scene, T_world_camera).cloud.view());
    std::set<std::string> found;
    for (const Handle& handle : result.handles) {
      bool right = false;
      for (const sensor::Part& part : truth) {
        if (!matches(handle, part)) continue;
        found.insert(part.what);
        right = true;
      }
      // A sliver of a rim with unobserved space beside it looks like a rod to the paper's conditions. Nothing else may.
      const Vector3d center = eigen(T_world_camera.point(handle.center));
      const double to_rim =
          std::min(distance_to_rim(center, mug_rim, 0.039), distance_to_rim(center, bowl_rim, 0.0675));
      EXPECT_TRUE(right || to_rim < handle.radius + 0.010)
          << "a handle at nothing: " << center.transpose() << " m in the scene, radius " << handle.radius;
    }
    for (const sensor::Part& part : truth) {
      if (part.graspable) {
        EXPECT_EQ(found.count(part.what), 1u) << "missed: " << part.what << "; " << funnel(result);
      }
    }
  }
}

}  // namespace
}  // namespace handhold
