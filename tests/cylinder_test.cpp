// Cylinders by their geometric distance: the kernel's normal equations against a plain sum, for every instruction set,
// and the fits that rest on them.
#include "cylinder.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "kernels.h"
#include "test_clouds.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using Eigen::Vector3d;
using test::FloatPoints;
using test::Random;

/// Separate arrays; behind the points NaN, which must not be seen.
struct Arrays {
  explicit Arrays(const FloatPoints& points) : n(points.size()) {
    for (std::vector<float>& c : coordinates) c.assign(points.size() + 16, test::kNan);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < 3; ++k) coordinates[k][i] = points[i][static_cast<Eigen::Index>(k)];
  }
  PointArrays view() const { return {coordinates[0].data(), coordinates[1].data(), coordinates[2].data(), n}; }
  std::size_t n;
  std::vector<float> coordinates[3];
};

struct Sums {
  Eigen::Matrix<double, 5, 5> A = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> b = Eigen::Matrix<double, 5, 1>::Zero();
  double cost = 0, square = 0;
};

Vector3d vector(const float* v) {
  return Eigen::Vector3f(v[0], v[1], v[2]).cast<double>();
}

Sums plain_sums(const FloatPoints& points, const kernels::CylinderQuery& q) {
  Sums sums;
  for (const Eigen::Vector3f& p : points) {
    const Vector3d d = p.cast<double>() - vector(q.point);
    const double h = d.dot(vector(q.axis)) / static_cast<double>(q.arm);
    const Vector3d w = d - d.dot(vector(q.axis)) * vector(q.axis);
    const double distance = w.norm() - static_cast<double>(q.radius), e = distance / static_cast<double>(q.sigma);
    const double weight = std::abs(e) < 2 ? 1 : 2 / std::abs(e);
    const double e1 = w.dot(vector(q.t1)) / w.norm(), e2 = w.dot(vector(q.t2)) / w.norm();
    Eigen::Matrix<double, 5, 1> a;
    a << e1, e2, h * e1, h * e2, 1;
    sums.A += weight * a * a.transpose();
    sums.b += weight * e * a;
    sums.cost += std::abs(e) < 2 ? e * e : 4 * std::abs(e) - 4;
    sums.square += distance * distance;
  }
  return sums;
}

TEST(CylinderKernel, SumsWhatThePlainLoopSums) {
  Random random(301);
  int tables = 0;
  const char* const* names = kernels::available(&tables);
  for (const int n : {0, 1, 2, 15, 16, 17, 400}) {
    for (const double noise : {0.0, 0.001, 0.01}) {
      const FloatPoints points =
          test::transformed(test::cylinder(random, n, 0.02, 0.05, noise, 2.5), random.rotation(), random.normal3(0.02));
      const Vector3d axis = random.direction(), t1 = axis.unitOrthogonal(), t2 = axis.cross(t1);
      kernels::CylinderQuery q{};
      const Vector3d at = random.normal3(0.01);
      for (int k = 0; k < 3; ++k) {
        q.point[k] = static_cast<float>(at[k]), q.axis[k] = static_cast<float>(axis[k]);
        q.t1[k] = static_cast<float>(t1[k]), q.t2[k] = static_cast<float>(t2[k]);
      }
      q.radius = 0.018f, q.sigma = 0.001f, q.arm = 0.02f;
      const Sums expected = plain_sums(points, q);
      const Arrays arrays(points);
      const PointArrays p = arrays.view();
      for (int i = 0; i < tables; ++i) {
        SCOPED_TRACE(std::string(names[i]) + ", " + std::to_string(n) + " points, noise " + std::to_string(noise));
        kernels::CylinderEquations sums;
        kernels::kernels(names[i])->cylinder(p.x, p.y, p.z, n, q, sums);
        const double scale = 1e-4 * (1 + n);
        for (int row = 0, k = 0; row < 5; ++row)
          for (int column = 0; column <= row; ++column, ++k) EXPECT_NEAR(sums.A[k], expected.A(row, column), scale);
        for (int k = 0; k < 5; ++k) EXPECT_NEAR(sums.b[k], expected.b[k], 10 * scale);
        EXPECT_NEAR(sums.cost, expected.cost, 1e-4 * (1 + expected.cost));
        EXPECT_NEAR(sums.square, expected.square, 1e-4 * (1e-6 + expected.square));
        // With a limit on the cost the equations are the same, or left out where they are not wanted.
        for (const double share : {0.99, 1.01}) {
          kernels::CylinderQuery limited = q;
          limited.skip_above = static_cast<float>(share) * sums.cost;
          kernels::CylinderEquations other{};
          other.b[4] = -77;
          kernels::kernels(names[i])->cylinder(p.x, p.y, p.z, n, limited, other);
          EXPECT_EQ(other.cost, sums.cost);
          EXPECT_EQ(other.square, sums.square);
          const bool skipped = share < 1 && n > 0 && n <= 256;
          EXPECT_EQ(other.b[4], skipped ? -77 : sums.b[4]);
          EXPECT_EQ(other.A[14], skipped ? 0 : sums.A[14]);
        }
      }
    }
  }
}

