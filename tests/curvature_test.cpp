// The curvature kernel against the reference and against surfaces of known curvature, for every instruction set.
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
using Coefficients = reference::QuadricVector<double>;

/// f = (p - centre)^T A (p - centre) / 2 + l . (p - centre) + constant, A symmetric.
Coefficients quadric(const Matrix3d& A, const Vector3d& l, double constant, const Vector3d& centre) {
  const Vector3d linear = l - A * centre;
  Coefficients c;
  c << A(0, 0) / 2, A(1, 1) / 2, A(2, 2) / 2, A(0, 1), A(1, 2), A(0, 2), linear,
      centre.dot(A * centre) / 2 - l.dot(centre) + constant;
  return c;
}

/// Problems with their coefficients, and what they are compared with.
struct Case {
  FitProblem problem;
  Coefficients coefficients;
};

/// Runs the kernel on the coefficients given and calls visit(case, batch, lane).
template <class Visit>
void for_each_case(const Kernels& table, const std::vector<Case>& cases, Visit&& visit) {
  for (std::size_t first = 0; first < cases.size(); first += kernels::kBatch) {
    FitBatch batch;
    std::memset(&batch, 0, sizeof(batch));
    for (int lane = 0; lane < kernels::kBatch; ++lane) {
      const Case& one = cases[std::min(first + lane, cases.size() - 1)];
      for (int n = 0; n < kernels::kMoments; ++n) batch.moments[n][lane] = one.problem.sums[n];
      test::set_coefficients(batch, lane, one.coefficients);
    }
    table.curvature(batch);
    for (std::size_t i = first; i < std::min(cases.size(), first + kernels::kBatch); ++i)
      visit(cases[i], batch, static_cast<int>(i - first));
  }
}

bool all_finite(const FitBatch& batch, int lane) {
  return test::vector(batch.centre_normal, lane).allFinite() && test::vector(batch.axis, lane).allFinite() &&
         std::isfinite(batch.kappa_major[lane]) && std::isfinite(batch.kappa_minor[lane]) &&
         std::isfinite(batch.kappa_median[lane]);
}

/// Fits of ordinary neighbourhoods, and quadrics that no cloud would give: ellipsoids, hyperboloids and their like in
/// any pose, with a gradient of about 1 at the sample.
std::vector<Case> many_cases(std::uint64_t seed) {
  std::vector<Case> cases;
  const auto problems = test::ordinary_problems(seed, 30);
  for (const FitProblem& problem : problems)
    cases.push_back({problem, reference::fit_quadric(problem.sums).coefficients});
  test::Random random(seed + 1);
  for (const FitProblem& problem : problems) {
    const Matrix3d R = random.rotation();
    const Vector3d diagonal = random.normal3(1);
    const Matrix3d A = R * diagonal.asDiagonal() * R.transpose();
    Case one{problem, quadric(A, random.direction(), random.normal(0.03), random.normal3(0.05))};
    one.problem.name = "random quadric on " + problem.name;
    cases.push_back(one);
  }
  return cases;
}

TEST(Curvature, AgreesWithTheReference) {
  const auto cases = many_cases(31);
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    std::size_t compared = 0;
    for_each_case(*table, cases, [&](const Case& one, const FitBatch& batch, int lane) {
      SCOPED_TRACE(one.problem.name);
      ASSERT_TRUE(all_finite(batch, lane));
      const auto& c = one.coefficients;
      const auto truth = reference::curvature<long double>(c.cast<long double>(), one.problem.sums.cast<long double>());
      const auto q =
          reference::principal_curvatures<double>(c, reference::foot(c, reference::mean_point(one.problem.sums)));
      // Ill-defined: where the gradient nearly vanishes, or where every direction has nearly the same curvature.
      const auto separation = [](double minor, double major) { return std::abs(std::abs(major) - std::abs(minor)); };
      const double at_foot =
          separation(static_cast<double>(truth.at_foot.minor), static_cast<double>(truth.at_foot.major));
      if (truth.least_gradient < 0.05L || std::min(at_foot, separation(q.minor, q.major)) < 0.01) return;
      ++compared;
      // A dozen roundings of numbers up to |c| over a gradient of at least 0.05, squared in the invariants: 1e-16 * 12
      // * 400 |c|. The root of (mean^2 - Gauss) makes 1e-8 of that where both curvatures agree to 1 %.
      const double scale = 1 + c.norm();
      const double sign = static_cast<double>(truth.at_foot.major) * batch.kappa_major[lane] > 0 ? 1 : -1;
      EXPECT_EQ(sign, 1);
      EXPECT_NEAR(batch.kappa_major[lane], static_cast<double>(truth.at_foot.major), 1e-11 * scale);
      EXPECT_NEAR(batch.kappa_minor[lane], static_cast<double>(truth.at_foot.minor), 1e-11 * scale);
      EXPECT_NEAR(batch.kappa_median[lane], static_cast<double>(truth.median), 1e-8 * scale);
      EXPECT_LT((test::vector(batch.centre_normal, lane) - truth.at_foot.normal.cast<double>()).norm(), 1e-11 * scale);
      EXPECT_LT(test::angle_between(test::vector(batch.axis, lane), truth.at_foot.minor_direction.cast<double>()),
                1e-11 * scale / at_foot);
      EXPECT_NEAR(test::vector(batch.axis, lane).norm(), 1, 1e-12);
      EXPECT_NEAR(test::vector(batch.axis, lane).dot(test::vector(batch.centre_normal, lane)), 0, 1e-12);
    });
    EXPECT_GT(compared, cases.size() * 7 / 10);
  }
}

