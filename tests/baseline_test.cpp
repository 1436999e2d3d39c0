// The classic way that the benchmarks compare with must be right, or being faster than it would mean nothing.
#include "baseline/baseline.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "paper_options.h"
#include "reference/reference.h"

namespace handhold {
namespace {

using Eigen::Vector3d;
using Samples = std::vector<std::array<float, 3>>;

Vector3d eigen(const Vector3& v) {
  return Vector3d(v.data());
}

double angle(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

// The side of a cylinder about the x axis that a camera at the origin sees, 0.7 m in front of it, and a wall 0.15 m
// behind. `noise` (m) moves points along the ray.
struct CylinderScene {
  CylinderScene(double radius_, double noise) : radius(radius_) {
    std::mt19937 random(7);
    std::normal_distribution<double> error(0, 1);
    const auto add = [&](const Vector3d& p) {
      const Vector3d q = noise > 0 ? Vector3d(p + noise * error(random) * p.normalized()) : p;
      for (int k = 0; k < 3; ++k) cloud.xyz.push_back(static_cast<float>(q[k]));
    };
    for (double x = -0.06; x <= 0.06; x += 0.001)
      for (double t = -1.4; t <= 1.4; t += 0.001 / radius) {
        add(axis_point + Vector3d(x, radius * std::sin(t), -radius * std::cos(t)));
        if (std::abs(x) < 0.05 && std::abs(t) < 0.8) {
          const float* p = &cloud.xyz[cloud.xyz.size() - 3];
          samples.push_back({p[0], p[1], p[2]});
        }
      }
    for (double x = -0.2; x <= 0.2; x += 0.002)
      for (double y = -0.2; y <= 0.2; y += 0.002) add(Vector3d(x, y, 0.85));
    for (int k = 0; k < 3; ++k) cloud.xyz.push_back(std::numeric_limits<float>::quiet_NaN());
    cloud.width = static_cast<std::uint32_t>(cloud.xyz.size() / 3);
  }

  double radius;
  Vector3d axis_point{0, 0, 0.7};
  Cloud cloud;
  Samples samples;
};

Samples every(const Samples& samples, std::size_t step) {
  Samples some;
  for (std::size_t i = 0; i < samples.size(); i += step) some.push_back(samples[i]);
  return some;
}

baseline::Settings fixed_points(baseline::Search search = baseline::Search::kKdTree) {
  baseline::Settings settings;
  settings.search = search;
  settings.curvature_points = baseline::CurvaturePoints::kFixed;
  return settings;
}

TEST(Baseline, FindsAnExactCylinder) {
  const CylinderScene scene(0.02, 0);
  const Samples samples = every(scene.samples, 101);
  ASSERT_GT(samples.size(), 20u);
  const baseline::Result result = baseline::localize(scene.cloud.view(), test::paper_options(), samples);
  ASSERT_EQ(result.samples.size(), samples.size());
  for (const baseline::SampleResult& sample : result.samples) {
    ASSERT_EQ(sample.outcome, baseline::Outcome::kAffordance) << to_string(sample.outcome);
    const Affordance& a = sample.affordance;
    const std::array<float, 3>& x = samples[a.sample];
    EXPECT_LT(angle(eigen(a.axis), Vector3d::UnitX()), 1e-3);
    EXPECT_NEAR(a.radius, 0.02, 1e-5);
    EXPECT_NEAR(a.curvature, 1 / 0.02, 0.5);
    // On the axis, at the height of the sample.
    EXPECT_LT((eigen(a.center) - (scene.axis_point + x[0] * Vector3d::UnitX())).norm(), 2e-5);
    // Every point has rho = 0.02 but for rounding, so the first step or the second one has left them all behind.
    EXPECT_GE(a.shell_radius, 0.02 - 2e-5);
    EXPECT_LE(a.shell_radius, 0.021 + 2e-5);
    EXPECT_LT(angle(eigen(a.normal), Vector3d(0, x[1], x[2]) - scene.axis_point), 1e-3);
    EXPECT_LT(a.normal[2], 0) << "towards the camera";
  }
  ASSERT_EQ(result.handles.size(), 1u);
  EXPECT_EQ(result.handles[0].affordances.size(), samples.size());
  EXPECT_NEAR(result.handles[0].radius, 0.02, 1e-5);
  EXPECT_GT(result.handles[0].length, 0.08);
}

TEST(Baseline, SaysWhyThereIsNoAffordance) {
  const CylinderScene scene(0.02, 0);
  const Samples on_cylinder = every(scene.samples, 501);
  const auto outcome = [](const CloudView& cloud, const Options& options, const Samples& samples) {
    return baseline::localize(cloud, options, samples).samples.at(0).outcome;
  };
  EXPECT_EQ(outcome(scene.cloud.view(), test::paper_options(), {{1, 1, 1}}), baseline::Outcome::kTooFewPoints);

  Options small_hand = test::paper_options();
  small_hand.hand_aperture = 0.039;
  small_hand.reach = 0.05;
  EXPECT_EQ(outcome(scene.cloud.view(), small_hand, on_cylinder), baseline::Outcome::kCircleWide);

  Options short_reach = test::paper_options();
  short_reach.reach = 0.019;
  EXPECT_EQ(outcome(scene.cloud.view(), short_reach, on_cylinder), baseline::Outcome::kCurvatureLow);

  Options large_parts = test::paper_options();
  large_parts.hand_minimum = 0.041;
  EXPECT_EQ(outcome(scene.cloud.view(), large_parts, on_cylinder), baseline::Outcome::kCircleNarrow);

  Options much_inside = test::paper_options();
  much_inside.shell_inner_area_mm2 = 1e5;
  EXPECT_EQ(outcome(scene.cloud.view(), much_inside, on_cylinder), baseline::Outcome::kShellEmpty);

  // A sheet that leaves the back of the cylinder: outside the ball, across every gap.
  Cloud with_sheet = scene.cloud;
  for (double x = -0.06; x <= 0.06; x += 0.001)
    for (double z = 0.721; z < 0.78; z += 0.001)
      with_sheet.xyz.insert(with_sheet.xyz.end(), {static_cast<float>(x), 0.0f, static_cast<float>(z)});
  with_sheet.width = static_cast<std::uint32_t>(with_sheet.xyz.size() / 3);
  EXPECT_EQ(outcome(with_sheet.view(), test::paper_options(), {{0, 0, 0.68f}}), baseline::Outcome::kNoGap);
  EXPECT_EQ(outcome(scene.cloud.view(), test::paper_options(), {{0, 0, 0.68f}}), baseline::Outcome::kAffordance);

  Cloud plane;
  for (int i = -50; i <= 50; ++i)
    for (int j = -50; j <= 50; ++j) plane.xyz.insert(plane.xyz.end(), {0.001f * i, 0.001f * j, 0.5f});
  plane.width = static_cast<std::uint32_t>(plane.xyz.size() / 3);
  EXPECT_EQ(outcome(plane.view(), test::paper_options(), {{0, 0, 0.5f}}), baseline::Outcome::kFlat);
}

// On noisy points there is no known answer, but the plain reference computes one in another way.
TEST(Baseline, AgreesWithTheReference) {
  const CylinderScene scene(0.022, 0.001);
  Samples samples = every(scene.samples, 67);
  for (int i = -8; i <= 8; ++i) samples.push_back({0.02f * i, 0.15f, 0.85f});  // on the wall
  const Options options = test::paper_options();
  const baseline::Result result = baseline::localize(scene.cloud.view(), options, samples, fixed_points());

  reference::Cloud cloud;
  for (std::size_t i = 0; i < scene.cloud.size(); ++i)
    cloud.points.emplace_back(scene.cloud.xyz[3 * i], scene.cloud.xyz[3 * i + 1], scene.cloud.xyz[3 * i + 2]);

  std::size_t found = 0, same_shell = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Vector3d sample(samples[i][0], samples[i][1], samples[i][2]);
    const reference::SampleResult expected = reference::localize_sample(cloud, sample, options);
    const baseline::SampleResult& actual = result.samples[i];
    ASSERT_EQ(actual.neighbours, expected.neighbours) << i;
    const bool past_curvature = expected.step > reference::Step::kCurvatureLow;
    ASSERT_EQ(actual.outcome > baseline::Outcome::kCurvatureLow, past_curvature) << i;
    ASSERT_GE(expected.neighbours, options.min_neighbours) << i;
    EXPECT_NEAR(actual.affordance.curvature, expected.curvature.median / options.effective_radius().front(), 1e-5) << i;
    if (!past_curvature) continue;
    EXPECT_NEAR(actual.affordance.radius, expected.circle.radius, 1e-8) << i;
    EXPECT_LT((eigen(actual.affordance.center) - sample - expected.circle.centre).norm(), 1e-8) << i;
    EXPECT_LT(angle(eigen(actual.affordance.axis), expected.axis), 1e-6) << i;

    // Steps of 1 mm find no smaller radius than the exact search, and may step over a narrow one.
    if (actual.outcome != baseline::Outcome::kAffordance) continue;
    ++found;
    ASSERT_EQ(expected.step, reference::Step::kAffordance) << i;
    EXPECT_GE(actual.affordance.shell_radius, expected.affordance.shell_radius - 1e-6) << i;
    same_shell += actual.affordance.shell_radius <= expected.affordance.shell_radius + 0.001;
    EXPECT_LT((eigen(actual.affordance.normal) - expected.affordance.normal).norm(), 1e-6) << i;
  }
  EXPECT_GT(found, samples.size() / 2);
  EXPECT_GE(same_shell, found * 9 / 10);
}

// On noisy points each choice of places has its own median; over many samples they are of one surface.
TEST(Baseline, MedianOverRandomPointsIsNearThatOverFixedOnes) {
  const CylinderScene scene(0.022, 0.001);
  const Samples samples = every(scene.samples, 31);
  const baseline::Result random = baseline::localize(scene.cloud.view(), test::paper_options(), samples);
  const baseline::Result fixed = baseline::localize(scene.cloud.view(), test::paper_options(), samples, fixed_points());
  std::vector<double> ratios;
  for (std::size_t i = 0; i < samples.size(); ++i)
    ratios.push_back(random.samples[i].affordance.curvature / fixed.samples[i].affordance.curvature);
  std::sort(ratios.begin(), ratios.end());
  EXPECT_NEAR(ratios[ratios.size() / 2], 1, 0.1);
  EXPECT_GT(ratios.front(), 0.5);
  EXPECT_LT(ratios.back(), 1.5);
  EXPECT_LT(ratios.front(), ratios.back()) << "not the same points";
}

// A pinhole camera's view of a sphere before a wall: PCL recovers its projection.
TEST(Baseline, OrganizedSearchFindsTheSameNeighbours) {
  Cloud cloud;
  cloud.width = 160;
  cloud.height = 120;
  Samples samples;
  const Vector3d center(0.01, 0.02, 0.6);
  const double radius = 0.03;
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) {
      const Vector3d ray((u - 79.5) / 400, (v - 59.5) / 400, 1);
      const double a = ray.squaredNorm(), b = ray.dot(center), c = center.squaredNorm() - radius * radius;
      const double under_root = b * b - a * c;
      const Vector3d p = (under_root > 0 ? (b - std::sqrt(under_root)) / a : 0.8) * ray;
      for (int k = 0; k < 3; ++k) cloud.xyz.push_back(static_cast<float>(p[k]));
      if ((u + 160 * v) % 211 == 0) samples.push_back({float(p[0]), float(p[1]), float(p[2])});
    }
  const baseline::Result tree = baseline::localize(cloud.view(), test::paper_options(), samples, fixed_points());
  const baseline::Result organized =
      baseline::localize(cloud.view(), test::paper_options(), samples, fixed_points(baseline::Search::kOrganized));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(organized.samples[i].neighbours, tree.samples[i].neighbours) << i;
    EXPECT_EQ(organized.samples[i].outcome, tree.samples[i].outcome) << i;
  }
}

TEST(Baseline, OrganizedSearchNeedsAnOrganizedCloud) {
  const CylinderScene scene(0.02, 0);
  EXPECT_THROW(baseline::localize(scene.cloud.view(), test::paper_options(), {}, {baseline::Search::kOrganized}),
               std::invalid_argument);
}

}  // namespace
}  // namespace handhold