TEST(RefineCylinder, RecoversAPatchFromAWrongStart) {
  Random random(302);
  for (const double radius : {0.008, 0.02, 0.04}) {
    for (const double noise : {0.0, 0.0005}) {
      SCOPED_TRACE("radius " + std::to_string(radius) + ", noise " + std::to_string(noise));
      // Half of the side, as a camera sees it, about the z axis.
      const Arrays arrays(test::cylinder(random, 600, radius, 0.05, noise, M_PI));
      Cylinder c;
      c.point = {0.1 * radius, -0.1 * radius, 0.003};
      c.axis = normalized({0.15, -0.1, 1});
      c.radius = 1.25 * radius;
      const double rms = refine_cylinder(arrays.view(), 0.001, 12, c);
      EXPECT_LT(rms, 1.2 * noise + 1e-5);
      EXPECT_NEAR(c.radius, radius, 1e-5 + noise);
      EXPECT_LT(norm(c.across({0, 0, 0})), 1e-5 + noise);
      EXPECT_GT(std::fabs(c.axis[2]), std::cos(0.001 + 40 * noise));
      EXPECT_NEAR(arc_of(arrays.view(), c, {1, 0, 0}), 0.94 * M_PI, 0.2);
    }
  }
}

TEST(RefineCylinder, OutliersWeighLittle) {
  Random random(303);
  FloatPoints points = test::cylinder(random, 500, 0.02, 0.06, 0.0003, M_PI);
  for (int i = 0; i < 25; ++i) points.push_back(Eigen::Vector3f(0.05f, 0, 0) + random.normal3(0.005).cast<float>());
  const Arrays arrays(points);
  Cylinder c{{0.001, 0.001, 0}, {0, 0, 1}, 0.021};
  refine_cylinder(arrays.view(), 0.001, 20, c);
  EXPECT_NEAR(c.radius, 0.02, 0.002);
}

TEST(RefineCylinder, NoFewOrUselessPointsDoNoHarm) {
  Random random(304);
  for (const FloatPoints& points :
       {FloatPoints{}, FloatPoints{{0.01f, 0, 0}}, FloatPoints(20, {0.01f, 0.01f, 0.01f}),
        test::plane(random, 200, 0.05, 0), FloatPoints{{0, 0, 0}, {0, 0, 0.01f}, {0, 0, 0.02f}}}) {
    const Arrays arrays(points);
    Cylinder c{{0, 0, 0}, {0, 0, 1}, 0.02};
    const double rms = refine_cylinder(arrays.view(), 0.001, 10, c);
    EXPECT_TRUE(std::isfinite(rms));
    EXPECT_TRUE(std::isfinite(c.radius) && std::isfinite(norm(c.point)));
    EXPECT_NEAR(norm(c.axis), 1, 1e-9);
    EXPECT_GE(arc_of(arrays.view(), c, {1, 0, 0}), 0);
  }
}

// ---- Sixteen at a time ---------------------------------------------------------------------------------------------

using Trials = kernels::CylinderTrials;

/// What is fitted in one lane.
struct Trial {
  FloatPoints points;
  Cylinder guess;
};

Trials batch_of(const std::vector<Trial>& trials, int steps) {
  Trials t{};
  for (std::size_t lane = 0; lane < 16; ++lane) {
    const Trial& trial = trials[lane];
    for (int i = 0; i < Trials::kPoints; ++i)
      for (int k = 0; k < 3; ++k) t.points[i][k][lane] = trial.points[static_cast<std::size_t>(i)][k];
    for (std::size_t k = 0; k < 3; ++k) {
      t.point[k][lane] = static_cast<float>(trial.guess.point[k]);
      t.axis[k][lane] = static_cast<float>(trial.guess.axis[k]);
    }
    t.towards[0][lane] = 1;
    t.radius[lane] = static_cast<float>(trial.guess.radius);
    t.sigma[lane] = 0.001f;
  }
  t.arm = static_cast<float>(kTiltArm), t.steps = steps;
  return t;
}
Cylinder cylinder_of(const Trials& t, std::size_t lane) {
  Cylinder c;
  for (std::size_t k = 0; k < 3; ++k) {
    c.point[k] = static_cast<double>(t.point[k][lane]), c.axis[k] = static_cast<double>(t.axis[k][lane]);
  }
  c.radius = static_cast<double>(t.radius[lane]);
  return c;
}
double distance(const Cylinder& a, const Cylinder& b) {
  const Vector3 d = a.across(b.point);
  return norm(d) + std::fabs(a.radius - b.radius) + kTiltArm * norm(cross(a.axis, b.axis));
}

