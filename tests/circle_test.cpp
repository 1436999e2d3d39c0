// The circle kernel, which works from moments, against the reference, which works from points; for every instruction
// set.
#include <gtest/gtest.h>

#include "test_fits.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using kernels::FitBatch;
using kernels::Kernels;
using test::FitProblem;

/// Runs the kernel with axes[i] for problem i and calls visit(problem, axis, batch, lane).
template <class Visit>
void for_each_circle(const Kernels& table, const std::vector<FitProblem>& problems, const std::vector<Vector3d>& axes,
                     Visit&& visit) {
  for (std::size_t first = 0; first < problems.size(); first += kernels::kBatch) {
    FitBatch batch = test::batch_of(problems, first);
    for (int lane = 0; lane < kernels::kBatch; ++lane)
      test::set_vector(batch.axis, lane, axes[std::min(first + lane, problems.size() - 1)]);
    table.circle(batch);
    for (std::size_t i = first; i < std::min(problems.size(), first + kernels::kBatch); ++i)
      visit(problems[i], axes[i], batch, static_cast<int>(i - first));
  }
}

/// Least eigenvalue of the scatter across the axis as a share of the largest: rounding grows with its inverse.
double roundness(const reference::Points& points, const Vector3d& axis) {
  const Eigen::Matrix3d C = reference::scatter(points);
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = axis.unitOrthogonal();
  across.col(1) = axis.cross(across.col(0));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(across.transpose() * C * across);
  return solver.eigenvalues()[0] / solver.eigenvalues()[1];
}

TEST(Circle, AgreesWithTheReference) {
  test::Random random(41);
  const auto problems = test::ordinary_problems(42, 30);
  std::vector<Vector3d> axes;
  for (std::size_t i = 0; i < problems.size(); ++i) {
    // half of them the axis that a fit would give, half any
    const auto& sums = problems[i].sums;
    axes.push_back(i % 2
                       ? random.direction()
                       : reference::curvature(reference::fit_quadric(sums).coefficients, sums).at_foot.minor_direction);
  }
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    std::size_t i = 0, compared = 0;
    for_each_circle(*table, problems, axes,
                    [&](const FitProblem& problem, const Vector3d& axis, const FitBatch& batch, int lane) {
                      SCOPED_TRACE(problem.name + ", problem " + std::to_string(i++));
                      const reference::Circle truth = reference::fit_circle(problem.points, axis);
                      const double round = roundness(problem.points, axis);
                      if (round < 1e-6) return;  // a line, or nearly so
                      ++compared;
                      // Third central moments carry 1e-15 of the uncentred ones (up to 1); the 2x2 solve multiplies by
                      // 1 / (round * spread).
                      const double tolerance = 1e-13 / round * (1 + truth.radius);
                      EXPECT_NEAR(batch.circle_radius[lane], truth.radius, tolerance);
                      EXPECT_LT((test::vector(batch.circle_centre, lane) - truth.centre).norm(), tolerance);
                      EXPECT_NEAR(test::vector(batch.circle_centre, lane).dot(axis), 0, 1e-14 * (1 + truth.radius));
                    });
    EXPECT_GT(compared, problems.size() * 9 / 10);
  }
}

TEST(Circle, AcrossExactCylinders) {
  test::Random random(43);
  std::vector<FitProblem> problems;
  std::vector<Vector3d> axes, centres;
  std::vector<double> radii;
  for (int i = 0; i < 48; ++i) {
    Matrix3d R = random.rotation();
    if (i < 6)
      R = Eigen::AngleAxisd(i * M_PI / 2, Vector3d::Unit(i % 3)).toRotationMatrix();  // the basis' special cases
    const double r = random.uniform(0.2, 3);
    const Vector3d centre = R * Vector3d(-r + random.normal(0.02), random.normal(0.02), 0);
    reference::Points points;
    for (int n = 0; n < 100; ++n) {
      const double a = random.uniform(-1, 1) * std::min(1.0, 1 / r);
      points.push_back(centre + R * Vector3d(r * std::cos(a), r * std::sin(a), random.uniform(-0.6, 0.6)));
    }
    problems.push_back(test::fit_problem("cylinder", points));
    axes.push_back(i % 2 ? Vector3d(-R.col(2)) : Vector3d(R.col(2)));
    centres.push_back(centre);
    radii.push_back(r);
  }
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    std::size_t i = 0;
    for_each_circle(*table, problems, axes,
                    [&](const FitProblem& problem, const Vector3d& axis, const FitBatch& batch, int lane) {
                      const double tolerance = 1e-13 / roundness(problem.points, axis) * (1 + radii[i]);
                      EXPECT_LT(tolerance, 1e-8);
                      EXPECT_NEAR(batch.circle_radius[lane], radii[i], tolerance);
                      EXPECT_LT((test::vector(batch.circle_centre, lane) - centres[i]).norm(), tolerance);
                      ++i;
                    });
  }
}

TEST(Circle, LineAcrossTheAxisIsInfiniteAndNeverNan) {
  test::Random random(44);
  const Matrix3d R = random.rotation();
  const Vector3d t(0.1, 0.2, -0.1);
  reference::Points plane, line;
  for (int n = 0; n < 200; ++n) {
    plane.push_back(t + R * Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 0));
    line.push_back(t + R * Vector3d(random.uniform(-0.5, 0.5), 0, 0));
  }
  const std::vector<FitProblem> problems = {test::fit_problem("plane along the axis", plane),
                                            test::fit_problem("line across the axis", line),
                                            test::fit_problem("line along the axis", line),
                                            test::fit_problem("one place", reference::Points(50, t)),
                                            test::fit_problem("one point", {t}),
                                            test::fit_problem("two points", {t, -t}),
                                            test::fit_problem("one place at the sample", {t - t, t - t})};
  const std::vector<Vector3d> axes = {R.col(0), R.col(1), R.col(0), R.col(2), R.col(2), R.col(1), R.col(0)};
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    for_each_circle(
        *table, problems, axes, [](const FitProblem& problem, const Vector3d&, const FitBatch& batch, int lane) {
          SCOPED_TRACE(problem.name);
          EXPECT_TRUE(test::vector(batch.circle_centre, lane).allFinite());
          // What is left of a place or of a line seen from its end is rounding about the mean, a scatter of 1e-17 in
          // any direction: its "circle" is as small as that, or infinite.
          const double radius = batch.circle_radius[lane];
          EXPECT_FALSE(std::isnan(radius));
          if (problem.name != "one place" && problem.name != "one point" && problem.name != "line along the axis") {
            EXPECT_TRUE(std::isinf(radius)) << radius;
          }
        });
  }
}

TEST(Circle, VectorTablesAgreeToTheBit) {
  test::Random random(45);
  const auto problems = test::ordinary_problems(46, 20);
  const auto tables = test::bitwise_kernels();
  for (std::size_t first = 0; first < problems.size(); first += kernels::kBatch) {
    FitBatch start = test::batch_of(problems, first);
    for (int lane = 0; lane < kernels::kBatch; ++lane) test::set_vector(start.axis, lane, random.direction());
    std::vector<FitBatch> results(tables.size(), start);
    for (std::size_t t = 0; t < tables.size(); ++t) {
      tables[t]->circle(results[t]);
      EXPECT_TRUE(test::same_bits(results[t], results[0])) << tables[t]->name << " and " << tables[0]->name;
    }
  }
}

}  // namespace
}  // namespace handhold
