// The Taubin kernel against long double, for every instruction set.
#include <gtest/gtest.h>

#include <limits>

#include "test_fits.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using kernels::FitBatch;
using test::FitProblem;

/// How well defined a problem is, and what that leaves of a double's precision. The kernel reduces the problem to a
/// standard one, A = L^-1 M L^-T with N = L L^T about the points' mean. Rounding disturbs A by about eps cond(N) |A|;
/// that much moves an eigenvalue, and that over the distance to the next one moves the vector. 1e-13 is 450 eps: 9x9
/// sums and three chained transformations.
struct Accuracy {
  reference::Quadric<long double> fit;
  double largest = 0;    ///< generalized eigenvalue = |A|
  double condition = 0;  ///< of N about the mean
  double eigenvalue() const { return 1e-13 * condition * largest; }
  double vector() const { return eigenvalue() / static_cast<double>(fit.next_lambda - fit.lambda) + 1e-9; }
};

Accuracy accuracy_of(const FitProblem& problem) {
  Accuracy accuracy;
  accuracy.fit = reference::fit_quadric(problem.sums.cast<long double>().eval());
  const auto p = reference::taubin_problem(problem.sums);
  Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> all(p.M, p.N, Eigen::EigenvaluesOnly);
  accuracy.largest = all.eigenvalues()[8];
  const Eigen::Matrix<double, 6, 6> squares =
      p.N.topLeftCorner<6, 6>() - p.N.topRightCorner<6, 3>() * p.N.bottomLeftCorner<3, 6>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> spread(squares);
  accuracy.condition = std::max(1.0, spread.eigenvalues()[5]) / std::min(1.0, spread.eigenvalues()[0]);
  return accuracy;
}

bool all_finite(const FitBatch& batch, int lane) {
  return test::coefficients(batch, lane).allFinite() && std::isfinite(batch.lambda[lane]);
}

TEST(Taubin, AgreesWithLongDouble) {
  const auto problems = test::ordinary_problems(21, 60);
  ASSERT_GT(problems.size(), 700u);
  std::vector<Accuracy> accuracies;
  for (const FitProblem& problem : problems) accuracies.push_back(accuracy_of(problem));
  for (const kernels::Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    std::size_t i = 0, separated = 0, close = 0;
    test::for_each_fit(problems, table->taubin, [&](const FitProblem& problem, const FitBatch& batch, int lane) {
      SCOPED_TRACE(problem.name + ", problem " + std::to_string(i));
      const Accuracy& accuracy = accuracies[i++];
      ASSERT_FALSE(accuracy.fit.flat);
      ASSERT_EQ(batch.status[lane], kernels::kFitOk);
      const auto c = test::coefficients(batch, lane).cast<long double>().eval();
      const double lambda = static_cast<double>(accuracy.fit.lambda);
      // Laguerre's iteration stops at steps of 1e-9 of the root.
      EXPECT_NEAR(batch.lambda[lane], lambda, accuracy.eigenvalue() + 2e-9 * lambda);
      // What the vector itself leaves must be the least possible, whatever else is near it.
      const auto sums = problem.sums.cast<long double>().eval();
      const auto N = reference::mean_gradients(sums);
      const double length2 = static_cast<double>(c.dot(N * c));
      const double value2 = static_cast<double>(c.dot(reference::mean_values(sums) * c));
      EXPECT_NEAR(length2, 1, 1e-12 * accuracy.condition);
      EXPECT_NEAR(value2 / length2, lambda, accuracy.eigenvalue() + 2e-9 * lambda);
      // The mean of f is zero.
      EXPECT_NEAR(static_cast<double>(reference::mean_values(sums).row(9).dot(c)), 0, 1e-13 * (1 + c.norm()) * 10);
      close += accuracy.fit.next_lambda < 1.2L * accuracy.fit.lambda;
      if (accuracy.fit.next_lambda < 1.05L * accuracy.fit.lambda || accuracy.vector() > 1e-4) return;
      ++separated;
      const auto& truth = accuracy.fit.coefficients;
      const auto error = (c - (c.dot(N * truth) > 0 ? 1 : -1) * truth).eval();
      EXPECT_LT(std::sqrt(static_cast<double>(error.dot(N * error))), accuracy.vector());
    });
    EXPECT_GT(separated, problems.size() * 8 / 10);
    EXPECT_GT(close, 20u);  // the second eigenvalue lies within 20 %: where simpler iterations fail
  }
}

