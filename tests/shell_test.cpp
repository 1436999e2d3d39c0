// The shell kernels against an exhaustive search over every radius that could be an answer, for every instruction set.
#include <gtest/gtest.h>

#include <cmath>

#include "reference/reference.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using Eigen::Vector3d;
using kernels::Kernels;
using kernels::ShellQuery;
using kernels::ShellResult;
using test::FloatPoints;
using test::Random;

reference::ShellQuery to_reference(const ShellQuery& q) {
  return {q.start_radius, q.max_radius, q.gap, q.max_gap_points, q.min_inner_points};
}

kernels::ShellStatus to_kernel(reference::ShellStatus status) {
  switch (status) {
    case reference::ShellStatus::kFound:
      return kernels::kShellFound;
    case reference::ShellStatus::kNoGap:
      return kernels::kShellNoGap;
    default:
      return kernels::kShellEmpty;
  }
}

/// Squared distances, padded with kFar to a multiple of 16 as shell_gap asks for.
test::Lines squared(const std::vector<double>& rho) {
  test::Lines lines((rho.size() + 15) / 16);
  for (std::size_t i = 0; i < lines.size() * 16; ++i)
    lines[i / 16].v[i % 16] = i < rho.size() ? static_cast<float>(rho[i]) * static_cast<float>(rho[i]) : kernels::kFar;
  return lines;
}

ShellResult shell_gap(const Kernels& table, const std::vector<double>& rho, const ShellQuery& query) {
  const test::Lines lines = squared(rho);
  ShellResult result{-1, kernels::kFar, kernels::kFar, -1, -1};
  static const test::Line none{};
  table.shell_gap(lines.empty() ? none.v : test::floats(lines), static_cast<std::int32_t>(rho.size()), query, result);
  return result;
}

/// Checks a result within rounding, `eps` (m) on every distance and on the gap's width. With every distance known to
/// eps, the true answer lies between those for a gap that is 2 eps narrower and one that is 2 eps wider.
/// Returns whether both agree, so that there was something to check.
bool expect_within_rounding(const std::vector<double>& rho, const ShellQuery& query, const ShellResult& result,
                            double eps) {
  reference::ShellQuery easy = to_reference(query), hard = easy;
  easy.gap -= 2 * eps, easy.max_radius += eps;
  hard.gap += 2 * eps, hard.max_radius -= eps;
  const auto earliest = reference::find_shell_exhaustively(rho, easy);
  const auto latest = reference::find_shell_exhaustively(rho, hard);
  if (latest.status == reference::ShellStatus::kFound) {
    EXPECT_EQ(result.status, kernels::kShellFound);
    EXPECT_LE(result.radius, latest.radius + eps);  // never later
  }
  if (latest.status != reference::ShellStatus::kNoGap) {
    EXPECT_NE(result.status, kernels::kShellNoGap);
  }
  if (earliest.status == reference::ShellStatus::kNoGap) {
    EXPECT_EQ(result.status, kernels::kShellNoGap);
  }
  if (result.status == kernels::kShellFound) {
    EXPECT_EQ(earliest.status, reference::ShellStatus::kFound);
    EXPECT_GE(result.radius, earliest.radius - eps);  // never too early
    EXPECT_LE(result.radius, query.max_radius + eps);
    EXPECT_LE(result.free_to, query.max_radius + query.gap + eps);
    EXPECT_GE(result.free_to, result.radius + query.gap - 2 * eps);
    const auto count = [&rho](double low, double high) {
      return std::count_if(rho.begin(), rho.end(), [&](double d) { return d > low && d < high; });
    };
    const double r = result.radius, outer = r + query.gap;
    EXPECT_GE(result.inner_points, count(-1, r - eps));
    EXPECT_LE(result.inner_points, count(-1, r + eps));
    EXPECT_GE(result.inner_points, query.min_inner_points);
    EXPECT_GE(result.gap_points, count(r + eps, outer - eps));
    EXPECT_LE(result.gap_points, count(r - eps, outer + eps));
    EXPECT_LE(result.gap_points, query.max_gap_points);
    EXPECT_LE(count(r + eps, result.free_to - eps), query.max_gap_points);
    if (result.free_to < query.max_radius + query.gap - eps) {
      EXPECT_GT(count(r - eps, result.free_to + eps), query.max_gap_points);  // it could not be larger
    }
  }
  return earliest.status == latest.status &&
         (earliest.status != reference::ShellStatus::kFound || std::abs(earliest.radius - latest.radius) <= 2 * eps);
}

constexpr double kGrid = 0x1p-10;  // m; squares and sums of its multiples up to 4 m are exact in float

