// The points of a cloud under a tree of boxes: what it finds is what a plain loop over the cloud finds.
#include "point_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "body_queries.h"
#include "demo_cloud.h"
#include "test_tiles.h"

namespace handhold::plan {
namespace {

using kernels::BodyQuery;
using test::FloatPoints;
using test::Random;
using test::Vector3d;
using test::Vector3f;

struct NamedCloud {
  std::string name;
  Cloud cloud;
  FloatPoints points;
};

NamedCloud named(const std::string& name, const Cloud& cloud) {
  NamedCloud result{name, cloud, {}};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float* p = &cloud.xyz[3 * i];
    result.points.emplace_back(p[0], p[1], p[2]);
  }
  return result;
}
NamedCloud named(const std::string& name, const FloatPoints& points, std::uint32_t width = 0) {
  Cloud cloud;
  for (const Vector3f& p : points) cloud.xyz.insert(cloud.xyz.end(), {p[0], p[1], p[2]});
  cloud.width = width ? width : static_cast<std::uint32_t>(points.size());
  cloud.height = width ? static_cast<std::uint32_t>(points.size()) / width : 1;
  return {name, cloud, points};
}

std::vector<NamedCloud> clouds() {
  Random random(531);
  std::vector<NamedCloud> all = {named("table scene", test::demo_cloud()),
                                 named("depth image", test::depth_image(random, 150, 70), 150),
                                 named("bad points", test::with_bad_points(random, test::cube(random, 5000, 1.0), 3))};
  for (const auto& [name, points, at] : test::ordinary_clouds(532, 3000)) all.push_back(named(name, points));
  for (const auto& [name, points, at] : test::degenerate_clouds(533)) all.push_back(named(name, points));
  return all;
}

TEST(PointTree, FindsWhatAPlainLoopFinds) {
  int found = 0;
  for (const auto& [name, cloud, points] : clouds()) {
    SCOPED_TRACE(name);
    PointTree tree;
    tree.build(cloud.view());
    Random random(534);
    for (int trial = 0; trial < 40; ++trial) {
      // About a point of the cloud, or anywhere.
      const Vector3f at = points.empty() ? Vector3f(0, 0, 1) : points[random.index(points.size())];
      const Vector3d about = test::counts(at) ? at.cast<double>() : Vector3d(0, 0, 1);
      const BodyQuery q = test::random_query(random, about, trial % 5 ? 0.15 : 2);
      const double truth = test::plain_nearest(q, points);
      for (const kernels::Kernels* table : test::all_kernels()) {
        SCOPED_TRACE(table->name);
        const std::int64_t nearest = table->nearest_to_body(tree.view(), q);
        ASSERT_EQ(nearest >= 0, std::isfinite(truth));
        EXPECT_EQ(table->any_point_within(tree.view(), q), nearest >= 0);
        if (nearest < 0) continue;
        const Vector3 p = tree.point(nearest);
        EXPECT_NEAR(test::plain_distance(q, Vector3d(p[0], p[1], p[2]).cast<float>()), truth, test::rounding(truth));
        ++found;
      }
    }
  }
  EXPECT_GT(found, 500);
}

TEST(PointTree, IsReused) {
  Random random(535);
  PointTree reused;
  for (const auto& [name, cloud, points] : clouds()) {
    SCOPED_TRACE(name);
    PointTree fresh;
    fresh.build(cloud.view());
    reused.build(cloud.view());
    std::size_t finite = 0;
    for (const Vector3f& p : points) finite += test::counts(p);
    EXPECT_EQ(reused.points(), finite);
    for (int trial = 0; trial < 20; ++trial) {
      const BodyQuery q = test::random_query(random, Vector3d(0, 0, 0.7), 0.3);
      EXPECT_EQ(kernels::kernels().nearest_to_body(reused.view(), q),
                kernels::kernels().nearest_to_body(fresh.view(), q));
    }
  }
}

TEST(PointTree, EmptyBeforeItIsBuilt) {
  Random random(536);
  const PointTree tree;
  const BodyQuery q = test::random_query(random, Vector3d::Zero(), 0.1);
  for (const kernels::Kernels* table : test::all_kernels()) {
    EXPECT_EQ(table->nearest_to_body(tree.view(), q), -1);
    EXPECT_FALSE(table->any_point_within(tree.view(), q));
  }
}

}  // namespace
}  // namespace handhold::plan
