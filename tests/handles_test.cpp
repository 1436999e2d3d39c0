// Handles from affordances whose parts are known.
#include "handles.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "paper_options.h"
#include "test_clouds.h"

namespace handhold {
namespace {

using test::Random;
using test::Vector3d;

Vector3d eigen(const Vector3& v) {
  return {v[0], v[1], v[2]};
}
Vector3 plain(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Vector3d canonical(const Vector3d& axis) {
  Eigen::Index largest;
  axis.cwiseAbs().maxCoeff(&largest);
  return axis[largest] < 0 ? Vector3d(-axis) : axis;
}

Affordance affordance(const Vector3d& center, const Vector3d& axis, double radius) {
  Affordance a;
  a.center = plain(center);
  a.axis = plain(canonical(axis.normalized()));
  const Vector3d n = Vector3d(0, 0, -1) + axis.normalized().z() * axis.normalized();
  a.normal = plain(n.normalized());
  a.radius = radius, a.shell_radius = radius, a.gap = 0.01;
  return a;
}

/// n affordances spaced evenly from `from` to `to`; axes scatter by `angle` (rad), centres by `offset` (m, each
/// coordinate).
std::vector<Affordance> part(int n, const Vector3d& from, const Vector3d& to, double radius, Random* random = nullptr,
                             double angle = 0, double offset = 0) {
  std::vector<Affordance> all;
  const Vector3d axis = (to - from).normalized();
  for (int i = 0; i < n; ++i) {
    Vector3d c = from + (n > 1 ? i / (n - 1.0) : 0) * (to - from), a = axis;
    if (random) {
      const Vector3d across = axis.cross(random->direction()).normalized();
      const double askew = random->uniform(-angle, angle);
      a = std::cos(askew) * axis + std::sin(askew) * across;
      c += random->normal3(offset);
    }
    all.push_back(affordance(c, a, radius));
  }
  return all;
}

void append(std::vector<Affordance>& all, const std::vector<Affordance>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

struct Outcome {
  std::vector<Handle> handles;
  Funnel funnel;
};

/// Runs the search and checks what holds for every result.
Outcome search(const std::vector<Affordance>& affordances, const Options& options = {}) {
  Outcome outcome;
  outcome.handles.resize(3);  // left over from another frame
  Spares<Handle> spares;
  HandleSearch(options).run(affordances, spares, outcome.handles, outcome.funnel);
  std::set<std::uint32_t> used;
  double before = 1;
  for (const Handle& h : outcome.handles) {
    EXPECT_LE(h.confidence, before) << "best first";
    before = h.confidence;
    EXPECT_GE(h.confidence, options.effective_min_confidence());
    EXPECT_GE(h.length, options.handle_min_length);
    EXPECT_GE(static_cast<int>(h.affordances.size()), options.handle_min_affordances);
    EXPECT_TRUE(std::is_sorted(h.affordances.begin(), h.affordances.end()));
    for (const std::uint32_t i : h.affordances) {
      EXPECT_LT(i, affordances.size());
      EXPECT_TRUE(used.insert(i).second) << "affordance " << i << " is in two handles";
    }
    EXPECT_NEAR(eigen(h.axis).norm(), 1, 1e-9);
    EXPECT_NEAR(eigen(h.approach).norm(), 1, 1e-9);
    EXPECT_NEAR(eigen(h.approach).dot(eigen(h.axis)), 0, 1e-9);
  }
  const Funnel& f = outcome.funnel;
  EXPECT_EQ(f.not_aligned + f.too_short + f.low_confidence + f.in_handles,
            static_cast<std::int64_t>(affordances.size()));
  EXPECT_GE(f.in_handles, static_cast<std::int64_t>(used.size()));  // with those askew on a handle's part
  return outcome;
}

const Vector3d kOrigin(0.1, -0.05, 0.7);
const Vector3d kAxis = Vector3d(3, 1, 0.5).normalized();

TEST(HandleSearch, FindsNothingInNothing) {
  EXPECT_TRUE(search({}).handles.empty());
}

TEST(HandleSearch, DescribesOnePart) {
  const auto outcome = search(part(21, kOrigin, kOrigin + 0.1 * kAxis, 0.015));
  ASSERT_EQ(outcome.handles.size(), 1u);
  const Handle& h = outcome.handles.front();
  EXPECT_NEAR(h.length, 0.1, 1e-9);
  EXPECT_NEAR(h.radius, 0.015, 1e-12);
  EXPECT_LT((eigen(h.center) - kOrigin - 0.05 * kAxis).norm(), 1e-9);
  EXPECT_LT((eigen(h.axis) - kAxis).norm(), 1e-9);
  EXPECT_EQ(h.affordances.size(), 21u);
  // Normals look against z, so a hand moves along z as far as the axis lets it.
  const Vector3d towards = (Vector3d(0, 0, 1) - kAxis.z() * kAxis).normalized();
  EXPECT_LT((eigen(h.approach) - towards).norm(), 1e-9);
}

TEST(HandleSearch, CutsAtGapsOnly) {
  const Options options = test::paper_options();
  for (const double gap : {0.9 * options.handle_gap, 1.2 * options.handle_gap, 0.1}) {
    SCOPED_TRACE(gap);
    // lengths differ, so that it is known which handle comes first
    auto affordances = part(13, kOrigin, kOrigin + 0.06 * kAxis, 0.015);
    append(affordances, part(17, kOrigin + (0.06 + gap) * kAxis, kOrigin + (0.14 + gap) * kAxis, 0.015));
    const auto outcome = search(affordances);
    if (gap < options.handle_gap) {
      ASSERT_EQ(outcome.handles.size(), 1u);
      EXPECT_NEAR(outcome.handles[0].length, 0.14 + gap, 1e-9);
    } else {
      ASSERT_EQ(outcome.handles.size(), 2u);
      EXPECT_NEAR(outcome.handles[0].length, 0.08, 1e-9);
      EXPECT_NEAR(outcome.handles[1].length, 0.06, 1e-9);
    }
    EXPECT_EQ(outcome.funnel.in_handles, 30);
  }
}

TEST(HandleSearch, ReportsAPartWithScatteredAxesOnce) {
  // Axes of up to 0.45 rad askew: many pairs differ by more than align_angle, so no affordance is aligned with all
  // others.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto outcome = search(part(120, kOrigin, kOrigin + 0.1 * kAxis, 0.015, &random, 0.45, 0.001));
    ASSERT_EQ(outcome.handles.size(), 1u);
    EXPECT_NEAR(outcome.handles[0].length, 0.1, 0.015);
    EXPECT_GT(std::abs(eigen(outcome.handles[0].axis).dot(kAxis)), std::cos(0.1));
  }
}

TEST(HandleSearch, NeedsLengthAndNumber) {
  Options options = test::paper_options();
  auto outcome = search(part(10, kOrigin, kOrigin + 0.9 * options.handle_min_length * kAxis, 0.015), options);
  EXPECT_TRUE(outcome.handles.empty());
  EXPECT_EQ(outcome.funnel.too_short, 10);

  outcome = search(part(10, kOrigin, kOrigin + 1.1 * options.handle_min_length * kAxis, 0.015), options);
  EXPECT_EQ(outcome.handles.size(), 1u);

  // Two affordances are fewer than three; a third one makes a group.
  const Vector3d end = kOrigin + 1.25 * options.handle_min_length * kAxis;
  options.min_confidence = 0;
  outcome = search(part(2, kOrigin, end, 0.015), options);
  EXPECT_TRUE(outcome.handles.empty());
  EXPECT_EQ(outcome.funnel.not_aligned, 2);
  EXPECT_EQ(search(part(3, kOrigin, end, 0.015), options).handles.size(), 1u);

  options.min_confidence = 1;
  outcome = search(part(10, kOrigin, kOrigin + 0.1 * kAxis, 0.015), options);
  EXPECT_TRUE(outcome.handles.empty());
  EXPECT_EQ(outcome.funnel.low_confidence, 10);
}

TEST(HandleSearch, LeavesStrayAffordancesOut) {
  Random random(8);
  auto affordances = part(15, kOrigin, kOrigin + 0.1 * kAxis, 0.015);
  for (int i = 0; i < 40; ++i) {
    const Vector3d at = kOrigin + Vector3d(0, 0, 1) + random.uniform(0, 1) * random.direction();
    affordances.push_back(affordance(at, random.direction(), random.uniform(0.005, 0.04)));
  }
  const auto outcome = search(affordances);
  ASSERT_EQ(outcome.handles.size(), 1u);
  EXPECT_EQ(outcome.handles[0].affordances.size(), 15u);
  for (std::uint32_t i = 0; i < 15; ++i) EXPECT_EQ(outcome.handles[0].affordances[i], i);
}

TEST(HandleSearch, SeparatesRadii) {
  // A thin rod goes on where a thick one ends: no gap along the axis.
  auto affordances = part(21, kOrigin, kOrigin + 0.1 * kAxis, 0.012);
  append(affordances, part(17, kOrigin + 0.105 * kAxis, kOrigin + 0.185 * kAxis, 0.03));
  const auto outcome = search(affordances);
  ASSERT_EQ(outcome.handles.size(), 2u);
  EXPECT_NEAR(outcome.handles[0].radius, 0.012, 1e-12);
  EXPECT_NEAR(outcome.handles[1].radius, 0.03, 1e-12);

  Options loose;
  loose.align_radius = 0.02;
  EXPECT_EQ(search(affordances, loose).handles.size(), 1u);
}

TEST(HandleSearch, SeparatesParallelAndCrossingParts) {
  const Vector3d across = kAxis.cross(Vector3d(0, 0, 1)).normalized();
  auto affordances = part(21, kOrigin, kOrigin + 0.1 * kAxis, 0.015);
  append(affordances, part(17, kOrigin + 0.05 * across, kOrigin + 0.05 * across + 0.08 * kAxis, 0.015));
  EXPECT_EQ(search(affordances).handles.size(), 2u);

  affordances = part(21, kOrigin - 0.05 * kAxis, kOrigin + 0.05 * kAxis, 0.015);
  append(affordances, part(17, kOrigin - 0.04 * across, kOrigin + 0.04 * across, 0.015));
  const auto outcome = search(affordances);
  ASSERT_EQ(outcome.handles.size(), 2u);
  EXPECT_LT((eigen(outcome.handles[0].axis) - canonical(kAxis)).norm(), 1e-6);
  EXPECT_LT((eigen(outcome.handles[1].axis) - canonical(across)).norm(), 1e-6);
}

TEST(HandleSearch, PutsTheBestFirst) {
  std::vector<Affordance> affordances;
  const int number[] = {5, 30, 12, 20};
  for (int i = 0; i < 4; ++i) {
    const Vector3d from = kOrigin + Vector3d(0, 0.2 * i, 0);
    append(affordances, part(number[i], from, from + 0.004 * number[i] * Vector3d(1, 0, 0), 0.015));
  }
  Options options = test::paper_options();
  options.min_confidence = 0;
  const auto outcome = search(affordances, options);
  ASSERT_EQ(outcome.handles.size(), 4u);
  const std::size_t expected[] = {30, 20, 12, 5};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(outcome.handles[i].affordances.size(), expected[i]);
}

TEST(HandleSearch, GivesTheSameTwice) {
  Random random(9);
  auto affordances = part(150, kOrigin, kOrigin + 0.1 * kAxis, 0.015, &random, 0.4, 0.002);
  append(affordances, part(150, kOrigin, kOrigin + Vector3d(0, 0, 0.15), 0.02, &random, 0.4, 0.002));
  const Options options = test::paper_options();
  HandleSearch reused(options);
  Spares<Handle> spares;
  const auto fresh = search(affordances);
  ASSERT_FALSE(fresh.handles.empty());
  for (int i = 0; i < 3; ++i) {
    Funnel funnel;
    std::vector<Handle> handles;
    reused.run(part(70, kOrigin, kOrigin + 0.2 * kAxis, 0.01), spares, handles, funnel);  // another frame in between
    funnel = {};
    reused.run(affordances, spares, handles, funnel);
    ASSERT_EQ(handles.size(), fresh.handles.size());
    for (std::size_t h = 0; h < handles.size(); ++h) {
      EXPECT_EQ(handles[h].affordances, fresh.handles[h].affordances);
      EXPECT_EQ(handles[h].center, fresh.handles[h].center);
      EXPECT_EQ(handles[h].axis, fresh.handles[h].axis);
      EXPECT_EQ(handles[h].confidence, fresh.handles[h].confidence);
    }
    EXPECT_EQ(funnel.in_handles, fresh.funnel.in_handles);
    EXPECT_EQ(funnel.not_aligned, fresh.funnel.not_aligned);
  }
}

}  // namespace
}  // namespace handhold