/// Patches as a camera sees them, each with a guess that is wrong by as much as a neighbourhood's circle is.
std::vector<Trial> random_trials(Random& random, double noise) {
  std::vector<Trial> trials;
  for (int lane = 0; lane < 16; ++lane) {
    const double radius = random.uniform(0.006, 0.04);
    Trial trial;
    trial.points = test::cylinder(random, Trials::kPoints, radius, random.uniform(0.02, 0.06), noise, 2.5);
    trial.guess.point = {0.1 * radius, -0.15 * radius, 0.004};
    trial.guess.axis = normalized({random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 1});
    trial.guess.radius = radius * random.uniform(0.75, 1.3);
    trials.push_back(trial);
  }
  return trials;
}

TEST(CylinderTrials, AgreeWithTheFitInDoublePrecision) {
  Random random(305);
  int all = 0, same = 0;
  for (int round = 0; round < 20; ++round) {
    const std::vector<Trial> trials = random_trials(random, 0.0004 * (round % 4));
    for (const int steps : {0, 1, 3, 8}) {
      for (const kernels::Kernels* table : test::all_kernels()) {
        SCOPED_TRACE(std::string(table->name) + ", " + std::to_string(steps) + " steps");
        Trials t = batch_of(trials, steps);
        table->try_cylinders(t);
        for (std::size_t lane = 0; lane < 16; ++lane) {
          const Arrays arrays(trials[lane].points);
          Cylinder plain = trials[lane].guess;
          const double rms = refine_cylinder(arrays.view(), 0.001, steps, plain);
          const Cylinder c = cylinder_of(t, lane);
          EXPECT_NEAR(norm(c.axis), 1, 1e-5);
          ++all, same += distance(c, plain) < 2e-5;
          // Where rounding took another step the fit is as good.
          EXPECT_LT(static_cast<double>(t.rms[lane]), 1.1 * rms + 2e-5);
          const double arc = turn_angle(t.most_turn[lane]) - turn_angle(t.least_turn[lane]);
          EXPECT_NEAR(arc, arc_of(arrays.view(), c, {1, 0, 0}), 1e-3);
        }
      }
    }
  }
  EXPECT_GT(same, all * 98 / 100);
}

TEST(CylinderTrials, HaveTheSameBitsWhateverTheInstructionSetAndTheOtherLanes) {
  Random random(306);
  const std::vector<Trial> trials = random_trials(random, 0.0005);
  Trials first = batch_of(trials, 3);
  test::bitwise_kernels().front()->try_cylinders(first);
  for (const kernels::Kernels* table : test::bitwise_kernels()) {
    for (std::size_t shift = 0; shift < 16; ++shift) {
      std::vector<Trial> turned;
      for (std::size_t lane = 0; lane < 16; ++lane) turned.push_back(trials[(lane + shift) % 16]);
      Trials t = batch_of(turned, 3);
      table->try_cylinders(t);
      for (std::size_t lane = 0; lane < 16; ++lane) {
        const std::size_t of = (lane + shift) % 16;
        EXPECT_EQ(t.radius[lane], first.radius[of]) << table->name;
        EXPECT_EQ(t.rms[lane], first.rms[of]) << table->name;
        EXPECT_EQ(t.most_turn[lane], first.most_turn[of]) << table->name;
        for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(t.axis[k][lane], first.axis[k][of]) << table->name;
      }
    }
  }
}

TEST(CylinderTrials, UselessPointsDoNoHarmToOtherLanes) {
  Random random(307);
  const std::vector<Trial> good = random_trials(random, 0.0003);
  const auto n = static_cast<std::size_t>(Trials::kPoints);
  std::vector<Trial> trials = good;
  trials[0].points = FloatPoints(n, {0.01f, 0.01f, 0.01f});
  trials[1].points = test::plane(random, Trials::kPoints, 0.05, 0);
  trials[2].points = FloatPoints(n, {0, 0, 0});
  trials[3].points = FloatPoints(n, {1e6f, 1e6f, -1e6f});
  trials[4].points = test::line(random, Trials::kPoints, 0.05);
  trials[5].points[7] = {test::kNan, 0, 0};
  trials[6].points = FloatPoints(n, {0, 0, 0.01f}), trials[6].guess = {{0, 0, 0}, {0, 0, 1}, 0.02};
  for (const kernels::Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Trials t = batch_of(trials, 3), clean = batch_of(good, 3);
    table->try_cylinders(t), table->try_cylinders(clean);
    for (std::size_t lane = 0; lane < 16; ++lane) {
      const Cylinder c = cylinder_of(t, lane);
      if (lane == 5) continue;  // NaN in, NaN out
      EXPECT_TRUE(std::isfinite(c.radius) && std::isfinite(norm(c.point))) << lane;
      EXPECT_NEAR(norm(c.axis), 1, 1e-5) << lane;
      EXPECT_FALSE(std::isnan(t.rms[lane])) << lane;
      if (lane > 6) {
        EXPECT_EQ(t.radius[lane], clean.radius[lane]);
      }
    }
  }
}

}  // namespace
}  // namespace handhold
