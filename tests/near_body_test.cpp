// The points of a cloud near a body, and pixels near their neighbours: the kernels against plain loops in double
// precision, for every instruction set.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "body_queries.h"
#include "kernels.h"
#include "test_tiles.h"

namespace handhold {
namespace {

using kernels::BodyQuery;
using kernels::Kernels;
using test::FloatPoints;
using test::Line;
using test::Lines;
using test::Random;
using test::Vector3d;
using test::Vector3f;

/// The boxes of sixteen boxes each, in records of sixteen; `count` of the boxes below are there.
Lines level_above(const float* below, std::size_t count) {
  const std::size_t boxes = (count + 15) / 16, records = (boxes + 15) / 16;
  Lines level(6 * records);
  for (std::size_t i = 0; i < 16 * records; ++i) {
    for (std::size_t side = 0; side < 6; ++side) {
      float bound = side < 3 ? kernels::kFar : -kernels::kFar;
      for (std::size_t k = 0; i < boxes && k < 16; ++k) {
        const float value = below[96 * i + 16 * side + k];
        bound = side < 3 ? std::min(bound, value) : std::max(bound, value);
      }
      level[6 * (i / 16) + side].v[i % 16] = bound;
    }
  }
  return level;
}

/// A cloud in tiles, under a tree made by plain code.
struct PackedTree {
  PackedTree(const Kernels& table, const FloatPoints& points, const test::Packing& packing = {})
      : cloud(table, points, packing) {
    const auto n = static_cast<std::size_t>(cloud.blocks());
    blocks = level_above(floats(cloud.boxes()), 16 * n);
    groups = level_above(floats(blocks), n);
    regions = level_above(floats(groups), (n + 15) / 16);
  }
  kernels::TileTree view() const {
    return {floats(cloud.points()), floats(cloud.boxes()), floats(blocks),
            floats(groups),         floats(regions),       static_cast<std::int32_t>(16 * regions.size() / 6)};
  }
  Vector3f point(std::int64_t number) const {
    const float* p = floats(cloud.points()) + 48 * (number / 16) + number % 16;
    return {p[0], p[16], p[32]};
  }

