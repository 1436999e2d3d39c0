// What EMBEDDING.md promises to programs in C++, beyond what the tests of the single parts say.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "handhold/localizer.h"
#include "test_clouds.h"

namespace handhold {
namespace {

/// A rod before a wall, as a camera sees it.
Cloud rod(std::uint64_t seed = 1, int width = 320, int height = 240) {
  test::Random random(seed);
  Cloud cloud;
  cloud.width = static_cast<std::uint32_t>(width);
  cloud.height = static_cast<std::uint32_t>(height);
  for (const test::Vector3f& p : test::depth_image(random, width, height)) {
    cloud.xyz.insert(cloud.xyz.end(), {p.x(), p.y(), p.z()});
  }
  return cloud;
}

/// What is reported of a frame, without the times.
std::vector<double> numbers(const Result& result) {
  std::vector<double> all = {static_cast<double>(result.status), static_cast<double>(result.points),
                             static_cast<double>(result.finite_points), static_cast<double>(result.funnel.in_handles)};
  for (const Handle& h : result.handles) {
    all.insert(all.end(), {h.center[0], h.center[1], h.center[2], h.axis[0], h.axis[1], h.axis[2], h.approach[0],
                           h.approach[1], h.approach[2], h.radius, h.length, h.confidence});
    for (const Vector3& p : h.path) all.insert(all.end(), p.begin(), p.end());
    all.insert(all.end(), h.affordances.begin(), h.affordances.end());
  }
  for (const Affordance& a : result.affordances) {
    all.insert(all.end(), {a.center[0], a.center[1], a.center[2], a.radius, static_cast<double>(a.sample)});
  }
  return all;
}

TEST(Embedding, AViewThatIsRefusedLeavesResultAndLocalizerAlone) {
  const Cloud cloud = rod();
  Localizer localizer;
  Result result;
  localizer.localize(cloud.view(), result);
  ASSERT_FALSE(result.handles.empty());
  const std::vector<double> before = numbers(result);
  CloudView wrong[] = {cloud.view(), cloud.view(), cloud.view()};
  wrong[0].data = nullptr;
  wrong[1].point_step = 10;
  wrong[2].viewpoint = Vector3{0, std::numeric_limits<double>::quiet_NaN(), 0};
  for (const CloudView& view : wrong) {
    EXPECT_THROW(localizer.localize(view, result), std::invalid_argument);
    EXPECT_EQ(numbers(result), before);
  }
  EXPECT_EQ(numbers(localizer.localize(cloud.view())), before);
}

TEST(Embedding, AResultOutlivesCloudAndLocalizer) {
  const std::vector<double> expected = numbers(Localizer().localize(rod().view()));
  auto cloud = std::make_unique<Cloud>(rod());
  auto localizer = std::make_unique<Localizer>();
  Result result;
  localizer->localize(cloud->view(), result);
  cloud.reset();
  const std::vector<Sample> samples = localizer->samples();  // needs no cloud, either
  EXPECT_EQ(samples.size(), static_cast<std::size_t>(result.funnel.samples));
  localizer.reset();
  std::vector<double> read;
  std::thread([&] { read = numbers(result); }).join();
  EXPECT_EQ(read, expected);
}

TEST(Embedding, WhatIsUsedAgainIsAsGoodAsNew) {
  const Cloud clouds[] = {rod(1), rod(2, 160, 120), Cloud(), rod(3)};
  Localizer localizer, other;
  Result result;
  for (int round = 0; round < 2; ++round) {
    for (const Cloud& cloud : clouds) {
      localizer.localize(cloud.view(), result);
      other.localize(clouds[0].view());  // between the frames of the first
      EXPECT_EQ(numbers(result), numbers(Localizer().localize(cloud.view())));
    }
  }
}

TEST(Embedding, ACloudIsNotWritten) {
  // A tight fit in memory of its own: reading beyond the end would show under a sanitizer.
  const Cloud cloud = rod();
  const std::unique_ptr<float[]> points(new float[cloud.xyz.size()]);
  std::copy(cloud.xyz.begin(), cloud.xyz.end(), points.get());
  CloudView view = cloud.view();
  view.data = points.get();
  Localizer().localize(view);
  EXPECT_EQ(std::memcmp(points.get(), cloud.xyz.data(), cloud.xyz.size() * sizeof(float)), 0);
}

}  // namespace
}  // namespace handhold
