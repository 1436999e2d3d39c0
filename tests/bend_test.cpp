// Where the depth image shows at once that there is nothing to hold.
#include "bend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "image_of.h"

namespace handhold {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kFocal = 575, kReach = 0.05;

/// Depth along the ray (x, y, 1); NaN: nothing.
using FloatPoints = test::FloatPoints;
using Scene = std::function<double(double, double)>;

FloatPoints points_of(const Scene& depth, double noise = 0) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  FloatPoints points;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double x = (u - 79.5) / kFocal, y = (v - 59.5) / kFocal, z = depth(x, y) + noise * normal(random);
      points.emplace_back(static_cast<float>(z * x), static_cast<float>(z * y), static_cast<float>(z));
    }
  }
  return points;
}

/// Share of the pixels at least `border` from the image's border that bend.
double share(const Scene& depth, double noise = 0, int border = 26) {
  const FloatPoints points = points_of(depth, noise);
  const DepthImage image = test::image_of(points, kWidth, kHeight);
  double all = 0, bent = 0;
  for (int v = border; v < kHeight - border; ++v) {
    for (int u = border; u < kWidth - border; ++u) {
      const auto& p = points[static_cast<std::size_t>(v * kWidth + u)];
      if (!std::isfinite(p[2])) continue;
      all += 1;
      bent += bends(image, {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}, kReach);
    }
  }
  return bent / all;
}

/// Depth of a cylinder with an axis across the line of sight at depth z, tilted in the image; `inside`: its far side.
Scene cylinder(double z, double radius, double angle, double back, bool inside = false) {
  return [=](double x, double y) {
    const double t = -x * std::sin(angle) + y * std::cos(angle);  // across the axis, at depth 1
    // (d t)^2 + (d - z)^2 = radius^2
    const double a = t * t + 1, b = -2 * z, c = z * z - radius * radius, q = b * b - 4 * a * c;
    if (q < 0) return back;
    return (-b + (inside ? std::sqrt(q) : -std::sqrt(q))) / (2 * a);
  };
}
Scene plane(double z, double slope_x, double slope_y) {
  return [=](double x, double y) { return z / (1 - slope_x * x - slope_y * y); };
}

TEST(Bends, NotOnPlanesWhateverTheirSlant) {
  EXPECT_EQ(share(plane(0.8, 0, 0)), 0);
  EXPECT_EQ(share(plane(0.8, 1.5, 0)), 0);
  EXPECT_EQ(share(plane(0.6, -1, 2), 0, 40), 0);
  EXPECT_LT(share(plane(0.8, 0.5, 1), depth_noise(0.8)), 0.1) << "noise";
}

TEST(Bends, OnEveryPartThatTheHandHolds) {
  for (const double radius : {0.004, 0.01, 0.02, 0.03, 0.04}) {
    for (const double angle : {0.0, 0.4, 0.8, 1.6}) {
      // Of the pixels some are of what lies behind, which bends nowhere but beside the part.
      const Scene scene = cylinder(0.7, radius, angle, std::numeric_limits<double>::quiet_NaN());
      EXPECT_EQ(share(scene), 1) << radius << " " << angle;
      EXPECT_GT(share(scene, 0.5 * depth_noise(0.7)), 0.95) << radius << " " << angle;
    }
  }
}

TEST(Bends, NotInHollows) {
  EXPECT_EQ(share(cylinder(0.7, 0.15, 0.3, 0.7, true)), 0);
}

TEST(Bends, OnTheEdgeOfABoxAndNotOnItsSides) {
  // Two planes that meet in an edge towards the sensor.
  const Scene scene = [](double x, double) { return 0.7 / (1 - std::fabs(x)); };
  const FloatPoints points = points_of(scene);
  const DepthImage image = test::image_of(points, kWidth, kHeight);
  const auto at = [&](int u) {
    const auto& p = points[static_cast<std::size_t>(60 * kWidth + u)];
    return bends(image, {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}, kReach);
  };
  EXPECT_TRUE(at(80));
  EXPECT_FALSE(at(40));
  EXPECT_FALSE(at(120));
}

TEST(Bends, WhatTheImageDoesNotShowIsLookedAt) {
  const FloatPoints points = points_of(plane(0.8, 0, 0));
  const DepthImage image = test::image_of(points, kWidth, kHeight);
  EXPECT_FALSE(bends(image, {0, 0, 0.8}, kReach));
  EXPECT_TRUE(bends(image, {0, 0, 0.9}, kReach)) << "hidden";
  EXPECT_TRUE(bends(image, {0, 0, -0.8}, kReach)) << "behind the sensor";
  EXPECT_TRUE(bends(image, {5, 0, 0.8}, kReach)) << "outside of the image";
  EXPECT_TRUE(bends(image, {0, 0, std::numeric_limits<double>::quiet_NaN()}, kReach));
}

}  // namespace
}  // namespace handhold
