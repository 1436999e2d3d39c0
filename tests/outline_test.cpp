// Where parts end in the depth image, and straps found by it.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "depth_image.h"
#include "image_of.h"
#include "ribbon.h"
#include "silhouette.h"

namespace handhold {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal = 300, kPart = 0.8;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// What a camera at the origin sees: depth(x, y) along the rays (x, y, 1).
template <class Depth>
DepthImage image_of(const Depth& depth) {
  test::FloatPoints points;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const double x = (u - 159.5) / kFocal, y = (v - 119.5) / kFocal;
      points.push_back((depth(x, y) * Eigen::Vector3d(x, y, 1)).template cast<float>());
    }
  return test::image_of(points, kWidth, kHeight);
}

/// A flat strap, `half` (m) wide on either side, upright or turned by `angle` (rad) in the image, before a wall.
auto strap(double half, double behind, double angle = 0) {
  return [=](double x, double y) {
    const double across = std::cos(angle) * x + std::sin(angle) * y;
    return std::fabs(across * kPart) < half ? kPart : kPart + behind;
  };
}

constexpr Vector3 kPlace = {0, 0, kPart}, kRight = {1, 0, 0}, kAhead = {0, 0, -1};

TEST(Silhouette, AStepEndsAPart) {
  const DepthImage image = image_of(strap(0.02, 0.1));
  for (const double way : {1.0, -1.0}) {
    const SilhouetteSide side = silhouette_side(image, kPlace, way * kRight, kAhead, 0.05, 0.001);
    EXPECT_EQ(side.kind, SilhouetteSide::kStep);
    EXPECT_NEAR(side.at, 0.02, kPart / kFocal) << "to the pixel";
  }
}

TEST(Silhouette, BehindABarItFallsAtOnceAndBesideAWallByAndBy) {
  const SilhouetteSide bar = silhouette_side(image_of(strap(0.02, 0.1)), kPlace, kRight, kAhead, 0.05, 0.001);
  for (const double fall : bar.fall) EXPECT_NEAR(fall, 0.1, 1e-4);
  // A wall's edge 20 mm to the right; its side, seen at a grazing angle, recedes by 8 m a metre.
  const DepthImage image = image_of([](double x, double) {
    const double beyond = x * kPart - 0.02;
    return beyond < 0 ? kPart : kPart + 8 * beyond;
  });
  const SilhouetteSide wall = silhouette_side(image, kPlace, kRight, kAhead, 0.05, 0.001);
  ASSERT_EQ(wall.kind, SilhouetteSide::kStep);
  EXPECT_NEAR(wall.fall[1] - wall.fall[0], 8 * (0.004 - kPart / kFocal), 8 * 0.6 * kPart / kFocal);
  EXPECT_NEAR(wall.fall[2] - wall.fall[1], 8 * 0.008, 8 * 1.1 * kPart / kFocal);
}

TEST(Silhouette, WithoutAStepASurfaceGoesOn) {
  const auto kind = [](double behind) {
    return silhouette_side(image_of(strap(0.02, behind)), kPlace, kRight, kAhead, 0.05, 0.001).kind;
  };
  EXPECT_EQ(kind(0), SilhouetteSide::kSurface) << "a wall";
  EXPECT_EQ(kind(0.005), SilhouetteSide::kSurface) << "less than 3 mm and three standard deviations";
  EXPECT_EQ(kind(0.007), SilhouetteSide::kStep);
}

TEST(Silhouette, WhatStandsInFrontHides) {
  const DepthImage image = image_of([](double x, double) { return x * kPart > 0.02 ? kPart - 0.1 : kPart; });
  const SilhouetteSide side = silhouette_side(image, kPlace, kRight, kAhead, 0.05, 0.001);
  EXPECT_EQ(side.kind, SilhouetteSide::kHidden);
  EXPECT_NEAR(side.at, 0.02, kPart / kFocal);
  EXPECT_EQ(silhouette_side(image, {0, 0, kPart - 0.05}, kRight, kAhead, 0.05, 0.001).kind, SilhouetteSide::kHidden)
      << "the place is not on what is seen";
  EXPECT_EQ(silhouette_side(image, {0, 0, -1}, kRight, kAhead, 0.05, 0.001).kind, SilhouetteSide::kHidden)
      << "behind the camera";
}

TEST(Silhouette, ASlantedPartIsNoRowOfSteps) {
  // A wall that recedes by two metres for each to the right of its axis' image: along its axis, not across it.
  const double slope = 2;
  const DepthImage image = image_of([&](double, double y) { return kPart / (1 - slope * y); });
  const Vector3 ahead = normalized(Vector3{0, slope, -1});
  EXPECT_EQ(silhouette_side(image, kPlace, kRight, ahead, 0.05, 0.001).kind, SilhouetteSide::kSurface);
}

TEST(Ribbon, FindsAStrapWhicheverWayItRuns) {
  for (const double angle : {0.0, 0.3, 0.8, 1.5707963267948966, 2.5}) {
    SCOPED_TRACE(angle);
    const DepthImage image = image_of(strap(0.008, 0.1, angle));
    Cylinder found;
    ASSERT_TRUE(find_ribbon(image, kPlace, found));
    EXPECT_NEAR(found.radius, 0.008, 0.6 * kPart / kFocal);
    EXPECT_GT(std::fabs(-std::sin(angle) * found.axis[0] + std::cos(angle) * found.axis[1]), 0.98);
    EXPECT_NEAR(found.point[2], kPart + found.radius, 0.001) << "the axis is a radius behind the surface";
    EXPECT_LT(std::hypot(found.point[0], found.point[1]), kPart / kFocal);
  }
}

TEST(Ribbon, IsNoneWhereItIsTooWideOrShortOrNotRaised) {
  Cylinder found;
  EXPECT_FALSE(find_ribbon(image_of(strap(0.02, 0.1)), kPlace, found)) << "wider than 30 mm";
  EXPECT_FALSE(find_ribbon(image_of(strap(0.008, 0.004)), kPlace, found)) << "a step within the noise";
  EXPECT_FALSE(find_ribbon(image_of(strap(0.008, 0)), kPlace, found)) << "a wall";
  EXPECT_FALSE(
      find_ribbon(image_of([](double x, double y) { return std::hypot(x, y) * kPart < 0.008 ? kPart : kPart + 0.1; }),
                  kPlace, found))
      << "as long as it is wide";
  EXPECT_FALSE(find_ribbon(image_of(strap(0.008, 0.1)), {0.1, 0, kPart + 0.1}, found)) << "beside it";
  EXPECT_FALSE(find_ribbon(image_of(strap(0.008, 0.1)), {kNan, kNan, kNan}, found));
  EXPECT_FALSE(find_ribbon(image_of(strap(0.008, 0.1)), {5, 5, kPart}, found)) << "out of the image";
}

TEST(DepthImage, UnprojectIsTheReverseOfProject) {
  const DepthImage image = image_of(strap(0.02, 0.1));
  const Vector3 p = {0.05, -0.03, 0.9};
  const DepthImage::Projected q = image.project(p);
  EXPECT_LT(norm(image.unproject(q.a / q.depth, q.b / q.depth, q.depth) - p), 1e-9);
}

}  // namespace
}  // namespace handhold
