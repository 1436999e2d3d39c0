// Cutting a profile of radii where one part ends and the next begins.
#include "profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace handhold {
namespace {

constexpr double kWidth = 0.005, kSigma = 0.0012, kWeight = 8 / (kSigma * kSigma), kLeastJump = 0.0015;

std::vector<ProfilePiece> cut(const std::vector<double>& radii, double noise = 0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  std::vector<ProfileSlice> slices;
  for (const double r : radii) slices.push_back({r > 0 ? kWeight : 0, r + (noise > 0 ? noise * normal(random) : 0)});
  ProfileScratch scratch;
  std::vector<ProfilePiece> pieces;
  cut_profile(slices, kWidth, kLeastJump, kPiecePenalty, scratch, pieces);
  return pieces;
}

std::vector<double> run(std::size_t n, double radius, double slope = 0) {
  std::vector<double> r;
  for (std::size_t i = 0; i < n; ++i) r.push_back(radius + slope * kWidth * static_cast<double>(i));
  return r;
}
std::vector<double> operator+(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(Profile, CylinderIsOnePiece) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto pieces = cut(run(30, 0.02), kSigma / std::sqrt(8.0), seed);
    ASSERT_EQ(pieces.size(), 1u) << seed;
    EXPECT_EQ(pieces[0].first, 0u);
    EXPECT_EQ(pieces[0].last, 30u);
  }
}

TEST(Profile, CutsTheCapFromTheCanWhereItBegins) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto pieces = cut(run(20, 0.030) + run(7, 0.024), kSigma / std::sqrt(8.0), seed);
    ASSERT_EQ(pieces.size(), 2u) << seed;
    EXPECT_EQ(pieces[0].last, 20u);
    EXPECT_EQ(pieces[1].first, 20u);
    EXPECT_EQ(pieces[1].last, 27u);
  }
}

TEST(Profile, NeckAndBodyWithoutTheShoulderBetweenThem) {
  // Body, a shoulder of 45 degrees, neck.
  const auto pieces = cut(run(24, 0.036) + run(4, 0.033, -1) + run(12, 0.014));
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].first, 0u);
  EXPECT_NEAR(static_cast<double>(pieces[0].last), 24, 1);
  EXPECT_NEAR(static_cast<double>(pieces[1].first), 28, 1);
  EXPECT_EQ(pieces[1].last, 40u);
}

TEST(Profile, SlicesThatHoldPointsOfBothSidesDoNotJoinThem) {
  // A can and its cap; the two slices about the step are of both.
  const auto pieces = cut(run(9, 0.021) + run(2, 0.0234, 0.34) + run(30, 0.0264));
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].last, 9u);
  EXPECT_EQ(pieces[1].first, 11u);
}

TEST(Profile, GentleShoulderPartsNeckAndFoot) {
  const auto pieces = cut(run(12, 0.033) + run(5, 0.033, -0.25) + run(12, 0.0267));
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_LE(pieces[0].last, 13u);
  EXPECT_GE(pieces[1].first, 16u);
}

TEST(Profile, TaperAndWaistStayWhole) {
  EXPECT_EQ(cut(run(24, 0.030, 0.1)).size(), 1u) << "a cup";
  EXPECT_EQ(cut(run(12, 0.020, -0.08) + run(12, 0.0152, 0.08)).size(), 1u) << "two cones that meet";
}

TEST(Profile, PiecesAreInOrderAndWithinTheProfileWhateverItIs) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> radius(0.0, 0.04);
  for (int t = 0; t < 50; ++t) {
    std::vector<double> radii;
    for (int i = 0; i < t; ++i) radii.push_back(i % 5 == 3 ? 0 : radius(random));
    std::size_t at = 0;
    for (const ProfilePiece& p : cut(radii)) {
      EXPECT_GE(p.first, at);
      EXPECT_GT(p.last, p.first);
      EXPECT_LE(p.last, radii.size());
      at = p.last;
    }
  }
  EXPECT_TRUE(cut({}).empty());
  EXPECT_EQ(cut({0, 0, 0}).size(), 1u) << "nothing measured, nothing to cut";
}

}  // namespace
}  // namespace handhold
