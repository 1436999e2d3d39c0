// Tiles and neighbourhoods: finish_block and collect against plain loops, for every instruction set.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "reference/reference.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using kernels::Kernels;
using test::FloatPoints;
using test::Random;
using test::Vector3d;
using test::Vector3f;

// ---- finish_block -------------------------------------------------------------------------------------------------

struct Block {
  std::array<test::Line, 48> points;
  std::array<test::Line, 6> box;
  std::array<test::Line, 10> sums;
  std::uint16_t full = 0;
  std::int32_t count = 0;
};

/// 256 slots: a full cloud about `offset`, with a share of them not measured.
Block random_block(Random& random, double offset, double missing) {
  Block block{};
  const Vector3d at = offset * random.direction();
  const float bad[] = {test::kNan, test::kInfinity, -test::kInfinity, 1.1e6f, -3e9f, kernels::kFar};
  for (int tile = 0; tile < 16; ++tile) {
    const double share = tile == 0 ? 0 : tile == 1 ? 1 : missing;  // one full tile, one empty
    for (int lane = 0; lane < 16; ++lane) {
      const Vector3d p = at + random.normal3(0.01);
      for (int axis = 0; axis < 3; ++axis) block.points[3 * tile + axis].v[lane] = static_cast<float>(p[axis]);
      if (random.uniform(0, 1) < share) {
        const std::size_t axis = random.index(3);
        block.points[3 * tile + axis].v[lane] = bad[random.index(6)];
      }
    }
  }
  return block;
}

Block finished(const Kernels& table, Block block) {
  block.count = table.finish_block(block.points[0].v, block.box[0].v, &block.full, block.sums[0].v);
  return block;
}

TEST(FinishBlock, AgreesWithPlainLoops) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(71);
    for (int trial = 0; trial < 60; ++trial) {
      const Block before = random_block(random, trial % 3, trial % 4 * 0.3);
      const Block after = finished(*table, before);
      std::int32_t total = 0;
      for (int tile = 0; tile < 16; ++tile) {
        SCOPED_TRACE("tile " + std::to_string(tile));
        std::vector<Vector3d> valid;
        Vector3f low = Vector3f::Constant(kernels::kFar), high = Vector3f::Constant(-kernels::kFar);
        for (int lane = 0; lane < 16; ++lane) {
          Vector3f p, q;
          for (int axis = 0; axis < 3; ++axis) {
            p[axis] = before.points[3 * tile + axis].v[lane];
            q[axis] = after.points[3 * tile + axis].v[lane];
          }
          if (!reference::is_measured(p.cast<double>())) {
            EXPECT_EQ(q, Vector3f::Constant(kernels::kFar));
            continue;
          }
          EXPECT_EQ(q, p);
          valid.push_back(p.cast<double>());
          low = low.cwiseMin(p), high = high.cwiseMax(p);
        }
        total += static_cast<std::int32_t>(valid.size());
        EXPECT_EQ((after.full >> tile & 1) != 0, valid.size() == 16);
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_EQ(after.box[axis].v[tile], low[axis]);
          EXPECT_EQ(after.box[3 + axis].v[tile], high[axis]);
        }
        EXPECT_EQ(after.sums[0].v[tile], static_cast<float>(valid.size()));
        if (valid.empty()) {
          for (const test::Line& sum : after.sums) EXPECT_TRUE(std::isfinite(sum.v[tile]));
          continue;
        }
        Vector3d mean = Vector3d::Zero();
        for (const Vector3d& p : valid) mean += p / static_cast<double>(valid.size());
        Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
        for (const Vector3d& p : valid) second += (p - mean) * (p - mean).transpose();
        // The mean is a float near 1 .. 2 m; second moments are sums of 16 squares of centimetres, about a corner of
        // the box.
        for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(after.sums[1 + axis].v[tile], mean[axis], 3e-7);
        const double s[6] = {second(0, 0), second(0, 1), second(0, 2), second(1, 1), second(1, 2), second(2, 2)};
        const double extent2 = (high - low).cast<double>().squaredNorm();
        for (int k = 0; k < 6; ++k) EXPECT_NEAR(after.sums[4 + k].v[tile], s[k], 16 * extent2 * 1e-6);
      }
      EXPECT_EQ(after.count, total);
    }
  }
}