/// Points for the median: a patch of the surface f = 0 about the origin, by Newton's steps from a ball.
FitProblem patch_of(const char* name, const Coefficients& c, test::Random& random) {
  reference::Points points;
  for (int i = 0; i < 200; ++i) {
    const Vector3d start(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    points.push_back(reference::foot(c, reference::foot(c, start)));
  }
  return test::fit_problem(name, points);
}

TEST(Curvature, OfKnownSurfaces) {
  struct Known {
    Case one;
    double minor, major;  ///< absolute
    Vector3d axis;        ///< zero: any tangent will do
    bool outward;         ///< the gradient leaves the convex side, so the major curvature is positive
    double median;        ///< negative: unknown
  };
  test::Random random(33);
  std::vector<Known> known;
  for (int trial = 0; trial < 12; ++trial) {
    const Matrix3d R = random.rotation();
    const double r = random.uniform(0.4, 2);
    const Matrix3d I = Matrix3d::Identity();
    const auto add = [&](const char* name, double scale, const Matrix3d& A, const Vector3d& l, double constant,
                         const Vector3d& centre, double minor, double major, const Vector3d& axis, double median) {
      const double sign = trial % 2 ? -1 : 1;  // the fit does not know outside from inside
      const Coefficients c = sign * scale * quadric(A, l, constant, centre);
      known.push_back({{patch_of(name, c, random), c}, minor, major, axis, sign > 0, median});
    };
    const Vector3d x = R.col(0), y = R.col(1), z = R.col(2);
    // through the origin, where the sample is; |grad| = 1 there
    add("sphere", 1 / r, I, Vector3d::Zero(), -r * r / 2, -r * x, 1 / r, 1 / r, Vector3d::Zero(), 1 / r);
    add("cylinder", 1 / r, I - z * z.transpose(), Vector3d::Zero(), -r * r / 2, -r * x, 0, 1 / r, z, 1 / r);
    // the sample 0.01 above the surface: its foot is what counts, and two Newton steps leave 1e-9
    add("cylinder below the sample", 1 / r, I - z * z.transpose(), Vector3d::Zero(), -r * r / 2, -(r + 0.01) * x, 0,
        1 / r, z, 1 / r);
    // cone with slope s about z: x^2 + y^2 = s^2 z^2, at the height h where its radius is s h = r
    const double s = random.uniform(0.2, 0.8), h = r / s;
    add("cone", 1 / (r * std::sqrt(1 + s * s)), x * x.transpose() + y * y.transpose() - s * s * z * z.transpose(),
        Vector3d::Zero(), 0, -(r * x + h * z), 0, 1 / (r * std::sqrt(1 + s * s)), (s * x + z).normalized(), -1);
    // z = -(a x^2 + b y^2) / 2, elliptic and hyperbolic, at the vertex
    const double a = random.uniform(0.5, 1), b = random.uniform(0.1, 0.4) * (trial % 3 ? 1 : -1);
    add("paraboloid", 1, a * x * x.transpose() + b * y * y.transpose(), z, 0, Vector3d::Zero(), std::abs(b), a, y, -1);
  }
  std::vector<Case> cases;
  for (const Known& k : known) cases.push_back(k.one);
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    std::size_t i = 0;
    for_each_case(*table, cases, [&](const Case& one, const FitBatch& batch, int lane) {
      SCOPED_TRACE(one.problem.name);
      const Known& truth = known[i++];
      EXPECT_NEAR(batch.kappa_major[lane], truth.outward ? truth.major : -truth.major, 1e-7);
      EXPECT_NEAR(std::abs(batch.kappa_minor[lane]), truth.minor, 1e-7);
      const Vector3d axis = test::vector(batch.axis, lane);
      EXPECT_NEAR(axis.norm(), 1, 1e-12);
      EXPECT_NEAR(axis.dot(test::vector(batch.centre_normal, lane)), 0, 1e-12);
      if (truth.axis.norm() > 0) {
        EXPECT_LT(test::angle_between(axis, truth.axis), 1e-7);
      }
      // The nine points are brought down by two steps from up to 1.2 standard deviations away: 1e-3 of the radius.
      if (truth.median > 0) {
        EXPECT_NEAR(batch.kappa_median[lane], truth.median, 0.02 * truth.median);
      }
    });
  }
}

