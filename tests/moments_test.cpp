// The moments kernel against double sums over the brute-force neighbourhood, for every instruction set.
#include <gtest/gtest.h>

#include <cstring>

#include "reference/reference.h"
#include "test_fits.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using Eigen::Matrix3d;
using kernels::Kernels;
using kernels::Moments;
using test::FloatPoints;
using test::Random;
using test::Vector3d;
using test::Vector3f;

constexpr double kUnit = 0x1p-24;  // rounding of one float operation, relative

struct Request {
  float radius = 0.025f;
  float flat_rms = 0;
  int min_points = 1;
};

std::vector<Moments> moments(const Kernels& table, test::PackedCloud& cloud, const FloatPoints& centres,
                             const Request& request) {
  std::vector<float> xyz;
  for (const Vector3f& c : centres) xyz.insert(xyz.end(), c.data(), c.data() + 3);
  std::vector<Moments> out(centres.size() + 1);
  std::memset(out.data(), 0x5A, out.size() * sizeof(Moments));
  const Moments mark = out.back();
  table.moments(
      cloud.tiles(), cloud.candidates(),
      {xyz.data(), static_cast<std::int32_t>(centres.size()), request.radius, request.flat_rms, request.min_points},
      cloud.scratch(), out.data());
  EXPECT_TRUE(cloud.scratch_border_intact());
  EXPECT_TRUE(test::same_bits(out.back(), mark));
  out.pop_back();
  return out;
}

Matrix3d frame_of(const Moments& m) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R_frame_cloud);
}

/// The points of the ball in the frame of the moments, and how sure it is who belongs to it.
struct Neighbourhood {
  reference::Points points;
  int certain = 0, possible = 0;
};
Neighbourhood neighbourhood(const FloatPoints& cloud, const Vector3f& centre, float radius, const Matrix3d& R) {
  Neighbourhood n;
  for (const Vector3f& f : cloud) {
    if (!reference::is_measured(f.cast<double>())) continue;
    const Vector3d p = (f.cast<double>() - centre.cast<double>()) / radius;
    n.certain += p.norm() <= 1 - 4e-7;  // squared distances in float are good to a few units
    n.possible += p.norm() <= 1 + 4e-7;
    if (p.norm() <= 1) n.points.push_back(R * p);
  }
  return n;
}

/// What rounding may do to a sum. The kernel sums powers of the height over a rough plane, z - a x - b y with slopes of
/// up to 1, so z is made of numbers as large as |x| + |y| + |z|. Each of those is off by a few units (difference,
/// plane, scale), each product by a few more, and some dozens are added in float before they are carried to double;
/// roundings mostly cancel.
double tolerance(const reference::Points& points, const reference::Exponents& e) {
  double sum = 0;
  for (const Vector3d& point : points) {
    Vector3d p = point.cwiseAbs();
    p.z() = p.sum();
    sum += 24 * kUnit * reference::monomial(p, e);
    for (int axis = 0; axis < 3; ++axis) {
      if (e[axis] == 0) continue;
      reference::Exponents less = e;
      --less[axis];
      sum += 6 * kUnit * e[axis] * reference::monomial(p, less);
    }
  }
  return sum + 1e-12;
}

/// Checks one neighbourhood that was summed; false when rounding decides who belongs to it.
bool expect_moments(const FloatPoints& cloud, const Vector3f& centre, float radius, const Moments& m) {
  EXPECT_EQ(m.skipped, 0);
  const Matrix3d R = frame_of(m);
  EXPECT_LT((R * R.transpose() - Matrix3d::Identity()).norm(), 1e-6);
  EXPECT_NEAR(R.determinant(), 1, 1e-6);
  const Neighbourhood n = neighbourhood(cloud, centre, radius, R);
  EXPECT_GE(m.count, n.certain);
  EXPECT_LE(m.count, n.possible);
  EXPECT_EQ(m.sum[0], m.count);
  if (n.certain != n.possible) return false;
  const auto truth = reference::moment_sums<double>(n.points);
  for (int k = 0; k < kernels::kMoments; ++k) {
    const auto& e = reference::monomials()[k];
    EXPECT_NEAR(m.sum[k], truth[k], tolerance(n.points, e)) << "x^" << e[0] << " y^" << e[1] << " z^" << e[2];
  }
  return true;
}