  test::PackedCloud cloud;
  Lines blocks, groups, regions;
};

std::vector<test::NamedCloud> clouds() {
  Random random(511);
  std::vector<test::NamedCloud> all = test::ordinary_clouds(512, 3000);
  for (test::NamedCloud& cloud : test::degenerate_clouds(513)) all.push_back(std::move(cloud));
  all.push_back({"bad points", test::with_bad_points(random, test::cube(random, 5000, 1.0), 3), {0, 0, 0}});
  FloatPoints wide;
  for (int i = 0; i < 70'000; ++i) wide.push_back(random.normal3(3).cast<float>());
  all.push_back({"two regions", wide, {1, 0, 0}});
  return all;
}

TEST(NearestToBody, AgreesWithAPlainLoop) {
  int inside = 0, found = 0;
  for (const auto& [name, points, sample] : clouds()) {
    SCOPED_TRACE(name);
    // Tiles that are compact, and tiles that are not.
    for (const bool ordered : {true, false}) {
      Random random(514);
      std::vector<BodyQuery> queries;
      std::vector<double> truth;
      for (int trial = 0; trial < 40; ++trial) {
        const Vector3f at = points.empty() || trial % 4 == 0 ? sample : points[random.index(points.size())];
        queries.push_back(
            test::random_query(random, (test::counts(at) ? at : sample).cast<double>(), trial % 5 ? 0.1 : 2));
        truth.push_back(test::plain_nearest(queries.back(), points));
      }
      std::vector<std::int64_t> same;
      for (const Kernels* table : test::all_kernels()) {
        SCOPED_TRACE(table->name);
        const PackedTree tree(*table, points, {ordered ? 16 : 13, ordered});
        std::vector<std::int64_t> numbers;
        for (std::size_t i = 0; i < queries.size(); ++i) {
          BodyQuery q = queries[i];
          const std::int64_t nearest = table->nearest_to_body(tree.view(), q);
          numbers.push_back(nearest);
          ASSERT_EQ(nearest >= 0, std::isfinite(truth[i]));
          EXPECT_EQ(table->any_point_within(tree.view(), q), nearest >= 0);
          if (nearest < 0) continue;
          ++found, inside += truth[i] < 0;
          EXPECT_TRUE(test::counts(tree.point(nearest)));
          EXPECT_NEAR(test::plain_distance(q, tree.point(nearest)), truth[i], test::rounding(truth[i]));
          q.limit = static_cast<float>(truth[i] + 2 * test::rounding(truth[i]));
          EXPECT_EQ(table->nearest_to_body(tree.view(), q), nearest);
          EXPECT_TRUE(table->any_point_within(tree.view(), q));
          q.limit = static_cast<float>(truth[i] - 2 * test::rounding(truth[i]));
          EXPECT_EQ(table->nearest_to_body(tree.view(), q), -1);
          EXPECT_FALSE(table->any_point_within(tree.view(), q));
        }
        if (std::string(table->name) == "scalar") continue;
        if (same.empty()) same = numbers;
        EXPECT_EQ(numbers, same);
      }
    }
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(inside, 100);
}

/// What branch and bound must not change: the decision on each point, taken by the same kernel on that point alone. The
/// points stand on a diagonal, so that tiles have their first and last one in corners of their boxes: there a box is as
/// near as a point, but for rounding.
TEST(NearestToBody, BoxesRuleNothingOut) {
  Random random(515);
  const Vector3d middle(3, -5, 8);
  for (int line = 0; line < 10; ++line) {
    const Vector3d ahead = random.direction();
    FloatPoints points;
    for (int i = 0; i < 1000; ++i) {
      points.push_back((middle + random.uniform(-0.5, 0.5) * ahead + random.normal3(1e-5)).cast<float>());
    }
    for (const Kernels* table : test::all_kernels()) {
      SCOPED_TRACE(table->name);
      const PackedTree tree(*table, points, {16, true});
      for (int trial = 0; trial < 60; ++trial) {
        BodyQuery q = test::random_query(random, middle + random.uniform(-0.5, 0.5) * ahead, 0.05);
        const std::int64_t nearest = table->nearest_to_body(tree.view(), q);
        ASSERT_GE(nearest, 0);
        // The limits at which this point begins to count: by bisection, to the last bit.
        const PackedTree alone(*table, {tree.point(nearest)});
        float no = -1, yes = 2;
        for (int i = 0; i < 60; ++i) {
          q.limit = 0.5f * (no + yes);
          (table->any_point_within(alone.view(), q) ? yes : no) = q.limit;
        }
        q.limit = yes;
        EXPECT_TRUE(table->any_point_within(tree.view(), q));
        EXPECT_GE(table->nearest_to_body(tree.view(), q), 0);
        q.limit = no;
        EXPECT_FALSE(table->any_point_within(tree.view(), q));
        EXPECT_EQ(table->nearest_to_body(tree.view(), q), -1);
      }
    }
  }
}

TEST(NearPixels, AgreeWithAPlainLoop) {
  Random random(518);
  for (const std::int32_t width : {1, 2, 15, 16, 17, 61}) {
    const std::int32_t stride = width + 2, height = 9;
    std::vector<float> c[3];
    for (std::vector<float>& values : c) {
      values.assign(static_cast<std::size_t>(stride * (height + 2) + 16), test::kNan);
      for (std::int32_t v = 1; v <= height; ++v)
        for (std::int32_t u = 1; u <= width; ++u)
          values[static_cast<std::size_t>(stride * v + u)] =
              random.index(15) ? static_cast<float>(random.normal(0.01)) : test::kNan;
    }
    for (std::int32_t v = 1; v <= height; ++v) {
      const std::int32_t first = stride * v + 1;
      const kernels::PixelRow row = {
          &c[0][std::size_t(first)], &c[1][std::size_t(first)], &c[2][std::size_t(first)], width, stride, 3e-4f};
      std::vector<float> same;
      for (const Kernels* table : test::all_kernels()) {
        SCOPED_TRACE(table->name);
        std::vector<float> counts(static_cast<std::size_t>(width + 15) / 16 * 16 + 1, -7.0f);
        table->near_pixels(row, counts.data());
        EXPECT_EQ(counts.back(), -7.0f);
        for (std::int32_t u = 0; u < width; ++u) {
          int surely = 0, perhaps = 0;
          for (const std::int32_t to : {-stride - 1, -stride, -stride + 1, -1, 1, stride - 1, stride, stride + 1}) {
            double d2 = 0;
            for (const std::vector<float>& values : c) {
              const double d = static_cast<double>(values[std::size_t(first + u + to)]) -
                               static_cast<double>(values[std::size_t(first + u)]);
              d2 += d * d;
            }
            surely += d2 < 3e-4 * (1 - 1e-6), perhaps += d2 < 3e-4 * (1 + 1e-6);
          }
          EXPECT_GE(counts[std::size_t(u)], static_cast<float>(surely));
          EXPECT_LE(counts[std::size_t(u)], static_cast<float>(perhaps));
        }
        counts.resize(static_cast<std::size_t>(width));
        if (std::string(table->name) == "scalar") continue;
        if (same.empty()) same = counts;
        EXPECT_EQ(counts, same);
      }
    }
  }
}

}  // namespace
}  // namespace handhold
