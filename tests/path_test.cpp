// Paths of the planner: their samples and times, and how far joints move the robot.
#include "path.h"

#include <gtest/gtest.h>

#include "planner_helpers.h"

namespace handhold::plan {
namespace {

double largest_difference(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t j = 0; j < a.size(); ++j) largest = std::max(largest, std::fabs(a[j] - b[j]));
  return largest;
}

const Arm& baxter() {
  static const Arm arm = Arm::baxter(Side::kRight);
  return arm;
}

// ---- Samples --------------------------------------------------------------------------------------------------------

TEST(StraightPath, HasBothEndsAndNoSampleTooMany) {
  std::mt19937_64 generator(1);
  for (const double step : {0.01, 0.05, 0.3, 100.0}) {
    PlannerOptions options;
    options.step = step;
    const GraspPlanner planner(baxter(), options);
    for (int i = 0; i < 50; ++i) {
      const JointVector from = random_positions(baxter(), generator), to = random_positions(baxter(), generator);
      const std::vector<JointVector> path = planner.straight(from, to);
      ASSERT_GE(path.size(), 2u);
      EXPECT_EQ(path.front(), from);
      EXPECT_EQ(path.back(), to);
      const double farthest = largest_difference(from, to);
      EXPECT_EQ(path.size(), 1 + std::max(1.0, std::ceil(farthest / step)));
      for (std::size_t k = 1; k < path.size(); ++k) {
        EXPECT_LE(largest_difference(path[k], path[k - 1]), step * (1 + 1e-9));
        for (std::size_t j = 0; j < to.size(); ++j) {
          const double share = static_cast<double>(k) / static_cast<double>(path.size() - 1);
          EXPECT_NEAR(path[k][j], from[j] + share * (to[j] - from[j]), 1e-12);
        }
      }
    }
  }
}

TEST(StraightPath, RoundingAddsNoSample) {
  const JointVector from = {0.1, 0, 0, 0, 0, 0}, to = {0.4, 0, 0, 0, 0, 0};  // 0.4 - 0.1 > 3 * 0.1
  PlannerOptions options;
  options.step = 0.1;
  EXPECT_EQ(GraspPlanner(gantry_arm(), options).straight(from, to).size(), 4u);
}

TEST(StraightPath, OfNoLengthIsItsEnds) {
  const GraspPlanner planner(baxter());
  const JointVector& q = baxter().rest();
  EXPECT_EQ(planner.straight(q, q), (std::vector<JointVector>{q, q}));
  EXPECT_EQ(planner.times({q, q}, 0.5), (std::vector<double>{0, 0}));
}

TEST(StraightPath, RefusesWhatIsBeyondTheLimits) {
  const GraspPlanner planner(baxter());
  JointVector beyond = baxter().rest();
  beyond[1] = 9;
  EXPECT_MENTIONS(message_of([&] { planner.straight(baxter().rest(), beyond); }), "limits");
  EXPECT_MENTIONS(message_of([&] { planner.straight({0, 0}, baxter().rest()); }), "each joint");
}

// ---- Times ----------------------------------------------------------------------------------------------------------

GraspPlanner with_acceleration_time(double seconds, double step = 0.01) {
  PlannerOptions options;
  options.acceleration_time = seconds;
  options.step = step;
  return GraspPlanner(gantry_arm(), options);
}
JointVector along_x(double x) {
  return {x, 0, 0, 0, 0, 0};
}

TEST(Times, FollowTheTrapezoid) {
  // 1 m at a fifth of 1 m/s, 0.5 s from rest to that: 5 s and 0.5 s in all.
  const GraspPlanner planner = with_acceleration_time(0.5, 0.001);
  const std::vector<JointVector> path = planner.straight(along_x(0), along_x(1));
  const std::vector<double> times = planner.times(path, 0.2);
  ASSERT_EQ(times.size(), path.size());
  EXPECT_EQ(times.front(), 0);
  EXPECT_NEAR(times.back(), 5.5, 1e-9);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double t = times[i], left = times.back() - t;
    const double x = t < 0.5 ? 0.2 * t * t : left < 0.5 ? 1 - 0.2 * left * left : 0.2 * (t - 0.25);
    EXPECT_NEAR(path[i][0], x, 1e-9) << "at " << t << " s";
  }
}