/// Centres for a group: points of the cloud about its sample, and one well away from everything.
FloatPoints centres_near(Random& random, const FloatPoints& points, const Vector3f& sample, int n) {
  FloatPoints centres = {sample};
  for (int tries = 0; static_cast<int>(centres.size()) < n && tries < 5000; ++tries) {
    const Vector3f& p = points[random.index(points.size())];
    if ((p - sample).norm() < 0.03f) centres.push_back(p);
  }
  while (static_cast<int>(centres.size()) < n) centres.push_back(sample + random.normal3(0.01).cast<float>());
  if (n > 3) centres[2] = sample + Vector3f(3, 3, 3);
  return centres;
}

TEST(Moments, AgreeWithDoubleSums) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(81);
    int compared = 0, all = 0;
    for (const auto& cloud : test::ordinary_clouds(82, 6000)) {
      const FloatPoints points = test::with_bad_points(random, cloud.points, 12);
      for (bool ordered : {false, true})
        for (float radius : {0.01f, 0.025f}) {
          SCOPED_TRACE(cloud.name + (ordered ? ", compact tiles" : ", scattered tiles"));
          test::PackedCloud packed(*table, points, {16, ordered});
          const FloatPoints centres =
              centres_near(random, cloud.points, cloud.sample, 21);  // more than one round of 16
          const auto results = moments(*table, packed, centres, {radius, 0, 1});
          for (std::size_t i = 0; i < centres.size(); ++i) {
            if (i == 2) continue;  // nothing there: see below
            if (results[i].count == 0) continue;
            compared += expect_moments(points, centres[i], radius, results[i]);
            ++all;
          }
        }
    }
    EXPECT_GT(all, 800);
    EXPECT_GT(compared, all * 9 / 10);
  }
}

TEST(Moments, EveryTailLengthAndFilling) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(83);
    for (int n = 1; n <= 70; ++n)
      for (int fill : {16, 11, 1}) {
        SCOPED_TRACE(std::to_string(n) + " points, " + std::to_string(fill) + " a tile");
        const FloatPoints points = test::paraboloid(random, n, 20, 5, 0.03);
        test::PackedCloud packed(*table, points, {fill, false});
        const auto results = moments(*table, packed, {points[0], points[n / 2]}, {});
        expect_moments(points, points[0], 0.025f, results[0]);
        expect_moments(points, points[n / 2], 0.025f, results[1]);
      }
  }
}

TEST(Moments, TilesThatJustCrossTheBall) {
  // A tile counts as wholly inside only if it is, and as outside only if it is.
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(93);
    for (int trial = 0; trial < 200; ++trial) {
      const double off = std::pow(10, random.uniform(-6, -2)) * (trial % 2 ? 1 : -1);
      SCOPED_TRACE(off);
      const Vector3d corner = 0.025 * (1 + off) * random.direction();
      for (double other : {1.5, 0.2}) {
        const FloatPoints tile = test::tile_with_corner(random, corner, other * corner);
        test::PackedCloud packed(*table, tile);
        const auto results = moments(*table, packed, {{0, 0, 0}}, {0.025f, 0, 0});
        expect_moments(tile, {0, 0, 0}, 0.025f, results[0]);
      }
    }
  }
}

TEST(Moments, EveryGroupSize) {
  Random random(84);
  const FloatPoints points = test::sphere(random, 4000, 0.03);
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    test::PackedCloud packed(*table, points, {16, true});
    const FloatPoints centres(points.begin(), points.begin() + kernels::kMaxGroup);
    const auto whole = moments(*table, packed, centres, {});
    for (int n = 0; n <= kernels::kMaxGroup; ++n) {
      const auto part = moments(*table, packed, FloatPoints(centres.begin(), centres.begin() + n), {});
      // A neighbourhood's sums do not depend on its company.
      EXPECT_TRUE(test::same_bits(part, std::vector<Moments>(whole.begin(), whole.begin() + n))) << n;
    }
  }
}

