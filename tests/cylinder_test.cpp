// Cylinders by their geometric distance: the kernel's normal equations against a plain sum, for every instruction set,
// and the fits that rest on them.
#include "cylinder.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "kernels.h"
#include "test_clouds.h"

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

}  // namespace
}  // namespace handhold