/// Distances and queries on a grid where float arithmetic is exact, full of ties: many equal distances, many exactly on
/// the border of a gap.
struct ExactCase {
  std::vector<double> rho;
  ShellQuery query{};
};
ExactCase exact_case(Random& random, std::size_t n) {
  ExactCase one;
  const auto on_grid = [&random](int low, int high) {
    return kGrid * (low + static_cast<int>(random.index(static_cast<std::size_t>(high - low))));
  };
  const int spread = 1 + static_cast<int>(random.index(150));
  for (std::size_t i = 0; i < n; ++i) one.rho.push_back(on_grid(0, spread));
  one.query.start_radius = static_cast<float>(on_grid(0, 40));
  one.query.max_radius = static_cast<float>(on_grid(1, 160));
  one.query.gap = static_cast<float>(on_grid(1, 24));
  one.query.max_gap_points = static_cast<std::int32_t>(random.index(1 + n / 4));
  one.query.min_inner_points = 1 + static_cast<std::int32_t>(random.index(n + 2));
  return one;
}

void expect_exactly(const std::vector<double>& rho, const ShellQuery& query, const ShellResult& result) {
  const auto truth = reference::find_shell_exhaustively(rho, to_reference(query));
  ASSERT_EQ(result.status, to_kernel(truth.status));
  if (truth.status != reference::ShellStatus::kFound) return;
  ASSERT_EQ(result.radius, static_cast<float>(truth.radius));
  ASSERT_EQ(result.free_to, static_cast<float>(truth.free_to));
  ASSERT_EQ(result.inner_points, truth.inner_points);
  ASSERT_EQ(result.gap_points, truth.gap_points);
}

TEST(ShellGap, AgreesWithExhaustiveSearchExactly) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(51);
    int outcomes[3] = {};
    for (int trial = 0; trial < 2000; ++trial) {
      SCOPED_TRACE("trial " + std::to_string(trial));
      const ExactCase one = exact_case(random, static_cast<std::size_t>(trial % 97));  // every tail length
      const ShellResult result = shell_gap(*table, one.rho, one.query);
      expect_exactly(one.rho, one.query, result);
      if (HasFatalFailure()) return;
      ++outcomes[result.status];
    }
    for (int n : outcomes) EXPECT_GT(n, 150);
  }
}

TEST(ShellGap, AgreesWithinRoundingOnContinuousRadii) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(52);
    int decided = 0;
    constexpr int kTrials = 500;
    for (int trial = 0; trial < kTrials; ++trial) {
      SCOPED_TRACE("trial " + std::to_string(trial));
      // like an object with something around it: a noisy circle, a wall, and a little of everything
      std::vector<double> rho;
      const double r = random.uniform(0.005, 0.035), wall = r + random.uniform(0.005, 0.03);
      const std::size_t n = random.index(500);
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t kind = random.index(10);
        rho.push_back(std::abs(kind < 6   ? r + random.normal(1e-3)
                               : kind < 9 ? random.uniform(wall, 0.08)
                                          : random.uniform(0, 0.08)));
      }
      ShellQuery query{};
      query.start_radius = static_cast<float>(0.7 * r);
      query.max_radius = static_cast<float>(random.uniform(0.02, 0.05));
      query.gap = static_cast<float>(random.uniform(0.003, 0.015));
      query.max_gap_points = static_cast<std::int32_t>(random.index(1 + n / 6));
      query.min_inner_points = static_cast<std::int32_t>(1 + random.index(1 + n / 2));
      // squares and roots in float: a few 2^-24 of 0.1 m
      decided += expect_within_rounding(rho, query, shell_gap(*table, rho, query), 5e-8);
    }
    EXPECT_GT(decided, kTrials * 95 / 100);
  }
}

TEST(ShellGap, EverySmallerRadiusIsBlocked) {
  // The property itself, without a search: k+1 points in the gap of each smaller radius, or too few points within.
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(53);
    for (int trial = 0; trial < 150; ++trial) {
      const ExactCase one = exact_case(random, 150);
      const ShellResult result = shell_gap(*table, one.rho, one.query);
      const double end = result.status == kernels::kShellFound ? result.radius : one.query.max_radius + kGrid / 2;
      for (double r = one.query.start_radius; r < end; r += kGrid / 2) {  // between the grid's lines, too
        int inner = 0, between = 0;
        for (double d : one.rho) inner += d <= r, between += d > r && d < r + one.query.gap;
        ASSERT_TRUE(between > one.query.max_gap_points || inner < one.query.min_inner_points)
            << "r = " << r << " was passed over; the kernel ended at " << end;
      }
    }
  }
}

