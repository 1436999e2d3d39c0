// Of several explanations of one place one stays.
#include "resolve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace handhold {
namespace {

std::uint32_t next_member = 0;

/// A straight part along x between two places (m).
PartCandidate part(double from, double to, double radius, double confidence, double y = 0) {
  PartCandidate c;
  c.handle.center = {0.5 * (from + to), y, 0.8};
  c.handle.axis = {1, 0, 0};
  c.handle.radius = radius;
  c.handle.length = to - from;
  c.handle.confidence = confidence;
  c.handle.affordances = {next_member++};
  c.evidence.sigma = 0.001;
  return c;
}

std::vector<PartCandidate> resolved(const std::vector<PartCandidate>& candidates, bool continue_parts = true) {
  std::vector<const PartCandidate*> all;
  for (const PartCandidate& c : candidates) all.push_back(&c);
  Recycled<PartCandidate> kept;
  Resolver().run(all, continue_parts, kept);
  return {kept.begin(), kept.end()};
}

TEST(Resolve, PiecesOfOnePartBecomeOne) {
  const auto kept = resolved({part(0, 0.05, 0.012, 0.9), part(0.07, 0.12, 0.0122, 0.8)});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_NEAR(kept[0].handle.center[0], 0.06, 1e-12);
  EXPECT_NEAR(kept[0].handle.length, 0.12, 1e-12);
  EXPECT_EQ(kept[0].handle.affordances.size(), 2u);
  EXPECT_EQ(resolved({part(0, 0.05, 0.012, 0.9), part(0.07, 0.12, 0.0122, 0.8)}, false).size(), 2u);
}

TEST(Resolve, WhatIsHardlyAPartMakesNoOtherOneLonger) {
  const auto kept = resolved({part(0, 0.05, 0.012, 0.98), part(0.06, 0.16, 0.0122, 0.05)});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_NEAR(kept[0].handle.center[0], 0.025, 1e-12);
  EXPECT_NEAR(kept[0].handle.length, 0.05, 1e-12);
}

TEST(Resolve, OfSureExplanationsOfOnePlaceTheLongestStays) {
  PartCandidate bend = part(0.08, 0.105, 0.0095, 0.99);
  bend.handle.axis = normalized(Vector3{1, 0.6, 0});
  const PartCandidate straight = part(0, 0.11, 0.0105, 0.95);
  auto kept = resolved({bend, straight});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].handle.length, straight.handle.length);
  // One that is not sure does not win by its length.
  PartCandidate unsure = straight;
  unsure.handle.confidence = 0.6;
  kept = resolved({bend, unsure});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].handle.length, bend.handle.length);
}

TEST(Resolve, StepsAndOtherRadiiPartPieces) {
  // A step between both, and the gap of a neck.
  PartCandidate grip = part(0, 0.05, 0.012, 0.9), head = part(0.08, 0.13, 0.0122, 0.8);
  EXPECT_EQ(resolved({grip, head}).size(), 1u) << "else this test tells nothing";
  grip.ends_high = head.ends_low = true;
  EXPECT_EQ(resolved({grip, head}).size(), 2u);
  // A thinner part in the gap.
  EXPECT_EQ(resolved({part(0, 0.05, 0.012, 0.9), part(0.055, 0.075, 0.007, 0.7), part(0.08, 0.13, 0.0122, 0.8)}).size(),
            3u);
  // Other radii, and other lines.
  EXPECT_EQ(resolved({part(0, 0.05, 0.012, 0.9), part(0.05, 0.1, 0.02, 0.8)}).size(), 2u);
  EXPECT_EQ(resolved({part(0, 0.05, 0.012, 0.9), part(0.05, 0.1, 0.012, 0.8, 0.03)}).size(), 2u);
}

TEST(Resolve, TheSurestComesFirst) {
  const auto kept =
      resolved({part(0, 0.2, 0.012, 0.9), part(0, 0.03, 0.012, 0.99, 0.1), part(0, 0.1, 0.012, 0.3, 0.2)});
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_EQ(kept[0].handle.confidence, 0.99);
  EXPECT_EQ(kept[1].handle.confidence, 0.9);
  EXPECT_EQ(kept[2].handle.confidence, 0.3);
  EXPECT_TRUE(resolved({}).empty());
}

TEST(Resolve, ABowTakesThePiecesAlongItAndNoLongerOnes) {
  PartCandidate bow = part(0, 0.03, 0.008, 0.95);
  for (int k = 0; k <= 12; ++k) {  // a quarter of a circle of 40 mm about (0, 0.04)
    const double angle = -1.5708 + 0.1309 * k;
    bow.handle.path.push_back({0.04 * std::cos(angle), 0.04 + 0.04 * std::sin(angle), 0.8});
  }
  bow.handle.center = bow.handle.path[6];
  bow.handle.axis = normalized(bow.handle.path[8] - bow.handle.path[4]);
  PartCandidate piece = part(0, 0.02, 0.008, 0.8);
  piece.handle.center = bow.handle.path[2];
  piece.handle.axis = normalized(bow.handle.path[4] - bow.handle.path[0]);
  auto kept = resolved({bow, piece});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].handle.affordances.size(), 2u);
  // A straight part that only ends there is another one.
  piece.handle.center = bow.handle.path[0] - 0.05 * Vector3{1, 0, 0};
  piece.handle.axis = {1, 0, 0}, piece.handle.length = 0.12;
  EXPECT_EQ(resolved({bow, piece}).size(), 2u);
}

}  // namespace
}  // namespace handhold
