// Thin parts that are followed around their bends.
#include "bow.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "bow_groups.h"
#include "image_of.h"

namespace handhold {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal = 300, kPart = 0.8, kPixel = kPart / kFocal, kPi = 3.14159265358979324;

/// What a camera at the origin sees: depth(x, y) where the plane z = kPart is at (x, y) (m).
template <class Depth>
DepthImage image_of(const Depth& depth) {
  test::FloatPoints points;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const double x = (u - 159.5) / kFocal, y = (v - 119.5) / kFocal;
      points.push_back((depth(x * kPart, y * kPart) * Eigen::Vector3d(x, y, 1)).template cast<float>());
    }
  return test::image_of(points, kWidth, kHeight);
}

/// A flat band of that radius and half width about the origin, from angle `from` to `to` (rad), before a wall.
auto arc(double radius, double half, double from, double to) {
  return [=](double x, double y) {
    const double angle = std::atan2(y, x);
    const bool on = std::fabs(std::hypot(x, y) - radius) < half && angle >= from && angle <= to;
    return on ? kPart : kPart + 0.15;
  };
}

/// On the band, at that angle, along it.
Cylinder start(double radius, double half, double angle) {
  return {
      {radius * std::cos(angle), radius * std::sin(angle), kPart + half}, {-std::sin(angle), std::cos(angle), 0}, half};
}

TEST(Bow, AnArcIsFollowedFromEndToEnd) {
  for (const double radius : {0.04, 0.06, 0.1}) {
    for (const double at : {0.4, 1.5, 2.6}) {
      SCOPED_TRACE(testing::Message() << radius << ' ' << at);
      BowScratch scratch;
      Bow bow;
      ASSERT_TRUE(trace_bow(image_of(arc(radius, 0.008, 0.1, 3.0)), start(radius, 0.008, at), 0.001, scratch, bow));
      EXPECT_FALSE(bow.closed);
      // Wider ones may look straight over 60 mm, at this resolution.
      if (radius < 0.08) {
        EXPECT_TRUE(bow.curved());
      }
      EXPECT_NEAR(bow.length, 2.9 * radius, 0.1 * 2.9 * radius + 0.012);
      EXPECT_NEAR(bow.turn, bow.length / radius, 0.35 * bow.length / radius);
      // At its very ends it may turn towards their corners.
      for (std::size_t i = 3; i + 3 < bow.path.size(); ++i) {
        EXPECT_NEAR(std::hypot(bow.path[i][0], bow.path[i][1]), radius, 1.2 * kPixel);
        EXPECT_NEAR(bow.path[i][2], kPart, 0.002);
        EXPECT_NEAR(bow.widths[i], 0.016, 2.5 * kPixel);
      }
      const std::size_t middle = bow.path.size() / 2;
      const Vector3 p = bow.path[middle];
      EXPECT_LT(std::fabs(dot(bow.tangent(middle), normalized(Vector3{p[0], p[1], 0}))), 0.3) << "along the arc";
    }
  }
}

TEST(Bow, ACornerIsTurned) {
  // Upright from below to the middle, then up to the right at 45 degrees.
  const double half = 0.008;
  const auto near = [&](double x, double y, double ax, double ay, double bx, double by) {
    const double dx = bx - ax, dy = by - ay;
    const double t = std::min(1.0, std::max(0.0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)));
    return std::hypot(x - ax - t * dx, y - ay - t * dy) < half;
  };
  const DepthImage image = image_of([&](double x, double y) {
    return near(x, y, 0, 0.08, 0, 0) || near(x, y, 0, 0, 0.06, -0.06) ? kPart : kPart + 0.15;
  });
  BowScratch scratch;
  Bow bow;
  ASSERT_TRUE(trace_bow(image, {{0, 0.05, kPart + half}, {0, 1, 0}, half}, 0.001, scratch, bow));
  EXPECT_GT(bow.length, 0.14);
  EXPECT_GT(std::max(bow.path.front()[0], bow.path.back()[0]), 0.045);
  EXPECT_GT(bow.turn, 0.5);
}

TEST(Bow, ARingClosesAndARodIsStraight) {
  BowScratch scratch;
  Bow bow;
  ASSERT_TRUE(trace_bow(image_of(arc(0.06, 0.008, -4, 4)), start(0.06, 0.008, 1), 0.001, scratch, bow));
  EXPECT_TRUE(bow.closed);
  const DepthImage rod = image_of([](double x, double) { return std::fabs(x) < 0.01 ? kPart : kPart + 0.15; });
  ASSERT_TRUE(trace_bow(rod, {{0, 0, kPart + 0.01}, {0, 1, 0}, 0.01}, 0.001, scratch, bow));
  EXPECT_FALSE(bow.curved());
  EXPECT_LT(bow.turn, 2 * bow.length) << "a bow of 50 mm radius turns 20 rad a metre; here only pixels do";
}