TEST(ShellGap, CornersOfTheDefinition) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    const auto query = [](double start, double max, double gap, int k, int m) {
      ShellQuery q{};
      q.start_radius = static_cast<float>(start), q.max_radius = static_cast<float>(max),
      q.gap = static_cast<float>(gap);
      q.max_gap_points = k, q.min_inner_points = m;
      return q;
    };
    const auto check = [&](const std::vector<double>& rho, const ShellQuery& q) {
      expect_exactly(rho, q, shell_gap(*table, rho, q));
    };
    check({}, query(0, 0.5, 0.25, 0, 1));                                 // nothing: free, but empty
    check({0, 0, 0}, query(0, 0.5, 0.25, 0, 3));                          // all on the axis
    check(std::vector<double>(33, 0.25), query(0.25, 0.5, 0.25, 0, 33));  // all at the start: inside
    check(std::vector<double>(33, 0.5), query(0.25, 0.5, 0.25, 0, 33));   // all on the outer border of the first gap
    check(std::vector<double>(33, 0.375), query(0.25, 0.5, 0.25, 0, 33));
    check(std::vector<double>(33, 0.375), query(0.25, 0.5, 0.25, 32, 1));
    check(std::vector<double>(33, 0.375), query(0.25, 0.5, 0.25, 33, 1));
    check({0.125, 0.75}, query(0.5, 0.5, 0.25, 0, 1));   // one radius only
    check({0.125, 0.25}, query(0.75, 0.5, 0.25, 0, 1));  // no radius at all
    check({0.125, 0.25}, query(0, 0.5, 0.25, 1000, 1));  // more than all may lie in the gap
    check({0.125, 0.25}, query(0, 0.5, 0.25, 0, 1000));  // more are asked for than there are
    check({0.125, 0.5}, query(0, 0.5, 0.125, 0, 2));     // the last point is just allowed
    check({0.125, 0.625}, query(0, 0.5, 0.125, 0, 2));   // and just not
  }
}

// ---- On tiles -----------------------------------------------------------------------------------------------------

ShellResult find_shell(const Kernels& table, test::PackedCloud& cloud, const ShellQuery& query) {
  ShellResult result{-1, kernels::kFar, kernels::kFar, -1, -1};
  table.shell(cloud.tiles(), cloud.candidates(), query, cloud.scratch(), result);
  EXPECT_TRUE(cloud.scratch_border_intact());
  return result;
}

/// A query about a cylinder-like place, in the frame of a cloud. The axis is rounded to float before anyone uses it.
ShellQuery query_at(Random& random, const Vector3d& centre, const Vector3d& axis) {
  ShellQuery query{};
  for (int i = 0; i < 3; ++i) {
    query.centre[i] = static_cast<float>(centre[i]);
    query.axis[i] = static_cast<float>(axis[i]);
  }
  query.half_width = static_cast<float>(random.uniform(0.005, 0.02));
  query.start_radius = static_cast<float>(random.uniform(0, 0.02));
  query.max_radius = static_cast<float>(random.uniform(0.02, 0.045));
  query.gap = static_cast<float>(random.uniform(0.003, 0.012));
  query.max_gap_points = static_cast<std::int32_t>(random.index(20));
  query.min_inner_points = static_cast<std::int32_t>(1 + random.index(60));
  return query;
}
Vector3d vector_of(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}

/// The points without those whose membership in the slab |axial offset| <= half_width rounding decides.
FloatPoints without_borderline(const FloatPoints& points, const ShellQuery& query) {
  FloatPoints kept;
  for (const auto& p : points) {
    const double along = std::abs((p.cast<double>() - vector_of(query.centre)).dot(vector_of(query.axis)));
    if (!(std::abs(along - query.half_width) < 1e-6)) kept.push_back(p);
  }
  return kept;
}

/// A rod that stands in a room: something to hold, with a gap or not.
FloatPoints rod_scene(Random& random, int n) {
  const double r = random.uniform(0.008, 0.03);
  FloatPoints points = test::cylinder(random, n, r, 0.2, random.uniform(0, 1e-3), M_PI);
  if (random.index(2))
    points = test::joined(points, test::cylinder(random, n, r + random.uniform(0.005, 0.03), 0.2, 2e-3));
  if (random.index(2)) points = test::joined(points, test::cube(random, n / 20, 0.2));
  return points;
}

