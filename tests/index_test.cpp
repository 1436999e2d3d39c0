// Which blocks lie near a place: both indexes, the list of candidates, and the neighbours found through it.
#include "index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "kernels.h"
#include "reference/neighbours.h"
#include "test_clouds.h"

namespace handhold {
namespace {

using test::FloatPoints;
using test::Random;
using test::Vector3d;
using test::Vector3f;

struct Case {
  std::string name;
  FloatPoints points;
  std::uint32_t height = 1;
};

CloudView view_of(const Case& c) {
  CloudView view;
  view.data = c.points.empty() ? nullptr : c.points.front().data();
  view.width = static_cast<std::uint32_t>(c.points.size()) / c.height;
  view.height = c.height;
  return view;
}

std::vector<Case> cases() {
  Random random(31);
  const Vector3f far_away(1e5f, -1e5f, 9e4f);
  std::vector<Case> all;
  all.push_back({"random", test::cube(random, 6000, 0.4)});
  all.push_back({"organized with missing pixels", test::depth_image(random, 100, 75), 75});
  all.push_back({"empty", {}});
  all.push_back({"sparse: blocks over many cells", test::cube(random, 3000, 30)});
  all.push_back({"one point", {Vector3f(0.1f, 0.2f, 0.3f)}});
  all.push_back({"duplicates", FloatPoints(1000, Vector3f(0.1f, 0.2f, 0.3f))});
  all.push_back({"bad points", test::with_bad_points(random, test::cube(random, 2000, 0.2), 3)});
  all.push_back({"nothing measured", FloatPoints(400, Vector3f(test::kNan, 0, 0))});
  all.push_back({"nothing measured, organized", FloatPoints(400, Vector3f(test::kInfinity, 0, 0)), 20});
  FloatPoints distant;  // floats are 8 mm apart there
  for (const Vector3f& p : test::cube(random, 3000, 0.5)) distant.push_back(p + far_away);
  all.push_back({"far away", distant});
  all.push_back({"strays", test::joined(test::cube(random, 2000, 0.2), {far_away, -far_away})});
  all.push_back({"random again", test::cube(random, 1500, 0.1)});
  return all;
}

struct Ball {
  Vector3f centre;
  float radius;
};

/// About points of the cloud, beside them, and where nothing is.
std::vector<Ball> balls(const Case& c, Random& random) {
  std::vector<Ball> all;
  for (const float radius : {0.002f, 0.025f, 0.1f, 2.0f}) {
    for (int i = 0; i < 12; ++i) {
      Vector3f at(0, 0, 0);
      if (!c.points.empty()) at = c.points[random.index(c.points.size())];
      if (!reference::is_measured(at.cast<double>())) at = Vector3f(0, 0, 0.67f);
      if (i % 2 == 1) at += random.normal3(radius).cast<float>();
      all.push_back({at, radius});
    }
    all.push_back({Vector3f(-700, 20, 3), radius});
  }
  return all;
}

std::vector<std::uint32_t> drained(BlockSet& set) {
  std::vector<std::uint32_t> blocks;
  set.drain([&](std::uint32_t b) { blocks.push_back(b); });
  return blocks;
}

std::vector<std::uint32_t> blocks_of(const CandidateList& list) {
  const kernels::Candidates view = list.view();
  EXPECT_EQ(view.padded % 16, 0);
  std::vector<std::uint32_t> blocks;
  for (std::int32_t i = 0; i < view.padded; ++i)
    if (view.boxes[0][i] < kernels::kFar) blocks.push_back(view.block[i]);
  return blocks;
}

/// Distance of two boxes (m), in double.
double distance(const float* low, const float* high, const float* block_box) {
  double d2 = 0;
  for (int k = 0; k < 3; ++k) {
    const double below = static_cast<double>(block_box[k]) - static_cast<double>(high[k]);
    const double above = static_cast<double>(low[k]) - static_cast<double>(block_box[4 + k]);
    const double d = std::max({below, above, 0.0});
    d2 += d * d;
  }
  return std::sqrt(d2);
}

std::vector<std::uint32_t> blocks_within(const TileStore& tiles, const float* low, const float* high, double radius) {
  std::vector<std::uint32_t> blocks;
  for (std::uint32_t b = 0; b < tiles.blocks(); ++b)
    if (!tiles.block_empty(b) && distance(low, high, tiles.block_box(b)) <= radius) blocks.push_back(b);
  return blocks;
}

bool holds_all(const std::vector<std::uint32_t>& set, const std::vector<std::uint32_t>& needed) {
  return std::includes(set.begin(), set.end(), needed.begin(), needed.end());
}

// One store, one list and one index of each kind for all clouds, as a localizer uses them.
class Indexes : public ::testing::Test {
 protected:
  template <class Check>
  void for_each_cloud(Check check) {
    for (const Case& c : cases()) {
      SCOPED_TRACE(c.name);
      tiles_.build(view_of(c));
      embree_->build(tiles_);
      grid_->build(tiles_);
      check(c);
    }
  }
  TileStore tiles_;
  std::unique_ptr<NeighbourIndex> embree_ = make_index(IndexKind::kEmbree), grid_ = make_index(IndexKind::kGrid);
  CandidateList from_embree_, from_grid_;
};

TEST_F(Indexes, FindEveryBlockThatABallTouches) {
  Random random(32);
  for_each_cloud([&](const Case& c) {
    BlockSet found;
    found.resize(tiles_.blocks());
    for (const Ball& ball : balls(c, random)) {
      const float* p = ball.centre.data();
      const auto touched = blocks_within(tiles_, p, p, static_cast<double>(ball.radius));
      for (const NeighbourIndex* index : {embree_.get(), grid_.get()}) {
        index->query(p, ball.radius, found);
        const auto blocks = drained(found);
        EXPECT_TRUE(std::is_sorted(blocks.begin(), blocks.end()));
        EXPECT_TRUE(holds_all(blocks, touched)) << (index == grid_.get() ? "grid" : "embree") << ", about "
                                                << ball.centre.transpose() << ", radius " << ball.radius;
        for (const std::uint32_t b : blocks) EXPECT_FALSE(tiles_.block_empty(b));
        EXPECT_TRUE(drained(found).empty());
      }
    }
  });
}

TEST_F(Indexes, GiveTheSameListOfCandidates) {
  Random random(33);
  for_each_cloud([&](const Case& c) {
    for (const Ball& ball : balls(c, random)) {
      const Vector3f size = Vector3f::Constant(ball.radius) * static_cast<float>(random.uniform(0, 3));
      const Vector3f high = ball.centre + size;
      from_embree_.fill(tiles_, *embree_, ball.centre.data(), high.data(), ball.radius);
      from_grid_.fill(tiles_, *grid_, ball.centre.data(), high.data(), ball.radius);
      const auto blocks = blocks_of(from_embree_);
      EXPECT_EQ(blocks, blocks_of(from_grid_));
      EXPECT_TRUE(
          holds_all(blocks, blocks_within(tiles_, ball.centre.data(), high.data(), static_cast<double>(ball.radius))));
      // and hardly more than these
      EXPECT_TRUE(holds_all(
          blocks_within(tiles_, ball.centre.data(), high.data(), 1.0001 * static_cast<double>(ball.radius)), blocks));
    }
  });
}

using Offset = std::array<float, 3>;

TEST_F(Indexes, LeadToTheNeighboursThatBruteForceFinds) {
  Random random(34);
  const kernels::Kernels& k = kernels::kernels();
  std::size_t neighbours = 0;
  for_each_cloud([&](const Case& c) {
    const std::size_t capacity = tiles_.blocks() * std::size_t{256} + 16;
    std::vector<float> x(capacity), y(capacity), z(capacity);
    for (const Ball& ball : balls(c, random)) {
      const double radius = static_cast<double>(ball.radius);
      // The kernel's distance is a float: points on the sphere itself may fall to either side.
      const double inside2 = radius * radius * (1 - 1e-6), outside2 = radius * radius * (1 + 1e-6);
      std::vector<Offset> expected;
      for (const Vector3f& p : c.points) {
        if (!reference::is_measured(p.cast<double>())) continue;
        const Vector3f d = p - ball.centre;
        if (d.cast<double>().squaredNorm() < inside2) expected.push_back({d[0], d[1], d[2]});
      }
      for (const NeighbourIndex* index : {embree_.get(), grid_.get()}) {
        from_embree_.fill(tiles_, *index, ball.centre.data(), ball.centre.data(), ball.radius);
        const int n = k.collect(tiles_.view(), from_embree_.view(), ball.centre.data(), ball.radius, nullptr, x.data(),
                                y.data(), z.data());
        std::vector<Offset> found;
        for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
          const double d2 = Vector3d(x[i], y[i], z[i]).squaredNorm();
          EXPECT_LE(d2, outside2);
          if (d2 < inside2) found.push_back({x[i], y[i], z[i]});
        }
        std::sort(found.begin(), found.end());
        std::sort(expected.begin(), expected.end());
        EXPECT_EQ(found, expected) << "about " << ball.centre.transpose() << ", radius " << radius;
      }
      neighbours += expected.size();
    }
  });
  EXPECT_GT(neighbours, 10000u) << "the balls are all but empty: nothing was tested";
}

TEST(TileStore, HandsOutEveryMeasuredPointOnce) {
  TileStore tiles;
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    tiles.build(view_of(c));
    std::vector<Offset> expected, found;
    for (const Vector3f& p : c.points)
      if (reference::is_measured(p.cast<double>())) expected.push_back({p[0], p[1], p[2]});
    ASSERT_EQ(tiles.finite_points(), expected.size());
    for (std::size_t rank = 0; rank < expected.size(); ++rank) {
      Offset p;
      tiles.finite_point(rank, p.data());
      found.push_back(p);
    }
    std::sort(expected.begin(), expected.end());
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace handhold
