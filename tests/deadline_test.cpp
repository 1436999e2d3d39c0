// A frame that ends early: by its deadline, or because another thread says so.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "budget.h"
#include "demo_cloud.h"
#include "handhold/localizer.h"
#include "handhold/sensor.h"
#include "layers.h"
#include "localizer_detail.h"
#include "search.h"

namespace handhold {
namespace {

/// The same points in one row.
Cloud unorganized() {
  Cloud cloud = test::demo_cloud();
  cloud.width *= cloud.height, cloud.height = 1;
  return cloud;
}

/// All handles, to the last digit.
std::string text_of(const Result& result) {
  std::string text = std::string(to_string(result.status)) + '\n';
  for (const Handle& h : result.handles) {
    for (const Vector3& v : {h.center, h.axis, h.approach})
      for (const double x : v) text += std::to_string(x) + ' ';
    for (const double x : {h.radius, h.length, h.confidence, h.observed_free}) text += std::to_string(x) + ' ';
    text += '\n';
  }
  return text;
}

TEST(Budget, IsSpentAtItsEndOrWhenCancelled) {
  using Clock = Budget::Clock;
  EXPECT_FALSE(Budget().spent());
  std::atomic<bool> cancelled{false};
  const Budget hour(Clock::now(), 3.6e6, &cancelled), none(Clock::now(), std::nullopt, &cancelled);
  EXPECT_FALSE(hour.spent());
  EXPECT_NO_THROW(hour.check());
  EXPECT_TRUE(hour.less(3.7e6).spent());
  EXPECT_FALSE(none.less(1e9).spent()) << "without an end nothing is taken from it";
  EXPECT_TRUE(Budget(Clock::now() - std::chrono::milliseconds(2), 1.0, nullptr).spent());
  cancelled = true;
  EXPECT_TRUE(hour.spent());
  EXPECT_TRUE(none.spent());
  EXPECT_TRUE(none.cancelled());
  EXPECT_THROW(none.check(), Budget::Spent);
}

TEST(Deadline, FarAwayChangesNothing) {
  for (const Method method : {Method::kDefault, Method::kPaper}) {
    Options options;
    options.method = method;
    options.samples = 2000;
    const Result all = Localizer(options).localize(test::demo_cloud().view());
    ASSERT_EQ(all.status, Status::kOk);
    ASSERT_FALSE(all.handles.empty());
    options.deadline_ms = 6e4;
    EXPECT_EQ(text_of(Localizer(options).localize(test::demo_cloud().view())), text_of(all));
    EXPECT_EQ(all.funnel.cut, 0);
  }
}

TEST(Deadline, AtOnceFindsNothing) {
  const Cloud row = unorganized();
  for (const CloudView& cloud : {test::demo_cloud().view(), row.view()})
    for (const Method method : {Method::kDefault, Method::kPaper}) {
      Options options;
      options.method = method;
      options.deadline_ms = 1e-6;
      Localizer localizer(options);
      const Result result = localizer.localize(cloud);
      EXPECT_EQ(result.status, Status::kDeadline);
      EXPECT_TRUE(result.handles.empty());
      EXPECT_EQ(result.points, cloud.size());
    }
}

/// Wherever the end comes, what is there holds together, and the next frame is not affected.
TEST(Deadline, AnyPartOfAFrameIsSound) {
  Options options;
  options.samples = 3000;
  const std::string whole = text_of(Localizer(options).localize(test::demo_cloud().view()));
  int cut = 0;
  for (const Method method : {Method::kDefault, Method::kPaper})
    for (const int threads : {1, 2})
      for (double deadline = 0.5; deadline < 400; deadline *= 2) {
        options.method = method, options.threads = threads, options.deadline_ms = deadline;
        Localizer localizer(options);
        Result result;
        for (int i = 0; i < 2; ++i) localizer.localize(test::demo_cloud().view(), result);
        ASSERT_TRUE(result.status == Status::kOk || result.status == Status::kDeadline);
        const Funnel& f = result.funnel;
        cut += result.status == Status::kDeadline;
        EXPECT_EQ(f.too_few_points + f.flat + f.curvature_low + f.concave + f.circle_wide + f.circle_narrow +
                      f.poor_fit + f.no_gap + f.shell_empty + f.cut + f.affordances,
                  f.samples);
        EXPECT_EQ(f.affordances, static_cast<std::int64_t>(result.affordances.size()));
        EXPECT_EQ(f.not_aligned + f.unconfirmed + f.too_short + f.low_confidence + f.in_handles, f.affordances);
        if (result.status == Status::kOk) {
          EXPECT_EQ(f.cut, 0);
        }
        const std::vector<Sample> samples = localizer.samples();
        ASSERT_EQ(samples.size(), static_cast<std::size_t>(f.samples));
        for (const Affordance& a : result.affordances) {
          ASSERT_LT(a.sample, samples.size());
          EXPECT_EQ(samples[a.sample].step, Step::kAffordance);
        }
        for (const Handle& h : result.handles)
          for (const std::uint32_t i : h.affordances) EXPECT_LT(i, result.affordances.size());
      }
  EXPECT_GT(cut, 0);
  options.method = Method::kDefault, options.deadline_ms.reset();
  EXPECT_EQ(text_of(Localizer(options).localize(test::demo_cloud().view())), whole);
}

TEST(Deadline, WhatWasNotLookedAtIsSaid) {
  TileStore tiles;
  tiles.build(test::demo_cloud().view());
  const auto index = make_index(IndexKind::kEmbree);
  index->build(tiles);
  Layers layers(IndexKind::kEmbree);
  layers.take(tiles, *index);
  Options options;
  options.method = Method::kPaper;
  Search search(options);
  search.begin(layers, test::demo_cloud().viewpoint);
  std::vector<float> xyz(3 * 500);
  for (std::size_t i = 0; i < 500; ++i) tiles.finite_point(37 * i, &xyz[3 * i]);
  std::vector<Step> steps(500);
  std::vector<Affordance> found;
  const std::atomic<bool> cancelled{true};
  EXPECT_FALSE(search.run(xyz.data(), 500, 0, steps.data(), found, Budget(Budget::Clock::now(), {}, &cancelled)));
  EXPECT_EQ(steps, std::vector<Step>(500, Step::kCut));
  EXPECT_TRUE(found.empty());
  EXPECT_TRUE(search.run(xyz.data(), 500, 0, steps.data(), found));
  for (const Step step : steps) EXPECT_NE(step, Step::kCut);
}

TEST(Cancel, EndsTheFrameInProgressAndNoOther) {
  Options options;
  options.samples = 20000;  // so that another thread comes to it, however busy the machine is
  for (const int threads : {1, 2}) {
    options.threads = threads;
    Localizer localizer(options);
    localizer.cancel();
    const std::string whole = text_of(localizer.localize(test::demo_cloud().view()));
    EXPECT_EQ(whole.rfind("ok\n", 0), 0u) << "there was no frame to cancel";
    Result result;
    std::atomic<bool> over{false};
    std::thread other([&] {
      while (!over) localizer.cancel(), std::this_thread::yield();
    });
    localizer.localize(test::demo_cloud().view(), result);
    over = true;
    other.join();
    EXPECT_EQ(result.status, Status::kCancelled);
    EXPECT_TRUE(result.handles.empty());
    EXPECT_TRUE(result.affordances.empty());
    EXPECT_TRUE(localizer.samples().empty());
    EXPECT_EQ(text_of(localizer.localize(test::demo_cloud().view())), whole);
  }
}

}  // namespace
}  // namespace handhold