TEST(FinishBlock, TwiceIsOnce) {
  // kFar is itself beyond the largest coordinate, so that a block may be finished again.
  Random random(72);
  const Block before = random_block(random, 1, 0.3);
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    const Block once = finished(*table, before);
    EXPECT_TRUE(test::same_bits(finished(*table, once), once));
  }
}

TEST(FinishBlock, VectorTablesAgreeToTheBit) {
  const auto tables = test::bitwise_kernels();
  Random random(73);
  for (int trial = 0; trial < 100; ++trial) {
    const Block before = random_block(random, trial % 5, 0.1 * (trial % 11));
    const Block first = finished(*tables[0], before);
    for (const Kernels* table : tables) {
      const Block other = finished(*table, before);
      EXPECT_TRUE(test::same_bits(other.points, first.points) && test::same_bits(other.box, first.box) &&
                  test::same_bits(other.sums, first.sums))
          << table->name;
      EXPECT_EQ(other.full, first.full);
      EXPECT_EQ(other.count, first.count);
    }
  }
}

// ---- collect ------------------------------------------------------------------------------------------------------

using Offsets = std::vector<std::array<float, 3>>;

/// Offsets from the centre of all points found, in the kernel's order.
Offsets collect(const Kernels& table, test::PackedCloud& cloud, const Vector3f& centre, float radius) {
  const std::size_t capacity = static_cast<std::size_t>(cloud.blocks()) * 256 + 16;
  constexpr float kMark = -12345;
  test::Lines out[3];
  for (test::Lines& lines : out) {
    lines.resize(capacity / 16 + 2);
    for (test::Line& line : lines) std::fill(std::begin(line.v), std::end(line.v), kMark);
  }
  const std::int32_t n = table.collect(cloud.tiles(), cloud.candidates(), centre.data(), radius, cloud.scratch(),
                                       test::floats(out[0]), test::floats(out[1]), test::floats(out[2]));
  EXPECT_TRUE(cloud.scratch_border_intact());
  Offsets offsets;
  for (std::int32_t i = 0; i < n; ++i) {
    const auto at = [i](const test::Lines& lines) { return lines[static_cast<std::size_t>(i / 16)].v[i % 16]; };
    offsets.push_back({at(out[0]), at(out[1]), at(out[2])});
  }
  for (const test::Lines& lines : out)
    for (std::size_t i = capacity; i < lines.size() * 16; ++i) EXPECT_EQ(lines[i / 16].v[i % 16], kMark);
  return offsets;
}

/// What must be found, and what may be: squared distances in float are good to a few 2^-24.
struct Expected {
  Offsets certain, possible;
};
Expected expected(const FloatPoints& points, const Vector3f& centre, float radius) {
  Expected e;
  for (const Vector3f& p : points) {
    if (!reference::is_measured(p.cast<double>())) continue;
    const Vector3f d = p - centre;  // float, as the kernel's: the same bits
    const double ratio = (p.cast<double>() - centre.cast<double>()).norm() / radius;
    if (ratio <= 1 + 4e-7) e.possible.push_back({d.x(), d.y(), d.z()});
    if (ratio <= 1 - 4e-7) e.certain.push_back({d.x(), d.y(), d.z()});
  }
  std::sort(e.certain.begin(), e.certain.end());
  std::sort(e.possible.begin(), e.possible.end());
  return e;
}

void expect_neighbours(const Kernels& table, const FloatPoints& points, const Vector3f& centre, float radius,
                       const test::Packing& packing) {
  test::PackedCloud cloud(table, points, packing);
  Offsets found = collect(table, cloud, centre, radius);
  std::sort(found.begin(), found.end());
  const Expected e = expected(points, centre, radius);
  EXPECT_TRUE(std::includes(found.begin(), found.end(), e.certain.begin(), e.certain.end()));
  EXPECT_TRUE(std::includes(e.possible.begin(), e.possible.end(), found.begin(), found.end()));
}

