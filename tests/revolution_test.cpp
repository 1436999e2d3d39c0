// The axis of bottles and cans with caps, whose radius is not one number.
#include "revolution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "image_of.h"
#include "index.h"
#include "part_points.h"
#include "tiles.h"

namespace handhold {
namespace {

constexpr double kSlice = 0.005, kLow = -0.06, kDepth = 0.7;
constexpr std::size_t kSlices = 24;
const Vector3 kAxis = normalized({0.9, 0.2, 0.4}), kPoint = {0.01, -0.02, kDepth};

/// Points of the side that a camera at the origin sees of a surface of revolution about the line through kPoint.
test::FloatPoints seen_of(const std::function<double(double)>& radius, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> along(-0.06, 0.06), turn(-1.3, 1.3);
  const Vector3 ahead = normalized(-1.0 * kPoint + dot(kPoint, kAxis) * kAxis), side = cross(kAxis, ahead);
  test::FloatPoints points;
  for (int i = 0; i < 640 * 2; ++i) {
    const double h = along(random), angle = turn(random);
    Vector3 p = kPoint + h * kAxis + radius(h) * (std::cos(angle) * ahead + std::sin(angle) * side);
    p = (1 + noise * normal(random) / norm(p)) * p;
    points.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]));
  }
  return points;
}

struct Outcome {
  bool moved = true;
  double tilt = 0, offset = 0;  ///< rad, m; of the axis, from the true one
};

/// Starts from an axis that is tilted by 4 degrees in depth and 2 mm beside.
Outcome fit(const test::FloatPoints& points, double radius, int steps) {
  CloudView view;
  view.data = points.data()->data();
  view.width = static_cast<std::uint32_t>(points.size()), view.height = 1;
  view.viewpoint = Vector3{0, 0, 0};
  TileStore tiles;
  tiles.build(view);
  const auto index = make_index(IndexKind::kGrid);
  index->build(tiles);
  DepthImage image;
  EXPECT_TRUE(image.build(view));
  const double sigma = depth_noise(kDepth);
  PartPoints part;
  part.begin(tiles, *index, image, false);
  Cylinder c;
  c.axis = normalized(kAxis + 0.07 * normalized(kPoint - dot(kPoint, kAxis) * kAxis));
  c.point = kPoint + Vector3{0, 0.002, 0};
  c.radius = radius;
  part.gather(c, kLow, kLow + kSlice * kSlices, sigma);
  std::vector<RevolutionSums> scratch;
  Outcome o;
  for (int i = 0; i < steps; ++i) {
    part.select(c, kLow, kLow + kSlice * kSlices);
    o.moved &= step_axis_of_revolution(part, kLow, kSlice, kSlices, sigma, scratch, c);
  }
  EXPECT_EQ(c.radius, radius);
  EXPECT_NEAR(norm(c.axis), 1, 1e-12);
  o.tilt = std::acos(std::min(1.0, std::fabs(dot(c.axis, kAxis))));
  o.offset = norm(c.across(kPoint));
  return o;
}

TEST(Revolution, FindsTheAxisWhateverTheProfile) {
  const std::function<double(double)> profiles[] = {
      [](double) { return 0.028; },                               // a can
      [](double h) { return h < 0.02 ? 0.030 : 0.024; },          // with a cap
      [](double h) { return 0.027 + 0.004 * std::sin(60 * h); },  // a vase
      [](double h) { return 0.028 + 0.05 * h; },                  // a cup
  };
  for (const auto& profile : profiles) {
    const Outcome start = fit(seen_of(profile, 0, 1), 0.028, 0);
    EXPECT_GT(start.tilt, 0.06);
    const Outcome exact = fit(seen_of(profile, 0, 1), 0.028, 6);
    EXPECT_TRUE(exact.moved);
    // Points between two slices' middles stand for a slope within the slice, which a tilt explains a little, too.
    EXPECT_LT(exact.tilt, 0.006);
    EXPECT_LT(exact.offset, 0.0005);
    for (unsigned seed = 2; seed < 7; ++seed) {
      const Outcome noisy = fit(seen_of(profile, depth_noise(kDepth), seed), 0.028, 6);
      EXPECT_LT(noisy.tilt, 0.02) << seed;
      EXPECT_LT(noisy.offset, 0.0015) << seed;
    }
  }
}

TEST(Revolution, TooFewPointsMoveNothing) {
  test::FloatPoints few = seen_of([](double) { return 0.028; }, 0, 1);
  few.resize(12);
  const Outcome o = fit(few, 0.028, 1);
  EXPECT_FALSE(o.moved);
  EXPECT_EQ(o.tilt, fit(few, 0.028, 0).tilt);
}

TEST(Revolution, OneShortRingStaysNearItsStart) {
  // Three slices: nothing but the prior holds the tilt.
  const auto points = seen_of([](double h) { return std::fabs(h) < 0.0074 ? 0.028 : 0.3; }, 0.001, 3);
  const Outcome o = fit(points, 0.028, 4);
  EXPECT_LT(o.tilt, 0.35);
  EXPECT_TRUE(std::isfinite(o.offset));
}

}  // namespace
}  // namespace handhold
