// Handles from frame to frame.
#include "handhold/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "demo_cloud.h"
#include "handhold/localizer.h"
#include "handhold/sensor.h"
#include "vec3.h"

namespace handhold {
namespace {

Handle handle(const Vector3& center, const Vector3& axis, double radius = 0.015, double length = 0.1) {
  Handle h{};
  h.center = center, h.axis = normalized(axis), h.radius = radius, h.length = length, h.confidence = 0.9;
  h.approach = any_perpendicular(h.axis);
  return h;
}
const Vector3 kX = {1, 0, 0}, kY = {0, 1, 0}, kZ = {0, 0, 1};

const Track* of(const Tracker& tracker, std::uint64_t id) {
  for (const Track& t : tracker.tracks())
    if (t.id == id) return &t;
  return nullptr;
}

TEST(Tracker, KeepsWhoIsWhoWhileHandlesMove) {
  Tracker tracker;
  for (int frame = 0; frame < 40; ++frame) {
    const double x = 0.01 * frame;
    // In an order that changes.
    std::vector<Handle> handles = {handle({x, 0, 0.8}, kY), handle({x, 0.3, 0.8}, kX), handle({-x, 0.6, 0.8}, kZ)};
    std::rotate(handles.begin(), handles.begin() + frame % 3, handles.end());
    tracker.update(handles);
    ASSERT_EQ(tracker.tracks().size(), 3u) << frame;
    for (const Track& t : tracker.tracks()) EXPECT_EQ(t.age, frame + 1);
  }
  for (const Track& t : tracker.tracks()) {
    EXPECT_NEAR(std::fabs(t.handle.center[0]), 0.39, 1e-4);
    EXPECT_NEAR(std::fabs(t.velocity[0]), 0.01, 1e-4);
  }
}

TEST(Tracker, OfTwoThatCrossEachKeepsItsOwn) {
  Tracker tracker;
  tracker.update({handle({-0.1, 0, 0.8}, kY), handle({0.1, 0.02, 0.8}, {0.3, 1, 0}, 0.02)});
  ASSERT_EQ(tracker.tracks().size(), 2u);
  const std::uint64_t first = tracker.tracks()[0].id, second = tracker.tracks()[1].id;
  for (int frame = 1; frame <= 20; ++frame) {
    const double x = -0.1 + 0.01 * frame;
    tracker.update({handle({-x, 0.02, 0.8}, {0.3, 1, 0}, 0.02), handle({x, 0, 0.8}, kY)});
  }
  ASSERT_EQ(tracker.tracks().size(), 2u);
  EXPECT_GT(of(tracker, first)->handle.center[0], 0.05);
  EXPECT_NEAR(of(tracker, first)->handle.radius, 0.015, 1e-3);
  EXPECT_LT(of(tracker, second)->handle.center[0], -0.05);
  EXPECT_NEAR(of(tracker, second)->handle.radius, 0.02, 1e-3);
}

TEST(Tracker, WaitsForWhatIsHidden) {
  TrackerOptions options;
  options.keep = 5;
  Tracker tracker(options);
  const Handle h = handle({0, 0, 0.8}, kX);
  tracker.update({h});
  const std::uint64_t id = tracker.tracks()[0].id;
  for (int i = 1; i <= 5; ++i) {
    tracker.update({});
    ASSERT_EQ(tracker.tracks().size(), 1u);
    EXPECT_EQ(tracker.tracks()[0].unseen, i);
  }
  tracker.update({h});
  ASSERT_EQ(tracker.tracks().size(), 1u);
  EXPECT_EQ(tracker.tracks()[0].id, id);
  EXPECT_EQ(tracker.tracks()[0].unseen, 0);
  EXPECT_EQ(tracker.tracks()[0].age, 2);
  for (int i = 0; i < 6; ++i) tracker.update({});
  EXPECT_TRUE(tracker.tracks().empty());
  tracker.update({h});
  EXPECT_NE(tracker.tracks()[0].id, id) << "an id is never given again";
}

TEST(Tracker, AnotherPlaceAxisOrRadiusIsAnother) {
  const Handle h = handle({0, 0, 0.8}, kX);
  const auto same = [&](const Handle& next) {
    Tracker tracker;
    tracker.update({h});
    tracker.update({next});
    return tracker.tracks().size() == 1;
  };
  EXPECT_TRUE(same(h));
  EXPECT_TRUE(same(handle({0.045, 0.01, 0.8}, kX))) << "its middle moved along the part";
  EXPECT_FALSE(same(handle({0, 0.05, 0.8}, kX)));
  EXPECT_FALSE(same(handle({0.06, 0, 0.8}, kX)));
  EXPECT_FALSE(same(handle({0, 0, 0.8}, {1, 1, 0})));
  EXPECT_FALSE(same(handle({0, 0, 0.8}, kX, 0.03)));
}

TEST(Tracker, SmoothsAndKnowsThatAnAxisHasNoSign) {
  Tracker tracker;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  double most = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const double noise = frame % 2 ? 0.004 : -0.004;
    // Its largest component changes from x to y with the noise, and with it the sign.
    const Vector3 axis = canonical_axis(normalized(Vector3{-1 - noise, 1 - noise, 0}));
    tracker.update({handle({noise, 0, 0.8}, axis, 0.015 + noise / 4)});
    ASSERT_EQ(tracker.tracks().size(), 1u);
    const Handle& h = tracker.tracks()[0].handle;
    if (frame > 10) most = std::max(most, std::fabs(h.center[0]));
    EXPECT_GT(std::fabs(dot(h.axis, normalized(Vector3{-1, 1, 0}))), 0.999);
    EXPECT_NEAR(norm(h.axis), 1, 1e-12);
    EXPECT_NEAR(dot(h.axis, h.approach), 0, 1e-9);
  }
  EXPECT_LT(most, 0.002) << "half of the noise at most";
  Handle odd = handle({nan, nan, nan}, kX);
  tracker.update({odd});
  EXPECT_EQ(tracker.tracks().size(), 2u) << "a place that is none is no known one";
}

TEST(Tracker, FollowsACameraThatMoves) {
  // A quarter turn about z and a step, each frame: farther than any handle may jump.
  Motion motion;
  motion.R = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  motion.t = {0.5, -0.2, 0.1};
  const auto apply = [&](const Vector3& p) {
    return Vector3{-p[1] + motion.t[0], p[0] + motion.t[1], p[2] + motion.t[2]};
  };
  Tracker tracker;
  Handle h = handle({0.1, 0.2, 0.8}, {1, 0.2, 0});
  h.path = {{0.05, 0.2, 0.8}, {0.15, 0.2, 0.8}};
  tracker.update({h});
  for (int i = 0; i < 5; ++i) {
    std::vector<Vector3> places;
    tracker.guesses(places, motion);
    h.center = apply(h.center);
    h.axis = canonical_axis({-h.axis[1], h.axis[0], h.axis[2]});
    h.approach = {-h.approach[1], h.approach[0], h.approach[2]};
    for (Vector3& p : h.path) p = apply(p);
    ASSERT_EQ(places.size(), 2u);
    EXPECT_LT(norm(places[0] - h.path[0]), 1e-9);
    tracker.update({h}, motion);
    ASSERT_EQ(tracker.tracks().size(), 1u);
    EXPECT_EQ(tracker.tracks()[0].age, i + 2);
    EXPECT_LT(norm(tracker.tracks()[0].handle.center - h.center), 1e-9);
  }
}

TEST(Tracker, GuessesLieAlongTheHandles) {
  Tracker tracker;
  std::vector<Vector3> places = {{9, 9, 9}};
  tracker.guesses(places);
  EXPECT_TRUE(places.empty());
  tracker.update({handle({0, 0, 0.8}, kX, 0.01, 0.15), handle({0, 0.3, 0.8}, kY, 0.01, 0.005)});
  tracker.guesses(places);
  ASSERT_EQ(places.size(), 11u) << "ten of the long one, one of the short one";
  EXPECT_NEAR(places[0][0], -0.0675, 1e-12);
  EXPECT_NEAR(places[9][0], 0.0675, 1e-12);
  EXPECT_EQ(places[10], (Vector3{0, 0.3, 0.8}));
}

TEST(Tracker, BadOptionsAreNamed) {
  const auto message = [](auto set) {
    TrackerOptions options;
    set(options);
    try {
      Tracker tracker(options);
    } catch (const OptionError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  using O = TrackerOptions;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message([](O& o) { o.max_offset = 0; }).find("max_offset"), std::string::npos);
  EXPECT_NE(message([&](O& o) { o.max_angle = nan; }).find("max_angle"), std::string::npos);
  EXPECT_NE(message([](O& o) { o.max_radius = 2; }).find("max_radius"), std::string::npos);
  EXPECT_NE(message([](O& o) { o.weight = 0; }).find("weight"), std::string::npos);
  EXPECT_NE(message([](O& o) { o.keep = -1; }).find("keep"), std::string::npos);
}

// ---- Guesses in a search ------------------------------------------------------------------------------------------

TEST(Guesses, FindWithFewSamplesWhatManyFound) {
  Options options;
  const Result all = Localizer(options).localize(test::demo_cloud().view());
  ASSERT_GE(all.handles.size(), 4u);
  Tracker tracker;
  tracker.update(all.handles);
  std::vector<Vector3> guesses;
  tracker.guesses(guesses);
  options.samples = 200;
  // Of several seeds together: how many of those are found again.
  std::size_t with = 0, without = 0;
  const auto again = [&](const Result& result) {
    std::size_t n = 0;
    for (const Handle& h : all.handles) {
      n += std::any_of(result.handles.begin(), result.handles.end(), [&](const Handle& g) {
        return norm(g.center - h.center) < 0.03 && std::fabs(dot(g.axis, h.axis)) > 0.9;
      });
    }
    return n;
  };
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    options.seed = seed;
    Localizer localizer(options);
    Result result;
    localizer.localize(test::demo_cloud().view(), result, guesses);
    EXPECT_EQ(result.funnel.samples, 200);
    with += again(result);
    localizer.localize(test::demo_cloud().view(), result);
    without += again(result);
  }
  EXPECT_GT(with, without);
  EXPECT_GE(with, 3 * all.handles.size()) << "three of five at least";
}

TEST(Guesses, AreNoSecretState) {
  Options options;
  options.samples = 600;
  const auto found = [](const Result& r) {
    std::vector<Vector3> centers;
    for (const Affordance& a : r.affordances) centers.push_back(a.center);
    return centers;
  };
  Localizer localizer(options);
  const auto without = found(localizer.localize(test::demo_cloud().view()));
  const std::vector<Vector3> guesses = {{0, 0, 0.7}, {0.1, 0, 0.7}};
  Result result;
  localizer.localize(test::demo_cloud().view(), result, guesses);
  const auto with = found(result);
  EXPECT_NE(with, without);
  EXPECT_EQ(found(localizer.localize(test::demo_cloud().view())), without);
  for (const int threads : {1, 3}) {
    options.threads = threads;
    Localizer other(options);
    other.localize(test::demo_cloud().view(), result, guesses);
    EXPECT_EQ(found(result), with) << threads << " threads";
  }
  for (const Strategy strategy : {Strategy::kUniform, Strategy::kSum}) {
    options.strategy = strategy, options.threads = 2;
    Localizer other(options);
    other.localize(test::demo_cloud().view(), result, guesses);
    EXPECT_EQ(result.funnel.samples, 600) << to_string(strategy);
    const auto about = found(result);
    EXPECT_NE(about, found(other.localize(test::demo_cloud().view()))) << to_string(strategy);
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(localizer.localize(test::demo_cloud().view(), result, {{0, nan, 0}}), std::invalid_argument);
  localizer.localize(test::demo_cloud().view(), result, {{50, 50, 50}});
  EXPECT_EQ(result.status, Status::kOk) << "nowhere near the cloud";
}

}  // namespace
}  // namespace handhold