TEST(Taubin, ExactQuadricHasItsOwnCoefficients) {
  test::Random random(22);
  std::vector<FitProblem> problems;
  std::vector<reference::QuadricVector<double>> truths;
  for (int i = 0; i < 32; ++i) {
    // a cylinder of radius r about the direction w through q: |p - q|^2 - (w . (p - q))^2 = r^2
    const Eigen::Matrix3d R = random.rotation();
    const double r = random.uniform(0.3, 1.5);
    const Eigen::Vector3d w = R.col(2), q = -r * R.col(0) + 0.1 * R.col(1);
    reference::Points points;
    for (int n = 0; n < 300; ++n) {
      const double a = random.uniform(-1, 1);
      points.push_back(q + R * Eigen::Vector3d(r * std::cos(a), r * std::sin(a), random.uniform(-0.7, 0.7)));
    }
    const Eigen::Matrix3d A = Eigen::Matrix3d::Identity() - w * w.transpose();
    reference::QuadricVector<double> c;
    c << A(0, 0), A(1, 1), A(2, 2), 2 * A(0, 1), 2 * A(1, 2), 2 * A(0, 2), -2 * A * q, q.dot(A * q) - r * r;
    problems.push_back(test::fit_problem("cylinder", points));
    truths.push_back(c / (2 * r));  // |grad| = 1 on the surface
  }
  for (const kernels::Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    std::size_t i = 0;
    test::for_each_fit(problems, table->taubin, [&](const FitProblem&, const FitBatch& batch, int lane) {
      const auto c = test::coefficients(batch, lane);
      const auto& truth = truths[i++];
      EXPECT_EQ(batch.status[lane], kernels::kFitOk);
      EXPECT_GE(batch.lambda[lane], 0);
      EXPECT_LT(batch.lambda[lane], 1e-12);
      // next eigenvalues are 1e-4 and more: 1e-13 * 100 / 1e-4
      EXPECT_LT(std::min((c - truth).norm(), (c + truth).norm()), 1e-7);
    });
  }
}

TEST(Taubin, DegenerateIsFlatAndNeverNan) {
  for (const kernels::Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    test::for_each_fit(test::flat_problems(23), table->taubin,
                       [](const FitProblem& problem, const FitBatch& batch, int lane) {
                         SCOPED_TRACE(problem.name);
                         EXPECT_EQ(batch.status[lane], kernels::kFitFlat);
                         EXPECT_TRUE(all_finite(batch, lane));
                       });
  }
}

TEST(Taubin, ThinNoiseIsNotFlat) {
  // 4 s^2 > 1e-9 from s = 1.6e-5 on; the float coordinates of a plane at a few metres have about 1e-5.
  test::Random random(24);
  for (double noise : {1e-7, 1e-4, 1e-3}) {
    reference::Points points;
    for (int i = 0; i < 400; ++i)
      points.emplace_back(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), random.normal(noise));
    const auto problem = test::fit_problem("thin plane", points);
    for (const kernels::Kernels* table : test::all_kernels()) {
      SCOPED_TRACE(table->name);
      FitBatch batch = test::batch_of({problem});
      table->taubin(batch);
      EXPECT_EQ(batch.status[0], noise < 1e-6 ? kernels::kFitFlat : kernels::kFitOk) << noise;
      EXPECT_TRUE(all_finite(batch, 0));
    }
  }
}

TEST(Taubin, FewPointsAreFittedOrFlatButNeverNan) {
  // Fewer than nine points: more than one quadric goes through all of them, and the smallest eigenvalue is a multiple
  // zero.
  test::Random random(25);
  std::vector<FitProblem> problems;
  for (int n = 2; n <= 17; ++n) {
    reference::Points points;
    for (int i = 0; i < n; ++i) points.push_back(random.normal3(0.4));
    problems.push_back(test::fit_problem(std::to_string(n) + " points", points));
  }
  for (const kernels::Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    test::for_each_fit(problems, table->taubin, [](const FitProblem& problem, const FitBatch& batch, int lane) {
      SCOPED_TRACE(problem.name);
      EXPECT_TRUE(all_finite(batch, lane));
      if (problem.points.size() >= 4) {
        EXPECT_EQ(batch.status[lane], kernels::kFitOk);
      }
      if (problem.points.size() <= 9) {
        EXPECT_NEAR(batch.lambda[lane], 0, 1e-10);
      }
    });
  }
}

TEST(Taubin, LanesDoNotMeet) {
  auto problems = test::ordinary_problems(26, 1);
  const auto flat = test::flat_problems(27);
  problems.insert(problems.begin() + 3, flat.begin(), flat.begin() + 4);
  ASSERT_GE(problems.size(), 16u);
  problems.resize(16);
  for (const kernels::Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    FitBatch together = test::batch_of(problems);
    table->taubin(together);
    for (int lane = 0; lane < kernels::kBatch; ++lane) {
      FitBatch alone = test::batch_of({problems[lane]});  // in all lanes
      table->taubin(alone);
      for (int other : {0, 7, 15}) {
        EXPECT_TRUE(test::same_bits(test::coefficients(together, lane), test::coefficients(alone, other)));
        EXPECT_TRUE(test::same_bits(together.lambda[lane], alone.lambda[other]));
        EXPECT_EQ(together.status[lane], alone.status[other]);
      }
    }
  }
}

TEST(Taubin, VectorTablesAgreeToTheBit) {
  auto problems = test::ordinary_problems(28, 20);
  const auto flat = test::flat_problems(29);
  problems.insert(problems.end(), flat.begin(), flat.end());
  const auto tables = test::bitwise_kernels();
  for (std::size_t first = 0; first < problems.size(); first += kernels::kBatch) {
    std::vector<FitBatch> results(tables.size(), test::batch_of(problems, first));
    for (std::size_t t = 0; t < tables.size(); ++t) {
      tables[t]->taubin(results[t]);
      EXPECT_TRUE(test::same_bits(results[t], results[0])) << tables[t]->name << " and " << tables[0]->name;
    }
  }
}

}  // namespace
}  // namespace handhold
