// Straight pieces of a curved handle become one.
#include "chain.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vec3.h"

namespace handhold {
namespace {

Handle piece(const Vector3& from, const Vector3& to, double radius, double confidence, std::uint32_t member) {
  Handle h{};
  h.center = 0.5 * (from + to);
  h.axis = canonical_axis(normalized(to - from));
  h.approach = any_perpendicular(h.axis);
  h.length = norm(to - from);
  h.radius = radius;
  h.confidence = confidence;
  h.affordances = {member};
  return h;
}

/// Corner k of a bow of radius 35 mm that runs over half a circle in four pieces of 45 degrees.
Vector3 corner(int k) {
  const double angle = 0.7853981633974483 * k;
  return {0.035 * std::cos(angle), 0.035 * std::sin(angle), 0.8};
}

void joined(std::vector<Handle>& handles) {
  Spares<Handle> spares;
  ChainSearch().join_curved(handles, spares);
}

TEST(JoinCurved, PiecesOfABowAreOneHandle) {
  std::vector<Handle> handles;
  const int order[4] = {2, 0, 3, 1};
  for (int i = 0; i < 4; ++i) {
    handles.push_back(piece(corner(order[i]), corner(order[i] + 1), 0.008 + 0.0002 * i, 0.9 - 0.1 * i,
                            static_cast<std::uint32_t>(order[i])));
  }
  joined(handles);
  ASSERT_EQ(handles.size(), 1u);
  const Handle& h = handles[0];
  EXPECT_EQ(h.confidence, 0.9);
  EXPECT_EQ(h.affordances, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  ASSERT_EQ(h.path.size(), 5u);
  EXPECT_NEAR(h.length, 4 * norm(corner(1) - corner(0)), 1e-12);
  EXPECT_LT(norm(h.center - corner(2)), 1e-12) << "the middle of the path";
  EXPECT_NEAR(norm(h.axis), 1, 1e-12);
  EXPECT_LT(std::fabs(dot(h.axis, h.approach)), 1e-12);
  EXPECT_NEAR(h.radius, 0.0083, 1e-9);
  // From one end to the other, whichever comes first.
  EXPECT_LT(std::min(norm(h.path.front() - corner(0)), norm(h.path.front() - corner(4))), 1e-12);
  EXPECT_LT(std::min(norm(h.path.back() - corner(0)), norm(h.path.back() - corner(4))), 1e-12);
}

TEST(JoinCurved, LeavesAloneWhatIsNoBow) {
  const Vector3 a{0, 0, 1}, b{0.06, 0, 1}, across{0.06, 0.05, 1}, beyond{0.12, 0, 1}, turned{0.11, 0.03, 1};
  const auto stays = [](const Handle& g, const Handle& h) {
    std::vector<Handle> handles = {g, h};
    joined(handles);
    return handles.size() == 2 && handles[0].path.empty() && handles[1].path.empty();
  };
  EXPECT_FALSE(stays(piece(a, b, 0.008, 0.9, 0), piece(b, turned, 0.008, 0.8, 1))) << "else this test tells nothing";
  EXPECT_TRUE(stays(piece(a, b, 0.008, 0.9, 0), piece(b, beyond, 0.008, 0.8, 1))) << "straight on";
  EXPECT_TRUE(stays(piece(a, b, 0.008, 0.9, 0), piece(b, across, 0.008, 0.8, 1))) << "a right angle";
  EXPECT_TRUE(stays(piece(a, b, 0.008, 0.9, 0), piece(b, turned, 0.016, 0.8, 1))) << "another radius";
  EXPECT_TRUE(stays(piece(a, b, 0.030, 0.9, 0), piece(b, turned, 0.030, 0.8, 1))) << "bodies";
  const Vector3 far{0.03, 0, 0};
  EXPECT_TRUE(stays(piece(a, b, 0.008, 0.9, 0), piece(b + far, turned + far, 0.008, 0.8, 1))) << "a gap";
  std::vector<Handle> none;
  joined(none);
  EXPECT_TRUE(none.empty());
}

TEST(JoinCurved, ARingEnds) {
  std::vector<Handle> handles;
  for (int k = 0; k < 8; ++k) {
    handles.push_back(piece(corner(k), corner(k + 1), 0.008, 0.9, static_cast<std::uint32_t>(k)));
  }
  joined(handles);
  ASSERT_EQ(handles.size(), 1u);
  EXPECT_EQ(handles[0].path.size(), 9u);
}

}  // namespace
}  // namespace handhold
