// Two fingers beside a part, as far as a camera saw.
#include "fingers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "image_of.h"
#include "test_clouds.h"

namespace handhold {
namespace {

using Eigen::Vector3d;
using test::FloatPoints;

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal = 290;
constexpr double kPart = 0.8;  ///< m; depth of the part's axis

/// A bar along y in front of a wall, as a camera at the origin sees it; the wall begins `wall` (m) behind the bar's
/// axis, and a box may stand beside it: `neighbour` (m) from the axis to its edge, on the right, its face 30 mm nearer
/// to the camera than the axis.
FloatPoints scene(double radius, double wall, double neighbour = HUGE_VAL) {
  FloatPoints points;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const Vector3d ray((u - 159.5) / kFocal, (v - 119.5) / kFocal, 1);
      double depth = kPart + wall;
      if (ray.x() * kPart > neighbour && ray.x() * kPart < neighbour + 0.05) depth = std::min(depth, kPart - 0.03);
      // |x, z - kPart| = radius along depth * ray
      const double a = ray.x() * ray.x() + 1, b = kPart, c = kPart * kPart - radius * radius;
      if (b * b - a * c > 0) depth = std::min(depth, (b - std::sqrt(b * b - a * c)) / a);
      points.push_back((depth * ray).cast<float>());
    }
  return points;
}

Grip grip(const FloatPoints& points, double radius, const Options& options = {}, int angles = FingerTest::kAngles) {
  const DepthImage image = test::image_of(points, kWidth, kHeight);
  const FingerTest test(options, image);
  if (angles == 1) return test.at({0, 0, kPart}, {0, 1, 0}, radius, 0.02, 0);
  return test.any({0, 0, kPart}, {0, 1, 0}, radius, 0.02);
}

TEST(Fingers, FitAboutABarInFreeSpace) {
  for (const double radius : {0.006, 0.015, 0.03}) {
    const Grip g = grip(scene(radius, 0.5), radius);
    EXPECT_TRUE(g.fits) << radius;
    EXPECT_GE(g.free, Options().min_free);
    EXPECT_GE(g.opening, 1.4 * radius);
    EXPECT_LE(g.opening, 0.084);
    EXPECT_LT(g.from[2], -0.9) << "from the camera's side";
    EXPECT_NEAR(g.from[1], 0, 1e-9) << "across the bar";
  }
}

TEST(Fingers, DoNotFitIntoAWall) {
  Options strict;
  strict.min_free = 0.7;
  EXPECT_FALSE(grip(scene(0.015, 0.001), 0.015, strict).fits) << "half of the bar stands out of the wall";
  EXPECT_FALSE(grip(scene(0.015, -0.004), 0.015).fits) << "less than half of it does: by default a finger may touch";
  EXPECT_TRUE(grip(scene(0.015, 0.03), 0.015).fits) << "it lies on a table";
  EXPECT_TRUE(grip(scene(0.015, 0.03), 0.015, strict).fits);
}

TEST(Fingers, NeedRoomOnBothSides) {
  EXPECT_FALSE(grip(scene(0.015, 0.5, 0.017), 0.015, {}, 1).fits);
  EXPECT_TRUE(grip(scene(0.015, 0.5, 0.05), 0.015, {}, 1).fits);
}

TEST(Fingers, ObeyTheHand) {
  const FloatPoints points = scene(0.03, 0.5);
  Options small;
  small.hand_aperture = 0.045;
  EXPECT_FALSE(grip(points, 0.03, small).fits);
  Options thick;
  thick.finger_thickness = 0.03;
  EXPECT_FALSE(grip(scene(0.015, 0.5, 0.028), 0.015, thick, 1).fits);
  EXPECT_TRUE(grip(scene(0.015, 0.5, 0.028), 0.015, {}, 1).fits);
}

TEST(Fingers, MustReachAroundThePart) {
  Options shallow;
  shallow.finger_depth = 0.02;
  EXPECT_TRUE(grip(scene(0.03, 0.5), 0.03).fits);
  EXPECT_FALSE(grip(scene(0.03, 0.5), 0.03, shallow).fits) << "they end 10 mm before the bar is at its widest";
  EXPECT_TRUE(grip(scene(0.015, 0.5), 0.015, shallow).fits);
  EXPECT_TRUE(grip(scene(0.039, 0.5), 0.039, {}, 1).fits) << "up to the palm";
}

TEST(Fingers, MustBeSeenToBeFree) {
  FloatPoints points = scene(0.015, 0.5);
  // Nothing was measured right of the bar, too wide for a shadow.
  for (int v = 60; v < 180; ++v)
    for (int u = 165; u < 300; ++u) points[static_cast<std::size_t>(v * kWidth + u)].setConstant(test::kNan);
  EXPECT_FALSE(grip(points, 0.015, {}, 1).fits);
  Options trusting;
  trusting.min_free = 0;
  EXPECT_TRUE(grip(points, 0.015, trusting, 1).fits);
}

}  // namespace
}  // namespace handhold
