// The thinned layers of a cloud: which of its points they hold.
#include "layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace handhold {
namespace {

using Points = std::vector<std::array<float, 3>>;

/// A tilted wall at 1 m; column and row can be read from x and y (mm).
Points wall(std::uint32_t width, std::uint32_t height) {
  Points points;
  for (std::uint32_t v = 0; v < height; ++v)
    for (std::uint32_t u = 0; u < width; ++u) {
      const auto x = static_cast<float>(u), y = static_cast<float>(v);
      points.push_back({0.001f * x, 0.001f * y, 1 + 0.0002f * x});
    }
  return points;
}

CloudView view(const Points& points, std::uint32_t width, std::uint32_t height) {
  CloudView cloud;
  cloud.data = points.data()->data();
  cloud.width = width, cloud.height = height;
  return cloud;
}

Points held(const TileStore& tiles) {
  Points points(tiles.finite_points());
  for (std::size_t i = 0; i < points.size(); ++i) tiles.finite_point(i, points[i].data());
  std::sort(points.begin(), points.end());
  return points;
}

TEST(Layers, OfAnImageHoldEverySecondAndFourthRowAndColumn) {
  constexpr std::uint32_t kWidth = 71, kHeight = 50;
  Points points = wall(kWidth, kHeight);
  points[2 * kWidth + 4].fill(std::numeric_limits<float>::quiet_NaN());
  const CloudView cloud = view(points, kWidth, kHeight);
  TileStore full, thin;
  full.build(cloud);
  for (const std::uint32_t step : {1u, 2u, 4u}) {
    thin.build_thinned(cloud, full, step);
    Points expected;
    for (std::uint32_t v = 0; v < kHeight; v += step)
      for (std::uint32_t u = 0; u < kWidth; u += step) {
        const auto& p = points[v * kWidth + u];
        if (p[0] == p[0]) expected.push_back(p);
      }
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(held(thin), expected) << step;
  }
}

TEST(Layers, OfOtherCloudsHoldTheirShareOfThePoints) {
  const Points points = wall(71, 50);
  const CloudView cloud = view(points, static_cast<std::uint32_t>(points.size()), 1);
  TileStore full, thin;
  full.build(cloud);
  const Points all = held(full);
  for (const std::uint32_t step : {2u, 4u}) {
    thin.build_thinned(cloud, full, step);
    const Points some = held(thin);
    EXPECT_EQ(some.size(), (points.size() + step * step - 1) / (step * step));
    EXPECT_TRUE(std::includes(all.begin(), all.end(), some.begin(), some.end()));
    EXPECT_EQ(std::adjacent_find(some.begin(), some.end()), some.end()) << "each of them once";
  }
}

TEST(Layers, EndWhereARegularPatternHidesThePoints) {
  constexpr std::uint32_t kWidth = 64, kHeight = 48;
  Points points = wall(kWidth, kHeight);
  // Every second column was not measured: those that a thinned image takes.
  for (std::size_t i = 0; i < points.size(); i += 2) points[i].fill(std::numeric_limits<float>::quiet_NaN());
  const CloudView cloud = view(points, kWidth, kHeight);
  TileStore full;
  full.build(cloud);
  const auto index = make_index(IndexKind::kGrid);
  index->build(full);
  Layers layers(IndexKind::kGrid);
  layers.take(full, *index);
  layers.thin(cloud);
  EXPECT_EQ(layers.size(), 1u);
  Points whole = wall(kWidth, kHeight);
  const CloudView good = view(whole, kWidth, kHeight);
  full.build(good);
  index->build(full);
  layers.take(full, *index);
  layers.thin(good);
  EXPECT_EQ(layers.size(), Layers::kMost);
}

}  // namespace
}  // namespace handhold
