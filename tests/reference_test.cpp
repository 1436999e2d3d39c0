// The reference against shapes whose answer is known, and against itself where an answer can be had in two ways.
#include "reference/reference.h"

#include <gtest/gtest.h>

#include "kernels.h"
#include "paper_options.h"
#include "test_clouds.h"

namespace handhold {
namespace {

using Eigen::Matrix3d;
using reference::Points;
using reference::Step;
using reference::Vector3d;
using test::Random;

constexpr double kRadius = 0.025;  // m; of a neighbourhood

/// Angle between two directions whose sign means nothing (rad).
double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

Points doubles(const test::FloatPoints& points) {
  return test::to_double(points);
}

// ---- Neighbours and moments ---------------------------------------------------------------------------------------

TEST(ReferenceNeighbours, BallIsClosedAndBadPointsAreMissing) {
  const double nan = std::nan("");
  const Points points = {{0.5, 0, 0}, {0.5000001, 0, 0}, {0, -0.5, 0}, {nan, 0, 0}, {0, 0, INFINITY}, {0, 0, 0}};
  EXPECT_EQ(reference::neighbours(points, {0, 0, 0}, 0.5), (std::vector<std::size_t>{0, 2, 5}));
  EXPECT_TRUE(reference::neighbours({}, {0, 0, 0}, 1).empty());
}

TEST(ReferenceMoments, OrderIsThatOfTheKernels) {
  const auto& list = reference::monomials();
  for (int n = 0; n < reference::kMomentCount; ++n) {
    EXPECT_EQ(kernels::moment_index(list[n][0], list[n][1], list[n][2]), n);
    EXPECT_EQ(reference::monomial_index(list[n]), n);
  }
  EXPECT_THROW(reference::monomial_index({3, 2, 0}), std::out_of_range);
}

TEST(ReferenceMoments, OfTwoPoints) {
  const auto sums = reference::moment_sums<double>({{1, 2, 3}, {-1, 0, 2}});
  EXPECT_EQ(sums[0], 2);
  EXPECT_EQ(sums[reference::monomial_index({0, 0, 1})], 5);
  EXPECT_EQ(sums[reference::monomial_index({1, 1, 2})], 18);
  EXPECT_EQ(sums[reference::monomial_index({0, 0, 4})], 81 + 16);
  EXPECT_TRUE(reference::mean_point(sums).isApprox(Vector3d(0, 1, 2.5)));
  EXPECT_DOUBLE_EQ(reference::covariance(sums)(0, 2), 0.5);
}

// ---- Taubin -------------------------------------------------------------------------------------------------------

TEST(ReferenceTaubin, FindsAnExactQuadric) {
  Random random(1);
  Points points;
  for (int i = 0; i < 400; ++i) {
    const double a = random.uniform(-1, 1), z = random.uniform(-1, 1);
    points.emplace_back(std::cos(a) - 1, std::sin(a), z);  // (x + 1)^2 + y^2 = 1
  }
  const auto fit = reference::fit_quadric(reference::moment_sums<double>(points));
  ASSERT_FALSE(fit.flat);
  EXPECT_NEAR(fit.lambda, 0, 1e-12);
  EXPECT_GT(fit.next_lambda, 1e-4);
  reference::QuadricVector<double> truth = reference::QuadricVector<double>::Zero();
  truth[0] = truth[1] = 0.5, truth[6] = 1;  // |grad| = 1 all over the surface, as c^T N c = 1 asks
  EXPECT_LT((fit.coefficients * (fit.coefficients[6] > 0 ? 1 : -1) - truth).norm(), 1e-9);
}

TEST(ReferenceTaubin, NothingFitsBetter) {
  Random random(2);
  for (const auto& cloud : test::ordinary_clouds(3, 3000)) {
    SCOPED_TRACE(cloud.name);
    const Points points = reference::scaled_neighbourhood(doubles(cloud.points), cloud.sample.cast<double>(), kRadius);
    const auto sums = reference::moment_sums<double>(points);
    const auto fit = reference::fit_quadric(sums);
    ASSERT_FALSE(fit.flat);
    EXPECT_LE(fit.lambda, fit.next_lambda);
    const auto M = reference::mean_values(sums);
    const auto N = reference::mean_gradients(sums);
    const auto quotient = [&](const reference::QuadricVector<double>& c) { return c.dot(M * c) / c.dot(N * c); };
    // both matrices once more from their meaning: f and its gradient at every point
    double value2 = 0, gradient2 = 0;
    for (const Vector3d& p : points) {
      value2 += std::pow(reference::quadric_value(fit.coefficients, p), 2) / points.size();
      gradient2 += reference::quadric_gradient(fit.coefficients, p).squaredNorm() / points.size();
    }
    EXPECT_NEAR(value2, fit.lambda, 1e-10);  // rounding: cond(N) <= 1e6 here
    EXPECT_NEAR(gradient2, 1, 1e-8);
    for (double size : {1e-3, 1e-1, 1.0})
      for (int i = 0; i < 50; ++i) {
        reference::QuadricVector<double> c = fit.coefficients;
        for (int a = 0; a < 10; ++a) c[a] += random.normal(size);
        EXPECT_GE(quotient(c), fit.lambda - 1e-10);
      }
  }
}

TEST(ReferenceTaubin, DegenerateCloudsAreFlat) {
  for (const auto& cloud : test::degenerate_clouds(4)) {
    SCOPED_TRACE(cloud.name);
    const Points points = reference::scaled_neighbourhood(doubles(cloud.points), cloud.sample.cast<double>(), kRadius);
    EXPECT_TRUE(reference::fit_quadric(reference::moment_sums<double>(points)).flat);
  }
}

TEST(ReferenceTaubin, LongDoubleAgrees) {
  for (const auto& cloud : test::ordinary_clouds(5, 4000)) {
    SCOPED_TRACE(cloud.name);
    const Points points = reference::scaled_neighbourhood(doubles(cloud.points), cloud.sample.cast<double>(), kRadius);
    const auto fit = reference::fit_quadric(reference::moment_sums<double>(points));
    const auto judge = reference::fit_quadric(reference::moment_sums<long double>(points));
    EXPECT_NEAR(fit.lambda, static_cast<double>(judge.lambda), 1e-11);
    if (judge.next_lambda < 1.05L * judge.lambda + 1e-6L) continue;
    const auto c = judge.coefficients.cast<double>().eval();
    EXPECT_LT(std::min((fit.coefficients - c).norm(), (fit.coefficients + c).norm()), 1e-6);
  }
}

// ---- Curvature ----------------------------------------------------------------------------------------------------

struct KnownSurface {
  const char* name;
  test::FloatPoints points;
  Vector3d sample;
  double minor, major;  // 1/m, absolute, at the sample
  Vector3d axis;        // zero: every direction is as good
  double tolerance;     // 1/m; a torus and a cone's neighbourhood are not the quadric that is fitted
};

TEST(ReferenceCurvature, OfKnownSurfaces) {
  Random random(6);
  const double slope = 0.4, height = 0.06, cone_radius = slope * height;
  const KnownSurface surfaces[] = {
      {"cylinder", test::cylinder(random, 4000, 0.02, 0.1), {0.02, 0, 0}, 0, 50, {0, 0, 1}, 0.05},
      {"sphere", test::sphere(random, 4000, 0.03), {0, 0, 0.03}, 1 / 0.03, 1 / 0.03, {0, 0, 0}, 0.05},
      {"cone",
       test::cone(random, 9000, slope, 0.02, 0.1),
       {cone_radius, 0, height},
       0,
       1 / (cone_radius * std::sqrt(1 + slope * slope)),
       Vector3d(slope, 0, 1).normalized(),
       0.05},
      {"saddle", test::paraboloid(random, 4000, 20, -9, 0.06), {0, 0, 0}, 9, 20, {0, 1, 0}, 0.05},
      {"torus, outside", test::torus(random, 60000, 0.25, 0.05), {0.3, 0, 0}, 1 / 0.3, 20, {0, 1, 0}, 1},
      {"torus, inside", test::torus(random, 60000, 0.25, 0.05), {0.2, 0, 0}, 1 / 0.2, 20, {0, 1, 0}, 1},
  };
  for (const KnownSurface& surface : surfaces) {
    SCOPED_TRACE(surface.name);
    const auto sums = reference::moment_sums<double>(
        reference::scaled_neighbourhood(doubles(surface.points), surface.sample, kRadius));
    const auto fit = reference::fit_quadric(sums);
    ASSERT_FALSE(fit.flat);
    const auto k = reference::curvature(fit.coefficients, sums);
    EXPECT_NEAR(std::abs(k.at_foot.major) / kRadius, surface.major, surface.tolerance);
    EXPECT_NEAR(std::abs(k.at_foot.minor) / kRadius, surface.minor, surface.tolerance);
    if (surface.axis.norm() > 0) {
      EXPECT_LT(angle_between(k.at_foot.minor_direction, surface.axis), 0.005);
    }
    EXPECT_NEAR(k.at_foot.minor_direction.dot(k.at_foot.normal), 0, 1e-9);
  }
}

TEST(ReferenceCurvature, SignFollowsTheGradient) {
  reference::QuadricVector<double> c = reference::QuadricVector<double>::Zero();
  c[0] = c[1] = c[2] = 1, c[9] = -4;  // sphere of radius 2, gradient outward
  EXPECT_NEAR(reference::principal_curvatures<double>(c, {0, 0, 2}).major, 0.5, 1e-12);
  EXPECT_NEAR(reference::principal_curvatures<double>(-c, {0, 0, 2}).major, -0.5, 1e-12);
  const auto saddle = [] {
    reference::QuadricVector<double> s = reference::QuadricVector<double>::Zero();
    s[0] = 1, s[1] = -0.25, s[8] = -1;  // z = x^2 - y^2 / 4
    return s;
  }();
  const auto k = reference::principal_curvatures<double>(saddle, {0, 0, 0});
  EXPECT_NEAR(k.major, 2, 1e-12);
  EXPECT_NEAR(k.minor, -0.5, 1e-12);
  EXPECT_LT(angle_between(k.minor_direction, {0, 1, 0}), 1e-9);
}

TEST(ReferenceCurvature, MedianOfACylinderIsItsCurvature) {
  Random random(7);
  const Points points = doubles(test::cylinder(random, 5000, 0.02, 0.1));
  const auto sums = reference::moment_sums<double>(reference::scaled_neighbourhood(points, {0.02, 0, 0}, kRadius));
  const auto k = reference::curvature(reference::fit_quadric(sums).coefficients, sums);
  EXPECT_NEAR(k.median / kRadius, 50, 0.05);
}

TEST(ReferenceCurvature, NeverNanWithoutAGradient) {
  const auto sums = reference::moment_sums<double>({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const auto k = reference::curvature<double>(reference::QuadricVector<double>::Zero(), sums);
  EXPECT_EQ(k.median, 0);
  EXPECT_TRUE(k.at_foot.minor_direction.allFinite());
}

// ---- Circle -------------------------------------------------------------------------------------------------------

TEST(ReferenceCircle, AcrossAnExactCylinder) {
  Random random(8);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix3d R = random.rotation();
    const double radius = random.uniform(0.3, 3);
    const Vector3d centre = R * Vector3d(random.normal(1), random.normal(1), 0);
    Points points;
    for (int i = 0; i < 50; ++i) {
      const double a = random.uniform(-1, 1);
      points.push_back(centre + R * Vector3d(radius * std::cos(a), radius * std::sin(a), random.uniform(-1, 1)));
    }
    const auto circle = reference::fit_circle(points, R.col(2));
    EXPECT_NEAR(circle.radius, radius, 1e-9);
    EXPECT_LT((circle.centre - centre).norm(), 1e-9);
  }
}

TEST(ReferenceCircle, OfALineIsInfinite) {
  EXPECT_TRUE(std::isinf(reference::fit_circle({{0, 0, 0}, {1, 0, 5}, {2, 0, 1}}, {0, 0, 1}).radius));
  EXPECT_TRUE(std::isinf(reference::fit_circle({{1, 1, 0}, {1, 1, 3}}, {0, 0, 1}).radius));
  EXPECT_TRUE(std::isinf(reference::fit_circle({}, {0, 0, 1}).radius));
}

// ---- Shell --------------------------------------------------------------------------------------------------------

TEST(ReferenceShell, WorkedExample) {
  const std::vector<double> rho = {1, 2, 3, 4, 6, 6.5, 9};
  //                start max gap k  m
  auto shell = reference::find_shell_by_jumps(rho, {0, 10, 2, 0, 1});
  EXPECT_EQ(shell.status, reference::ShellStatus::kFound);
  EXPECT_EQ(shell.radius, 4);  // (4, 6) is empty: the point at 6 is not inside an open interval
  EXPECT_EQ(shell.free_to, 6);
  EXPECT_EQ(shell.inner_points, 4);
  EXPECT_EQ(shell.gap_points, 0);
  shell = reference::find_shell_by_jumps(rho, {0, 10, 2, 0, 5});  // needs the point at 6, whose gap holds 6.5
  EXPECT_EQ(shell.radius, 6.5);
  EXPECT_EQ(shell.free_to, 9);
  shell = reference::find_shell_by_jumps(rho, {0, 10, 2, 1, 1});
  EXPECT_EQ(shell.radius, 1);  // one point in (1, 3)
  EXPECT_EQ(shell.free_to, 3);
  EXPECT_EQ(reference::find_shell_by_jumps(rho, {0, 3.9, 2, 0, 1}).status, reference::ShellStatus::kNoGap);
  EXPECT_EQ(reference::find_shell_by_jumps(rho, {0, 5, 2, 0, 6}).status, reference::ShellStatus::kEmpty);
  EXPECT_EQ(reference::find_shell_by_jumps({}, {0, 5, 2, 0, 1}).status, reference::ShellStatus::kEmpty);
  EXPECT_EQ(reference::find_shell_by_jumps({}, {0, 5, 2, 0, 0}).free_to, 7);
  EXPECT_EQ(reference::find_shell_by_jumps(rho, {6, 5, 2, 0, 0}).status, reference::ShellStatus::kNoGap);
}

TEST(ReferenceShell, JumpsAgreeWithExhaustiveSearch) {
  Random random(9);
  int found = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const bool ties = trial % 2 == 0;  // multiples of 1/8: many equal radii, many exactly on the gap's border
    std::vector<double> rho(random.index(60));
    for (double& r : rho) r = ties ? std::floor(random.uniform(0, 80)) / 8 : random.uniform(0, 10);
    std::sort(rho.begin(), rho.end());
    reference::ShellQuery query;
    query.start_radius = ties ? std::floor(random.uniform(0, 40)) / 8 : random.uniform(0, 5);
    query.max_radius = random.uniform(0, 10);
    query.gap = ties ? std::floor(random.uniform(1, 16)) / 8 : random.uniform(0.1, 2);
    query.max_gap_points = static_cast<int>(random.index(6));
    query.min_inner_points = static_cast<int>(random.index(30));
    const auto jumps = reference::find_shell_by_jumps(rho, query);
    const auto all = reference::find_shell_exhaustively(rho, query);
    ASSERT_EQ(jumps.status, all.status);
    ASSERT_EQ(jumps.radius, all.radius);
    ASSERT_EQ(jumps.free_to, all.free_to);
    ASSERT_EQ(jumps.inner_points, all.inner_points);
    ASSERT_EQ(jumps.gap_points, all.gap_points);
    found += jumps.status == reference::ShellStatus::kFound;
  }
  EXPECT_GT(found, 500);
  EXPECT_LT(found, 2900);
}

TEST(ReferenceShell, DistancesToAnAxis) {
  const Points points = {{3, 4, 0.5}, {1, 0, -0.6}, {0, 2, -0.5}, {std::nan(""), 0, 0}};
  const auto rho = reference::distances_to_axis(points, {0, 0, 0}, {0, 0, 1}, 0.5);
  ASSERT_EQ(rho.size(), 2u);
  EXPECT_DOUBLE_EQ(rho[0], 2);
  EXPECT_DOUBLE_EQ(rho[1], 5);
}

// ---- Alignment, axes without a quadric ----------------------------------------------------------------------------

TEST(ReferenceAlign, EachLimitCounts) {
  const reference::AxisCircle a{{0, 0, 0}, {0, 0, 1}, 0.02};
  const reference::AlignLimits limits{std::sin(0.35), 0.01, 0.005};
  const auto with = [&](const Vector3d& center, double angle, double radius) {
    return reference::aligned(a, {center, {std::sin(angle), 0, -std::cos(angle)}, radius}, limits);
  };
  EXPECT_TRUE(with({0, 0, 0.1}, 0, 0.02));  // the axis' sign and the way along it do not matter
  EXPECT_TRUE(with({0, 0.0099, 0.1}, 0, 0.0249));
  EXPECT_FALSE(with({0, 0.0101, 0}, 0, 0.02));
  EXPECT_FALSE(with({0, 0, 0}, 0, 0.0251));
  EXPECT_TRUE(with({0, 0, 0}, 0.34, 0.02));
  EXPECT_FALSE(with({0, 0, 0}, 0.36, 0.02));
  EXPECT_FALSE(with({0, 0, 0.1}, 0.3, 0.02));  // straight ahead for a, but 3 cm beside the other one's axis
}

TEST(ReferenceAxis, FromNormalsAndFromSpread) {
  Random random(10);
  const Matrix3d R = random.rotation();
  const Points points = doubles(test::transformed(test::cylinder(random, 3000, 0.02, 0.1, 3e-4, M_PI), R, {0, 0, 0.5}));
  Points normals;
  for (int i = 0; i < 60; ++i) normals.push_back(reference::normal_at(points, points[i], 0.006));
  EXPECT_LT(angle_between(reference::axis_from_normals(normals), R.col(2)), 0.05);
  EXPECT_LT(angle_between(reference::axis_from_spread(points), R.col(2)), 0.05);
  EXPECT_EQ(reference::normal_at(points, {9, 9, 9}, 0.006).norm(), 0);
}

// ---- Algorithm 1 --------------------------------------------------------------------------------------------------

reference::Cloud seen_from_afar(const test::FloatPoints& points) {
  reference::Cloud cloud;
  cloud.points = doubles(points);
  cloud.viewpoint = Vector3d(0.7, 0, 0);
  return cloud;
}

TEST(ReferencePipeline, CylinderInTheOpenIsAnAffordance) {
  Random random(11);
  const auto cloud = seen_from_afar(test::cylinder(random, 8000, 0.02, 0.2, 3e-4, M_PI));
  for (auto estimator : {AxisEstimator::kTaubin, AxisEstimator::kPca}) {
    Options options = test::paper_options();
    options.axis = estimator;
    options.radius = {0.04};  // long enough that the spread is largest along the axis
    const auto result = reference::localize_sample(cloud, {0.0201, 0.0003, 0.01}, options);
    ASSERT_EQ(result.step, Step::kAffordance);
    const auto& affordance = result.affordance;
    EXPECT_LT(angle_between(affordance.axis, {0, 0, 1}), 0.05);
    EXPECT_GT(affordance.axis.z(), 0);
    EXPECT_GT(affordance.normal.x(), 0.99);
    EXPECT_NEAR(affordance.radius, 0.02, 5e-4);
    EXPECT_LT((affordance.center - Vector3d(0, 0, 0.01)).norm(), 1e-3);
    EXPECT_NEAR(affordance.curvature, 50, 3);
    EXPECT_GE(affordance.gap, options.finger_thickness);
    EXPECT_GE(affordance.shell_radius, 0.7 * affordance.radius);
  }
}

TEST(ReferencePipeline, EveryStepCanRefuse) {
  Random random(12);
  const Options options = test::paper_options();
  const auto rod = test::cylinder(random, 8000, 0.02, 0.2, 2e-4);
  const Vector3d on_rod(0.02, 0, 0);
  const auto step = [](const test::FloatPoints& points, const Vector3d& sample, const Options& o) {
    return reference::localize_sample(seen_from_afar(points), sample, o).step;
  };
  EXPECT_EQ(step({}, on_rod, options), Step::kTooFewPoints);
  EXPECT_EQ(step(rod, {0.5, 0, 0}, options), Step::kTooFewPoints);
  EXPECT_EQ(step(test::plane(random, 4000, 0.1), {0, 0, 0}, options), Step::kFlat);
  EXPECT_EQ(step(test::cylinder(random, 20000, 0.07, 0.2, 2e-4), {0.07, 0, 0}, options), Step::kCurvatureLow);
  EXPECT_EQ(step(test::cylinder(random, 20000, 0.045, 0.2, 2e-4), {0.045, 0, 0}, options), Step::kCircleWide);
  Options fixed_hand = test::paper_options();
  fixed_hand.hand_minimum = 0.05;
  EXPECT_EQ(step(rod, on_rod, fixed_hand), Step::kCircleNarrow);
  // a wall of points around the rod, 5 mm away and thicker than the aperture allows to go round
  test::FloatPoints wrapped = rod;
  for (double radius = 0.025; radius < 0.06; radius += 0.003)
    wrapped = test::joined(wrapped, test::cylinder(random, 20000, radius, 0.2));
  Options near = test::paper_options();
  near.radius = {0.01};  // sees the rod alone
  near.min_neighbours = 10;
  near.finger_thickness = 0.02;
  EXPECT_EQ(step(wrapped, {0.015, 0, 0}, near), Step::kNoGap);
  Options greedy = test::paper_options();
  greedy.shell_inner_area_mm2 = 1e5;
  EXPECT_EQ(step(rod, on_rod, greedy), Step::kShellEmpty);
  EXPECT_EQ(step(rod, on_rod, options), Step::kAffordance);
}

TEST(ReferencePipeline, MovesWithTheCloud) {
  Random random(13);
  const auto points = test::cylinder(random, 8000, 0.02, 0.2, 5e-4, M_PI);
  const Vector3d sample(0.02, 0, 0);
  const auto still = reference::localize_sample(seen_from_afar(points), sample, test::paper_options());
  ASSERT_EQ(still.step, Step::kAffordance);
  const Matrix3d R = random.rotation();
  const Vector3d t(0.3, -0.1, 0.8);
  reference::Cloud moved = seen_from_afar(points);
  for (Vector3d& p : moved.points) p = R * p + t;
  moved.viewpoint = R * *moved.viewpoint + t;
  const auto result = reference::localize_sample(moved, R * sample + t, test::paper_options());
  ASSERT_EQ(result.step, Step::kAffordance);
  EXPECT_LT((result.affordance.center - (R * still.affordance.center + t)).norm(), 1e-8);
  EXPECT_LT(angle_between(result.affordance.axis, R * still.affordance.axis), 1e-7);
  EXPECT_LT((result.affordance.normal - R * still.affordance.normal).norm(), 1e-7);
  EXPECT_NEAR(result.affordance.radius, still.affordance.radius, 1e-9);
  EXPECT_NEAR(result.affordance.shell_radius, still.affordance.shell_radius, 1e-9);
}

TEST(ReferencePipeline, AxisFromNormals) {
  Random random(14);
  reference::Cloud cloud = seen_from_afar(test::cylinder(random, 8000, 0.02, 0.2, 2e-4, M_PI));
  for (const Vector3d& p : cloud.points) cloud.normals.push_back(Vector3d(p.x(), p.y(), 0).normalized());
  Options options = test::paper_options();
  options.axis = AxisEstimator::kNormals;
  const auto result = reference::localize_sample(cloud, {0.02, 0, 0}, options);
  ASSERT_EQ(result.step, Step::kAffordance);
  EXPECT_LT(angle_between(result.affordance.axis, {0, 0, 1}), 1e-6);
}

}  // namespace
}  // namespace handhold