TEST(Times, OfAShortWayHaveTwoRampsOnly) {
  // 0.02 m at up to 1 m/s, after 0.5 s: with 2 m/s^2 to the middle and back to rest.
  for (const double step : {0.001, 0.01, 0.0049}) {
    const GraspPlanner planner = with_acceleration_time(0.5, step);
    const std::vector<JointVector> path = planner.straight(along_x(0.1), along_x(0.12));
    const std::vector<double> times = planner.times(path, 1);
    EXPECT_NEAR(times.back(), 2 * std::sqrt(2 * 0.01 / 2), 1e-9);
    for (std::size_t i = 0; i < path.size(); ++i) {
      const double t = std::min(times[i], times.back() - times[i]);
      EXPECT_NEAR(std::min(path[i][0] - 0.1, 0.12 - path[i][0]), t * t, 1e-9);
    }
  }
}

/// Whatever the length: times that grow, and no speed or acceleration beyond what is asked for. The way in the middle
/// of which a sample lies is where ramps meet.
TEST(Times, GrowAndKeepTheLimitsForAnyLength) {
  std::mt19937_64 generator(2);
  for (const double ramp : {0.0, 0.05, 0.3, 2.0}) {
    for (const double speed : {0.05, 0.3, 1.0}) {
      const GraspPlanner planner = with_acceleration_time(ramp);
      for (int i = 1; i <= 60; ++i) {
        const double length = 0.0007 * i * i;
        const std::vector<JointVector> path = planner.straight(along_x(-1), along_x(length - 1));
        const std::vector<double> times = planner.times(path, speed);
        double before = 0;
        for (std::size_t k = 1; k < path.size(); ++k) {
          ASSERT_GT(times[k], times[k - 1]) << length << " m, sample " << k << " of " << path.size();
          const double v = (path[k][0] - path[k - 1][0]) / (times[k] - times[k - 1]);
          EXPECT_LE(v, speed * (1 + 1e-9));
          // The mean speed of a piece is that at its middle, or less far from it than the change over its half.
          const double middles = (times[k] - (k > 1 ? times[k - 2] : 0)) / 2;
          if (ramp > 0) {
            EXPECT_LE(std::fabs(v - before), speed / ramp * middles * (1 + 1e-6) + 1e-9);
          }
          before = v;
        }
      }
    }
  }
}

TEST(Times, AreAtRestAtBothEnds) {
  const GraspPlanner planner = with_acceleration_time(0.3, 0.001);
  for (const double length : {0.05, 1.5}) {
    const std::vector<JointVector> path = planner.straight(along_x(0), along_x(length));
    const std::vector<double> times = planner.times(path, 0.5);
    const std::size_t last = path.size() - 1;
    const double first_speed = (path[1][0] - path[0][0]) / (times[1] - times[0]);
    const double last_speed = (path[last][0] - path[last - 1][0]) / (times[last] - times[last - 1]);
    // Over the first millimetre from rest with 0.5 / 0.3 m/s^2 the mean speed is sqrt(a s / 2).
    EXPECT_NEAR(first_speed, std::sqrt(0.5 / 0.3 * (path[1][0] - path[0][0]) / 2), 1e-6);
    EXPECT_NEAR(last_speed, first_speed, 1e-6);
  }
}

TEST(Times, TheSlowestJointSetsThePace) {
  std::mt19937_64 generator(3);
  const GraspPlanner planner(baxter());
  for (int i = 0; i < 100; ++i) {
    std::vector<JointVector> path = {random_positions(baxter(), generator)};
    for (int corner = 0; corner < 3; ++corner) extend_straight(path, random_positions(baxter(), generator), 0.05);
    const std::vector<double> times = planner.times(path, 0.3);
    double fastest = 0;  // share of a limit
    for (std::size_t k = 1; k < path.size(); ++k) {
      ASSERT_GT(times[k], times[k - 1]);
      for (std::size_t j = 0; j < path[k].size(); ++j) {
        const double v = std::fabs(path[k][j] - path[k - 1][j]) / (times[k] - times[k - 1]);
        fastest = std::max(fastest, v / baxter().joints()[j].velocity);
      }
    }
    EXPECT_LE(fastest, 0.3 * (1 + 1e-9));
    EXPECT_GT(fastest, 0.3 * (1 - 1e-6)) << "no slower than it has to be";
  }
}

TEST(Times, RefuseWhatIsNoPath) {
  const GraspPlanner planner(baxter());
  EXPECT_TRUE(planner.times({}, 0.5).empty());
  EXPECT_EQ(planner.times({baxter().rest()}, 0.5), std::vector<double>{0});
  for (const double speed : {0.0, -1.0, 1.1, std::nan("")}) {
    EXPECT_MENTIONS(message_of([&] { planner.times({baxter().rest()}, speed); }), "speed");
  }
  EXPECT_MENTIONS(message_of([&] { planner.times({baxter().rest(), {0, 0}}, 0.5); }), "each joint");
}