TEST(Moments, LargeAndDenseNeighbourhoods) {
  // Tens of thousands of points: the place for overflowing buffers and for float sums that were carried too late.
  Random random(85);
  const FloatPoints points = test::cylinder(random, 40000, 0.02, 0.05, 2e-4);
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    for (bool ordered : {false, true}) {
      test::PackedCloud packed(*table, points, {ordered ? 16 : 13, ordered});
      const auto results = moments(*table, packed, {{0.02f, 0, 0}, {0, 0, 0}}, {0.06f, 0, 1});
      EXPECT_EQ(results[1].count, 40000);
      expect_moments(points, {0.02f, 0, 0}, 0.06f, results[0]);
      expect_moments(points, {0, 0, 0}, 0.06f, results[1]);
    }
  }
}

TEST(Moments, HeightIsTakenAlongTheNormal) {
  // The third axis of the frame is the one along which a surface is thin, so that small numbers are summed as such.
  Random random(86);
  for (int axis = 0; axis < 3; ++axis) {
    Matrix3d R = Matrix3d::Zero();
    for (int i = 0; i < 3; ++i) R((i + axis) % 3, i) = 1;  // moves the normal z to x, y, z in turn
    const Vector3d normal = R * Vector3d::UnitZ();
    const FloatPoints points =
        test::transformed(test::paraboloid(random, 5000, 15, 0, 0.06, 1e-4), R, {0.2, -0.3, 0.5});
    for (const Kernels* table : test::all_kernels()) {
      SCOPED_TRACE(table->name);
      test::PackedCloud packed(*table, points, {16, true});
      const auto results = moments(*table, packed, {Vector3f(0.2f, -0.3f, 0.5f)}, {});
      EXPECT_GT(std::abs(frame_of(results[0]).row(2).dot(normal)), 0.8);
    }
  }
}

TEST(Moments, KeepTheAxisOfASmoothSurface) {
  // The point of it all: the axis from the kernel's sums against the axis from double sums, on clean, dense, tilted
  // cylinders, where float sums without a rough plane lose it by degrees.
  Random random(87);
  std::vector<double> errors;
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    errors.clear();
    for (int trial = 0; trial < 40; ++trial) {
      const double r = random.uniform(0.015, 0.04);
      const Matrix3d R = random.rotation();
      const Vector3d t = random.uniform(0.4, 1.2) * random.direction();
      const FloatPoints points = test::transformed(test::cylinder(random, 8000, r, 0.08, 2e-4, M_PI), R, t);
      const Vector3f sample = (R * Vector3d(r, 0, 0) + t).cast<float>();
      test::PackedCloud packed(*table, points, {16, true});
      const Moments m = moments(*table, packed, {sample}, {})[0];
      const auto axis = [](const reference::MomentSums<double>& sums) {
        return reference::curvature(reference::fit_quadric(sums).coefficients, sums).at_foot.minor_direction;
      };
      const reference::MomentSums<double> sums = Eigen::Map<const reference::MomentSums<double>>(m.sum);
      const auto truth = reference::moment_sums<double>(
          reference::scaled_neighbourhood(test::to_double(points), sample.cast<double>(), 0.025f));
      errors.push_back(test::angle_between(frame_of(m).transpose() * axis(sums), axis(truth)));
    }
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() / 2], 0.002);
    EXPECT_LT(errors.back(), 0.01);  // rad
  }
}

TEST(Moments, TooFewPointsAreCountedAndSkipped) {
  Random random(88);
  const FloatPoints points = test::cube(random, 29, 0.01);
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    test::PackedCloud packed(*table, points);
    for (int min_points : {1, 29, 30, 1000}) {
      const auto results = moments(*table, packed, {{0, 0, 0}, {5, 5, 5}, {0, 0, 0.001f}}, {0.025f, 0, min_points});
      for (int i : {0, 2}) {
        EXPECT_EQ(results[i].count, 29);
        EXPECT_EQ(results[i].skipped, min_points > 29);
        if (min_points <= 29)
          expect_moments(points, i ? Vector3f(0, 0, 0.001f) : Vector3f(0, 0, 0), 0.025f, results[i]);
      }
      EXPECT_EQ(results[1].count, 0);
      EXPECT_EQ(results[1].skipped, 1);
    }
  }
}