TEST(Shell, OnTilesAgreesWithExhaustiveSearch) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(54);
    int decided = 0, outcomes[3] = {};
    constexpr int kTrials = 250;
    for (int trial = 0; trial < kTrials; ++trial) {
      SCOPED_TRACE("trial " + std::to_string(trial));
      const Eigen::Matrix3d R = random.rotation();
      const Vector3d t = random.normal3(0.3);
      FloatPoints points = test::transformed(rod_scene(random, 200 + static_cast<int>(random.index(2500))), R, t);
      if (trial % 5 == 0) points = test::with_bad_points(random, points, 7);
      const ShellQuery query = query_at(random, t + random.normal3(2e-3), R.col(2));
      points = without_borderline(points, query);
      if (trial % 2) random.shuffle(points);
      test::PackedCloud cloud(*table, points, {1 + trial % 16, trial % 2 == 0});
      const auto rho = reference::distances_to_axis(test::to_double(points), vector_of(query.centre),
                                                    vector_of(query.axis), query.half_width);
      const ShellResult result = find_shell(*table, cloud, query);
      // differences of float coordinates are good to 2^-24 of 0.1 m; then projections of a few terms
      decided += expect_within_rounding(rho, query, result, 1e-7);
      ASSERT_GE(result.status, 0);
      ASSERT_LE(result.status, 2);
      ++outcomes[result.status];
    }
    EXPECT_GT(decided, kTrials * 9 / 10);
    for (int n : outcomes) EXPECT_GT(n, 5);
  }
}

TEST(Shell, EveryTailLength) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(55);
    for (int n = 0; n <= 70; ++n) {
      SCOPED_TRACE(n);
      // multiples of the grid in a plane across the z axis along the x axis: distances are exact, and so is the answer
      ExactCase one = exact_case(random, static_cast<std::size_t>(n));
      FloatPoints points;
      for (std::size_t i = 0; i < one.rho.size(); ++i) {
        const float rho = static_cast<float>(i % 2 ? one.rho[i] : -one.rho[i]);
        points.emplace_back(1 + rho, 2.f, 3 + static_cast<float>(kGrid) * static_cast<float>(i % 3));
      }
      one.query.centre[0] = 1, one.query.centre[1] = 2, one.query.centre[2] = 3;
      one.query.axis[2] = 1;
      one.query.half_width =
          2 * static_cast<float>(kGrid);  // the third height lies exactly on the slab's border: inside
      for (int fill : {16, 5, 1}) {
        test::PackedCloud cloud(*table, points, {fill, false});
        expect_exactly(one.rho, one.query, find_shell(*table, cloud, one.query));
      }
    }
  }
}

TEST(Shell, DoesNotDependOnHowPointsArePacked) {
  // Only the order of distances matters, so the answer is the same to the bit for every order of the points.
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(56);
    for (int trial = 0; trial < 40; ++trial) {
      FloatPoints points = rod_scene(random, 1500);
      const ShellQuery query = query_at(random, {0, 0, 0}, {0, 0, 1});
      test::PackedCloud first(*table, points, {16, true});
      const ShellResult result = find_shell(*table, first, query);
      for (int fill : {16, 7}) {
        random.shuffle(points);
        test::PackedCloud other(*table, points, {fill, false});
        EXPECT_TRUE(test::same_bits(find_shell(*table, other, query), result));
      }
    }
  }
}

TEST(Shell, DegenerateClouds) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(57);
    for (const auto& cloud : test::degenerate_clouds(58)) {
      SCOPED_TRACE(cloud.name);
      for (int trial = 0; trial < 10; ++trial) {
        const ShellQuery query =
            query_at(random, cloud.sample.cast<double>() + random.normal3(0.005), random.direction());
        const FloatPoints points = without_borderline(cloud.points, query);
        test::PackedCloud packed(*table, points);
        const auto rho = reference::distances_to_axis(test::to_double(points), vector_of(query.centre),
                                                      vector_of(query.axis), query.half_width);
        expect_within_rounding(rho, query, find_shell(*table, packed, query), 1e-7);
      }
    }
  }
}

TEST(Shell, VectorTablesAgreeToTheBit) {
  const auto tables = test::bitwise_kernels();
  Random random(59);
  for (int trial = 0; trial < 100; ++trial) {
    const auto points = test::with_bad_points(random, rod_scene(random, 1000), 20);
    const ShellQuery query =
        query_at(random, random.normal3(2e-3), (Vector3d(0, 0, 1) + random.normal3(0.1)).normalized());
    std::vector<double> rho;
    for (int i = 0; i < 200; ++i) rho.push_back(random.uniform(0, 0.06));
    std::vector<ShellResult> on_tiles, on_radii;
    for (const Kernels* table : tables) {
      test::PackedCloud cloud(*table, points, {16, trial % 2 == 0});
      on_tiles.push_back(find_shell(*table, cloud, query));
      on_radii.push_back(shell_gap(*table, rho, query));
      EXPECT_TRUE(test::same_bits(on_tiles.back(), on_tiles.front())) << table->name << " and " << tables[0]->name;
      EXPECT_TRUE(test::same_bits(on_radii.back(), on_radii.front())) << table->name << " and " << tables[0]->name;
    }
  }
}

}  // namespace
}  // namespace handhold