TEST(Curvature, OfAFittedTorus) {
  // A torus is no quadric. In a ball of half its tube's radius the fit's curvatures are within a few per cent.
  test::Random random(34);
  const double ring = 0.15, tube = 0.05, radius = 0.025;
  const auto points = test::to_double(test::torus(random, 200000, ring, tube));
  const auto problem = [&](const char* name, const Vector3d& sample) {
    return test::fit_problem(name, reference::scaled_neighbourhood(points, sample, radius));
  };
  const std::vector<FitProblem> problems = {problem("outside", {ring + tube, 0, 0}),
                                            problem("inside", {ring - tube, 0, 0})};
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    FitBatch batch = test::batch_of(problems);
    table->taubin(batch);
    table->curvature(batch);
    for (int lane : {0, 1}) {
      SCOPED_TRACE(problems[lane].name);
      const double around = lane == 0 ? 1 / (ring + tube) : -1 / (ring - tube);
      const double sign = batch.kappa_major[lane] > 0 ? 1 : -1;
      EXPECT_NEAR(sign * batch.kappa_major[lane] / radius, 1 / tube, 0.05 / tube);
      EXPECT_NEAR(sign * batch.kappa_minor[lane] / radius, around, 0.05 / tube);
      EXPECT_LT(test::angle_between(test::vector(batch.axis, lane), {0, 1, 0}), 0.02);
      EXPECT_NEAR(batch.kappa_median[lane] / radius, 1 / tube, 0.1 / tube);
    }
  }
}

TEST(Curvature, AxisOfTheWholeFitMatchesLongDouble) {
  const auto problems = test::ordinary_problems(35, 60);
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    std::size_t compared = 0;
    const auto fit = [&](FitBatch& batch) {
      table->taubin(batch);
      table->curvature(batch);
    };
    test::for_each_fit(problems, fit, [&](const FitProblem& problem, const FitBatch& batch, int lane) {
      SCOPED_TRACE(problem.name);
      const auto sums = problem.sums.cast<long double>().eval();
      const auto truth = reference::fit_quadric(sums);
      if (truth.next_lambda < 1.05L * truth.lambda + 1e-7L) return;
      const auto k = reference::curvature(truth.coefficients, sums);
      const long double major = std::abs(k.at_foot.major), minor = std::abs(k.at_foot.minor);
      if (k.least_gradient < 0.05L || major - minor < 0.05L) return;
      ++compared;
      // Float sums of moments cost 6e-3 rad at the 99th percentile: this is nothing beside it.
      EXPECT_LT(test::angle_between(test::vector(batch.axis, lane), k.at_foot.minor_direction.cast<double>()), 1e-5);
      EXPECT_NEAR(batch.kappa_median[lane], static_cast<double>(k.median), 1e-5 * (1 + static_cast<double>(k.median)));
    });
    EXPECT_GT(compared, problems.size() / 2);
  }
}

TEST(Curvature, FlatLanesAreNeverNan) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    const auto fit = [&](FitBatch& batch) {
      table->taubin(batch);
      table->curvature(batch);
    };
    test::for_each_fit(test::flat_problems(36), fit, [](const FitProblem& problem, const FitBatch& batch, int lane) {
      SCOPED_TRACE(problem.name);
      EXPECT_TRUE(all_finite(batch, lane));
    });
  }
}

TEST(Curvature, NoGradientIsNeverNan) {
  // The tip of a cone, the centre of a sphere, two crossing planes, a constant: where a quadric has no normal.
  test::Random random(37);
  const FitProblem ball =
      patch_of("ball", quadric(Matrix3d::Identity(), Vector3d::Zero(), -0.125, Vector3d::Zero()), random);
  const auto diagonal = [](double x, double y, double z) { return Matrix3d(Vector3d(x, y, z).asDiagonal()); };
  const std::vector<Case> cases = {
      {ball, quadric(diagonal(1, 1, -1), Vector3d::Zero(), 0, Vector3d::Zero())},
      {ball, quadric(diagonal(1, 1, 1), Vector3d::Zero(), -0.5, Vector3d::Zero())},
      {ball, quadric(diagonal(1, -1, 0), Vector3d::Zero(), 0, Vector3d::Zero())},
      {ball, quadric(diagonal(0, 0, 0), Vector3d::Zero(), 1, Vector3d::Zero())},
      {ball, Coefficients::Zero()},
  };
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    for_each_case(*table, cases,
                  [](const Case&, const FitBatch& batch, int lane) { EXPECT_TRUE(all_finite(batch, lane)); });
  }
}

TEST(Curvature, VectorTablesAgreeToTheBit) {
  const auto cases = many_cases(38);
  const auto tables = test::bitwise_kernels();
  std::vector<std::vector<FitBatch>> results(tables.size());
  for (std::size_t t = 0; t < tables.size(); ++t)
    for_each_case(*tables[t], cases, [&](const Case&, const FitBatch& batch, int lane) {
      if (lane == 0) results[t].push_back(batch);
    });
  for (std::size_t t = 1; t < tables.size(); ++t)
    EXPECT_TRUE(test::same_bits(results[t], results[0])) << tables[t]->name << " and " << tables[0]->name;
}

}  // namespace
}  // namespace handhold