TEST(Neighbours, AgreeWithBruteForce) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(74);
    for (const auto& cloud : test::ordinary_clouds(75, 4000)) {
      SCOPED_TRACE(cloud.name);
      const FloatPoints mixed = test::with_bad_points(random, cloud.points, 10);
      for (float radius : {0.003f, 0.01f, 0.025f, 0.5f})
        for (bool ordered : {false, true}) expect_neighbours(*table, mixed, cloud.sample, radius, {16, ordered});
    }
    for (const auto& cloud : test::degenerate_clouds(76)) {
      SCOPED_TRACE(cloud.name);
      expect_neighbours(*table, cloud.points, cloud.sample, 0.025f, {});
    }
  }
}

TEST(Neighbours, EveryTailLengthAndFilling) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(77);
    for (int n = 0; n <= 70; ++n)
      for (int fill : {16, 15, 9, 1}) {
        SCOPED_TRACE(std::to_string(n) + " points, " + std::to_string(fill) + " a tile");
        expect_neighbours(*table, test::cube(random, n, 0.06), {0.005f, 0, 0}, 0.025f, {fill, n % 2 == 0});
      }
  }
}

TEST(Neighbours, BallIsClosed) {
  // Distances that are exactly the radius, in float too.
  const FloatPoints points = {{1.5f, 2, 3},    {0.5f, 2, 3},       {1, 2.5f, 3},      {1, 2, 2.5f},
                              {1.3f, 2.4f, 3}, {1.5000001f, 2, 3}, {1, 2, 2.4999998f}};
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    test::PackedCloud cloud(*table, FloatPoints(points.begin(), points.begin() + 4));
    EXPECT_EQ(collect(*table, cloud, {1, 2, 3}, 0.5f).size(), 4u);
    test::PackedCloud outside(*table, FloatPoints(points.begin() + 5, points.end()));
    EXPECT_TRUE(collect(*table, outside, {1, 2, 3}, 0.5f).empty());
  }
}

TEST(Neighbours, TilesThatJustTouchTheBall) {
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    Random random(80);
    for (int trial = 0; trial < 200; ++trial) {
      const double off = std::pow(10, random.uniform(-6, -2)) * (trial % 2 ? 1 : -1);
      SCOPED_TRACE(off);
      const Vector3d corner = 0.025 * (1 + off) * random.direction();
      const Vector3d at = random.normal3(0.05);
      // the corner is the tile's nearest point, then its farthest
      for (double other : {1.5, 0.2}) {
        const FloatPoints tile =
            test::transformed(test::tile_with_corner(random, corner, other * corner), Eigen::Matrix3d::Identity(), at);
        expect_neighbours(*table, tile, at.cast<float>(), 0.025f, {});
      }
    }
  }
}

TEST(Neighbours, FarFromTheOriginAndFarApart) {
  Random random(78);
  FloatPoints points = test::cube(random, 1000, 0.1);
  for (Vector3f& p : points) p += Vector3f(900, -700, 500);
  const FloatPoints near = points;
  points.push_back({1e6f, 1e6f, 1e6f});
  points.push_back({-1e6f, 1e6f, -1e6f});
  for (const Kernels* table : test::all_kernels()) {
    SCOPED_TRACE(table->name);
    expect_neighbours(*table, points, near[17], 0.025f, {16, true});
    expect_neighbours(*table, points, {1e6f, 1e6f, 1e6f}, 0.025f, {});
    expect_neighbours(*table, points, near[0], 1e5f, {});  // a ball that holds everything but the two
  }
}

TEST(Neighbours, VectorTablesAgreeToTheBit) {
  const auto tables = test::bitwise_kernels();
  for (const auto& cloud : test::ordinary_clouds(79, 3000)) {
    SCOPED_TRACE(cloud.name);
    test::PackedCloud first_cloud(*tables[0], cloud.points);
    const Offsets first = collect(*tables[0], first_cloud, cloud.sample, 0.02f);
    for (const Kernels* table : tables) {
      test::PackedCloud other(*table, cloud.points);
      EXPECT_TRUE(test::same_bits(collect(*table, other, cloud.sample, 0.02f), first)) << table->name;
    }
  }
}

}  // namespace
}  // namespace handhold
