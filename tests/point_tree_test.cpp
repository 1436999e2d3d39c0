// The points of a cloud near a body, and pixels near their neighbours: the kernels against a plain loop in double
// precision, for every instruction set.
#include "point_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "handhold/io.h"
#include "test_tiles.h"

namespace handhold::plan {
namespace {

using kernels::BodyQuery;
using kernels::Kernels;
using test::FloatPoints;
using test::Random;
using test::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct NamedCloud {
  std::string name;
  Cloud cloud;
};

Cloud cloud_of(const FloatPoints& points, std::uint32_t width = 0) {
  Cloud cloud;
  for (const auto& p : points) cloud.xyz.insert(cloud.xyz.end(), {p[0], p[1], p[2]});
  cloud.width = width ? width : static_cast<std::uint32_t>(points.size());
  cloud.height = width ? static_cast<std::uint32_t>(points.size()) / width : 1;
  return cloud;
}

std::vector<NamedCloud> clouds() {
  Random random(511);
  std::vector<NamedCloud> all;
  all.push_back({"table scene", read_cloud(HANDHOLD_DATA "/table_scene.pcd")});
  all.push_back({"depth image", cloud_of(test::depth_image(random, 150, 70), 150)});
  for (const auto& [name, points, at] : test::ordinary_clouds(512, 3000)) all.push_back({name, cloud_of(points)});
  for (const auto& [name, points, at] : test::degenerate_clouds(513)) all.push_back({name, cloud_of(points)});
  all.push_back({"bad points", cloud_of(test::with_bad_points(random, test::cube(random, 5000, 1.0), 3))});
  FloatPoints wide;
  for (int i = 0; i < 70000; ++i) wide.push_back(random.normal3(3).cast<float>());
  all.push_back({"wide", cloud_of(wide)});
  return all;
}

BodyQuery random_query(Random& random, const Vector3d& about, double spread) {
  BodyQuery q{};
  const Vector3d c = about + random.normal3(spread);
  const Eigen::Matrix3d R = random.rotation();
  const int kind = static_cast<int>(random.index(4));  // a point, a segment, a plate, a box
  for (int i = 0; i < 3; ++i) {
    q.centre[i] = static_cast<float>(c[i]);
    q.half[i] = i < kind ? static_cast<float>(random.uniform(0, 0.2)) : 0.0f;
    for (int k = 0; k < 3; ++k) q.R_body_cloud[3 * i + k] = static_cast<float>(R(k, i));
  }
  q.limit = kernels::kMostDistance;
  return q;
}

double plain_distance(const BodyQuery& q, const float* p) {
  double excess[3], sum = 0;
  for (int i = 0; i < 3; ++i) {
    double along = 0;
    for (int k = 0; k < 3; ++k) {
      along += static_cast<double>(q.R_body_cloud[3 * i + k]) *
               (static_cast<double>(p[k]) - static_cast<double>(q.centre[k]));
    }
    excess[i] = std::fabs(along) - static_cast<double>(q.half[i]);
    sum += excess[i] > 0 ? excess[i] * excess[i] : 0;
  }
  return sum > 0 ? std::sqrt(sum) : std::max({excess[0], excess[1], excess[2]});
}

bool counts(const float* p) {
  return std::fabs(p[0]) <= 1e6f && std::fabs(p[1]) <= 1e6f && std::fabs(p[2]) <= 1e6f;
}

double plain_nearest(const BodyQuery& q, const CloudView& cloud) {
  double least = kInfinity;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (counts(cloud.point(i))) least = std::min(least, plain_distance(q, cloud.point(i)));
  }
  return least;
}

TEST(NearestToBody, AgreesWithAPlainLoop) {
  int inside = 0, found = 0;
  for (const auto& [name, cloud] : clouds()) {
    SCOPED_TRACE(name);
    PointTree tree;
    tree.build(cloud.view());
    Random random(514);
    const bool large = cloud.size() > 100'000;
    for (int trial = 0; trial < (large ? 60 : 100); ++trial) {
      // About a point of the cloud, or anywhere.
      Vector3d about = Vector3d::Zero();
      if (cloud.size() > 0) {
        const float* p = cloud.view().point(random.index(cloud.size()));
        if (counts(p))
          about = Vector3d(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
      }
      BodyQuery q = random_query(random, about, trial % 5 == 0 ? 2 : 0.15);
      const double truth = plain_nearest(q, cloud.view());
      // Of single precision, for the numbers that it computes with.
      const double slack = 4e-7 * (std::fabs(truth) + 1);
      std::int64_t first = -2;
      for (const Kernels* table : test::all_kernels()) {
        SCOPED_TRACE(table->name);
        q.limit = kernels::kMostDistance;
        const std::int64_t nearest = table->nearest_to_body(tree.view(), q);
        ASSERT_EQ(nearest >= 0, std::isfinite(truth));
        EXPECT_EQ(table->any_point_within(tree.view(), q), nearest >= 0);
        if (nearest < 0) continue;
        const Vector3 p = tree.point(nearest);
        const float xyz[3] = {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
        EXPECT_TRUE(counts(xyz));
        EXPECT_NEAR(plain_distance(q, xyz), truth, slack);
        ++found, inside += truth < 0;
        q.limit = static_cast<float>(truth + 2 * slack);
        EXPECT_EQ(table->nearest_to_body(tree.view(), q), nearest);
        EXPECT_TRUE(table->any_point_within(tree.view(), q));
        q.limit = static_cast<float>(truth - 2 * slack);
        EXPECT_EQ(table->nearest_to_body(tree.view(), q), -1);
        EXPECT_FALSE(table->any_point_within(tree.view(), q));
        if (std::string(table->name) == "scalar") continue;
        if (first == -2) first = nearest;
        EXPECT_EQ(nearest, first);
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
    const Cloud cloud = cloud_of(points);
    PointTree tree;
    tree.build(cloud.view());
    for (const Kernels* table : test::all_kernels()) {
      SCOPED_TRACE(table->name);
      for (int trial = 0; trial < 60; ++trial) {
        BodyQuery q = random_query(random, middle + random.uniform(-0.5, 0.5) * ahead, 0.05);
        const std::int64_t nearest = table->nearest_to_body(tree.view(), q);
        ASSERT_GE(nearest, 0);
        // The limits at which this point begins to count: by bisection, to the last bit.
        const Vector3 at = tree.point(nearest);
        const Cloud one = cloud_of({Vector3d(at[0], at[1], at[2]).cast<float>()});
        PointTree alone;
        alone.build(one.view());
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

TEST(PointTree, IsReused) {
  Random random(516);
  PointTree reused;
  for (const auto& [name, cloud] : clouds()) {
    SCOPED_TRACE(name);
    PointTree fresh;
    fresh.build(cloud.view());
    reused.build(cloud.view());
    std::size_t finite = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) finite += counts(cloud.view().point(i));
    EXPECT_EQ(reused.points(), finite);
    for (int trial = 0; trial < 20; ++trial) {
      const BodyQuery q = random_query(random, Vector3d(0, 0, 0.7), 0.3);
      EXPECT_EQ(kernels::kernels().nearest_to_body(reused.view(), q),
                kernels::kernels().nearest_to_body(fresh.view(), q));
    }
  }
}

TEST(PointTree, EmptyBeforeItIsBuilt) {
  Random random(517);
  const PointTree tree;
  const BodyQuery q = random_query(random, Vector3d::Zero(), 0.1);
  for (const Kernels* table : test::all_kernels()) {
    EXPECT_EQ(table->nearest_to_body(tree.view(), q), -1);
    EXPECT_FALSE(table->any_point_within(tree.view(), q));
  }
}

}  // namespace
}  // namespace handhold::plan