// ---- What joints move -----------------------------------------------------------------------------------------------

/// Points on a shape's surface, its frame: the farthest from any axis are among them.
std::vector<Vector3> surface_points(const Shape& shape) {
  std::vector<Vector3> points;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double z : {-1.0, 0.0, 1.0}) {
        if (shape.kind == Shape::Kind::kBox) {
          points.push_back({x * shape.size[0] / 2, y * shape.size[1] / 2, z * shape.size[2] / 2});
        } else {
          points.push_back(shape.radius * normalized({x, y, z}));
          points.back()[2] += (z < 0 ? -0.5 : 0.5) * shape.length;
        }
      }
    }
  }
  return points;
}

void expect_sweeps_hold(const Arm& arm) {
  std::mt19937_64 generator(4);
  std::vector<double> most(arm.joints().size(), 0);
  for (int i = 0; i < 100; ++i) {
    const JointVector q = random_positions(arm, generator);
    const double opening = std::uniform_real_distribution<>(0, arm.hand().opening_max)(generator);
    const std::vector<Pose> before = arm.link_poses(q, opening);
    for (std::size_t j = 0; j < q.size(); ++j) {
      constexpr double kTurn = 1e-4;
      JointVector turned = q;
      turned[j] += kTurn;
      const std::vector<Pose> after = arm.link_poses(turned, opening);
      for (const Shape& shape : arm.shapes()) {
        for (const Vector3& p : surface_points(shape)) {
          const double moved = norm((after[shape.link] * shape.T_link_shape).point(p) -
                                    (before[shape.link] * shape.T_link_shape).point(p));
          ASSERT_LE(moved, arm.sweeps()[j] * kTurn + 1e-12) << arm.joints()[j].name << ", " << arm.links()[shape.link];
          most[j] = std::max(most[j], moved / kTurn);
        }
      }
    }
  }
  // Not so large that paths are cut for nothing; joints about an arm's own length may say more.
  EXPECT_LT(arm.sweeps()[0], 1.5 * most[0]);
}

TEST(Sweeps, NothingMovesFarther) {
  expect_sweeps_hold(Arm::baxter(Side::kRight));
  expect_sweeps_hold(Arm::baxter(Side::kLeft, kExtendedNarrow));
  expect_sweeps_hold(gantry_arm());
}

TEST(LinkJoints, ALinkMovesWithTheFirstOfThem) {
  std::mt19937_64 generator(5);
  for (const Arm& arm : {Arm::baxter(Side::kRight), Arm::baxter(Side::kLeft), gantry_arm()}) {
    ASSERT_EQ(arm.link_joints().size(), arm.links().size());
    EXPECT_EQ(arm.link_joints()[arm.link_index(arm.tip())], arm.joints().size());
    EXPECT_EQ(arm.link_joints()[arm.link_index(arm.base())], 0u);
    const JointVector q = random_positions(arm, generator);
    const std::vector<Pose> before = arm.link_poses(q);
    for (std::size_t j = 0; j < q.size(); ++j) {
      JointVector turned = q;
      turned[j] += 0.1;
      const std::vector<Pose> after = arm.link_poses(turned);
      for (std::size_t link = 0; link < before.size(); ++link) {
        const double moved = distance(before[link], after[link]) + angle(before[link], after[link]);
        EXPECT_EQ(moved > 1e-6, j < arm.link_joints()[link]) << arm.links()[link] << ", " << arm.joints()[j].name;
      }
    }
  }
}

TEST(Mount, IsWhereTheFirstJointHangs) {
  // right_arm_mount, left_arm_mount of baxter_common 1.2.0
  const Vector3 right = Arm::baxter(Side::kRight).mount(), left = Arm::baxter(Side::kLeft).mount();
  EXPECT_NEAR(right[0], 0.024645, 1e-6);
  EXPECT_NEAR(right[1], -0.219645, 1e-6);
  EXPECT_NEAR(right[2], 0.118588, 1e-6);
  EXPECT_NEAR(left[0], 0.024645, 1e-6);
  EXPECT_NEAR(left[1], 0.219645, 1e-6);
  EXPECT_NEAR(left[2], 0.118588, 1e-6);
  EXPECT_EQ(gantry_arm().mount(), (Vector3{0, 0, 0}));
}

}  // namespace
}  // namespace handhold::plan