TEST(Bow, IsNoneOnASurfaceOrWhereItIsThickOrNothingIsSeen) {
  BowScratch scratch;
  Bow bow;
  EXPECT_FALSE(trace_bow(image_of([](double, double) { return kPart; }), start(0.06, 0.008, 1), 0.001, scratch, bow));
  EXPECT_FALSE(trace_bow(image_of(arc(0.06, 0.025, 0, 3)), start(0.06, 0.025, 1), 0.001, scratch, bow)) << "5 cm wide";
  const DepthImage image = image_of(arc(0.06, 0.008, 0, 3));
  EXPECT_FALSE(trace_bow(image, start(0.06, 0.008, -1), 0.001, scratch, bow)) << "beside it";
  EXPECT_FALSE(trace_bow(image, {{0, 0, -1}, {0, 1, 0}, 0.008}, 0.001, scratch, bow)) << "behind the camera";
  const double nan = std::nan("");
  EXPECT_FALSE(trace_bow(image, {{nan, nan, nan}, {0, 1, 0}, 0.008}, 0.001, scratch, bow));
  EXPECT_TRUE(bow.path.empty());
}

TEST(BowGroups, ABowIsOneGroupAboutItsMiddle) {
  const DepthImage image = image_of(arc(0.06, 0.008, 0.1, 3.0));
  std::vector<Affordance> affordances;
  for (double angle = 0.3; angle < 2.9; angle += 0.1) {
    const Cylinder c = start(0.06, 0.008, angle);
    Affordance a{};
    a.center = c.point, a.axis = c.axis, a.radius = c.radius, a.quality = 1;
    affordances.push_back(a);
  }
  Recycled<PartGroup> groups;
  Recycled<Bow> bows;
  BowSearch().run(affordances, image, groups, bows);
  ASSERT_EQ(groups.size(), 1u);
  ASSERT_EQ(bows.size(), 1u);
  EXPECT_EQ(groups[0].bow, &bows[0]);
  EXPECT_NEAR(std::atan2(groups[0].mean.point[1], groups[0].mean.point[0]), 1.55, 0.15);
  EXPECT_NEAR(groups[0].mean.radius, 0.008, kPixel);
  EXPECT_FALSE(groups[0].members.empty());
  EXPECT_LT(groups[0].members.size(), affordances.size()) << "the others lie around the bend";

  Handle handle{}, piece{};
  handle.path = bows[0].path, handle.radius = piece.radius = 0.008;
  const Cylinder on = start(0.06, 0.008, 0.5);
  piece.center = on.point, piece.axis = on.axis;
  EXPECT_TRUE(of_bow(handle, piece));
  piece.axis = normalized(Vector3{on.point[0], on.point[1], 0});
  EXPECT_FALSE(of_bow(handle, piece)) << "across the bow";
  piece.axis = on.axis, piece.radius = 0.02;
  EXPECT_FALSE(of_bow(handle, piece)) << "thicker";
  piece.radius = 0.008, piece.center = {0, 0, kPart};
  EXPECT_FALSE(of_bow(handle, piece)) << "beside it";
  piece.center = on.point, piece.length = 0.02;
  EXPECT_TRUE(of_bow(handle, piece));
  piece.length = 0.12;
  EXPECT_FALSE(of_bow(handle, piece)) << "most of it is straight on";
}

TEST(Bow, IsTangledWhereItComesBackToItself) {
  BowScratch scratch;
  Bow bow;
  EXPECT_FALSE(bow.tangled(0.02));
  // Round and round on a circle of 15 mm, and the same as a spiral whose turns are 30 mm apart.
  Bow spiral;
  for (int k = 0; k < 40; ++k) {
    const double angle = k * kBowStep / 0.015, r = 0.015 + 0.030 * angle / (2 * kPi);
    bow.path.push_back({0.015 * std::cos(angle), 0.015 * std::sin(angle), kPart});
    spiral.path.push_back({r * std::cos(angle), r * std::sin(angle), kPart});
  }
  EXPECT_TRUE(bow.tangled(0.01));
  EXPECT_FALSE(spiral.tangled(0.01));
  bow.path.resize(12);
  EXPECT_FALSE(bow.tangled(0.01)) << "half a turn";
}

}  // namespace
}  // namespace handhold