TEST(Moments, FlatNeighbourhoodsAreSkipped) {
  Random random(89);
  const Request request{0.025f, 0.0015f, 30};
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    for (int trial = 0; trial < 20; ++trial) {
      const Matrix3d R = random.rotation();
      const Vector3d t = random.normal3(0.4);
      const auto skipped = [&](const FloatPoints& shape, const Vector3d& at) {
        const FloatPoints points = test::transformed(shape, R, t);
        test::PackedCloud packed(*table, points, {16, true});
        const Vector3f sample = (R * at + t).cast<float>();
        const Moments m = moments(*table, packed, {sample, sample}, request)[1];
        if (!m.skipped) expect_moments(points, sample, request.radius, m);
        return m.skipped != 0;
      };
      // Half and twice the limit: the test works on whole tiles and need not be sharp.
      EXPECT_TRUE(skipped(test::plane(random, 6000, 0.1, 0.00075), {0, 0, 0}));
      EXPECT_FALSE(skipped(test::plane(random, 6000, 0.1, 0.003), {0, 0, 0}));
      EXPECT_FALSE(skipped(test::cylinder(random, 8000, 0.02, 0.1, 2e-4), {0.02, 0, 0}));
      EXPECT_FALSE(skipped(test::box_corner(random, 8000, 0.06), {0.002, 0.002, 0.002}));
    }
  }
}

TEST(Moments, DegenerateCloudsAreSummedAndFlat) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    for (const auto& cloud : test::degenerate_clouds(90)) {
      SCOPED_TRACE(cloud.name);
      test::PackedCloud packed(*table, cloud.points);
      const Moments m = moments(*table, packed, {cloud.sample}, {})[0];
      if (m.skipped) {
        EXPECT_EQ(m.count, 0);
        EXPECT_EQ(packed.finite(), 0);
        continue;
      }
      expect_moments(cloud.points, cloud.sample, 0.025f, m);
      // Tilted, the coordinates' own rounding makes a plane 1e-6 of the radius thick: still flat.
      const reference::MomentSums<double> sums = Eigen::Map<const reference::MomentSums<double>>(m.sum);
      EXPECT_TRUE(reference::fit_quadric(sums).flat);
    }
  }
}

TEST(Moments, VectorTablesAgreeToTheBit) {
  const auto tables = test::bitwise_kernels();
  Random random(91);
  for (const auto& cloud : test::ordinary_clouds(92, 4000)) {
    SCOPED_TRACE(cloud.name);
    const FloatPoints points = test::with_bad_points(random, cloud.points, 15);
    const FloatPoints centres = centres_near(random, cloud.points, cloud.sample, kernels::kMaxGroup);
    for (bool ordered : {false, true})
      for (float flat_rms : {0.f, 0.001f}) {
        std::vector<std::vector<Moments>> results;
        for (const Kernels* table : tables) {
          test::PackedCloud packed(*table, points, {16, ordered});
          results.push_back(moments(*table, packed, centres, {0.025f, flat_rms, 30}));
          ASSERT_EQ(results.back().size(), results.front().size());
          for (std::size_t i = 0; i < centres.size(); ++i) {
            const Moments &a = results.back()[i], &b = results.front()[i];
            EXPECT_EQ(a.count, b.count);
            ASSERT_EQ(a.skipped, b.skipped);
            if (a.skipped) continue;
            EXPECT_TRUE(test::same_bits(a.sum, b.sum) && test::same_bits(a.R_frame_cloud, b.R_frame_cloud))
                << table->name << " and " << tables[0]->name << ", neighbourhood " << i;
          }
        }
      }
  }
}

}  // namespace
}  // namespace handhold
