// Inverse kinematics: that what can be reached is found, within the limits, near the reference, the same every time.
#include <gtest/gtest.h>

#include <thread>

#include "planner_helpers.h"

namespace handhold::plan {
namespace {

TEST(Arm, FindsJointPositionsForReachablePoses) {
  for (const Side side : {Side::kRight, Side::kLeft}) {
    const Arm arm = Arm::baxter(side);
    std::mt19937_64 generator(5);
    int found = 0;
    constexpr int kPoses = 250;
    for (int i = 0; i < kPoses; ++i) {
      const Pose T_base_tip = arm.forward(random_positions(arm, generator));
      EXPECT_TRUE(arm.may_reach(T_base_tip));
      const auto q = arm.inverse(T_base_tip);
      if (!q) continue;
      ++found;
      EXPECT_TRUE(arm.within_limits(*q));
      EXPECT_LT(distance(arm.forward(*q), T_base_tip), 1.01e-5);
      EXPECT_LT(angle(arm.forward(*q), T_base_tip), 1.01e-4);
    }
    EXPECT_GE(found, kPoses * 99 / 100);
  }
}

TEST(Arm, SolutionsAreNearTheReference) {
  const Arm arm = Arm::baxter(Side::kRight);
  std::mt19937_64 generator(7);
  for (int i = 0; i < 20; ++i) {
    IkOptions options;
    options.reference = random_positions(arm, generator);
    JointVector near = options.reference;
    for (std::size_t k = 0; k < near.size(); ++k) {
      near[k] = std::min(std::max(near[k] + 0.02, arm.joints()[k].lower), arm.joints()[k].upper);
    }
    const auto q = arm.inverse(arm.forward(near), options);
    ASSERT_TRUE(q);
    for (std::size_t k = 0; k < near.size(); ++k) EXPECT_NEAR((*q)[k], near[k], 0.8);
  }
}

TEST(Arm, ListsDifferentSolutionsNearestFirst) {
  const Arm arm = Arm::baxter(Side::kRight);
  const Pose T_base_tip = arm.forward({0.08, -1, 1.19, 1.94, -0.67, 1.03, 0.5});
  std::vector<JointVector> solutions = {{1, 2, 3}};
  const std::size_t count = arm.inverse_all(T_base_tip, 6, {}, solutions);
  ASSERT_EQ(count, 6u);
  ASSERT_EQ(solutions.size(), 7u);
  EXPECT_EQ(solutions[0], (JointVector{1, 2, 3}));
  double last = 0;
  for (std::size_t i = 1; i < solutions.size(); ++i) {
    EXPECT_TRUE(arm.within_limits(solutions[i]));
    EXPECT_LT(distance(arm.forward(solutions[i]), T_base_tip), 1.01e-5);
    double squares = 0;
    for (std::size_t k = 0; k < 7; ++k) squares += std::pow(solutions[i][k] - arm.rest()[k], 2);
    EXPECT_GE(squares, last);
    last = squares;
    for (std::size_t j = 1; j < i; ++j) {
      double largest = 0;
      for (std::size_t k = 0; k < 7; ++k) largest = std::max(largest, std::fabs(solutions[i][k] - solutions[j][k]));
      EXPECT_GE(largest, IkOptions().min_distance);
    }
  }
}

TEST(Arm, RefusesPosesOutOfReach) {
  const Arm arm = Arm::baxter(Side::kRight);
  Pose T_base_tip = arm.forward(arm.rest());
  T_base_tip.t = {2, 0, 0.2};
  EXPECT_FALSE(arm.may_reach(T_base_tip));
  EXPECT_FALSE(arm.inverse(T_base_tip));
  std::vector<JointVector> solutions;
  EXPECT_EQ(arm.inverse_all(T_base_tip, 3, {}, solutions), 0u);

  // Within the length of the arm, but in its own shoulder.
  IkOptions options;
  options.restarts = 5;
  options.fallback_restarts = 2;
  T_base_tip.t = {0.064, -0.259, 0.4};
  EXPECT_TRUE(arm.may_reach(T_base_tip));
  EXPECT_FALSE(arm.inverse(T_base_tip, options));
}

TEST(Arm, InverseRepeatsItselfFromAnyThread) {
  const Arm arm = Arm::baxter(Side::kRight);
  std::mt19937_64 generator(11);
  std::vector<Pose> poses;
  for (int i = 0; i < 20; ++i) poses.push_back(arm.forward(random_positions(arm, generator)));
  std::vector<std::vector<std::optional<JointVector>>> found(4);
  std::vector<std::thread> threads;
  for (auto& results : found) {
    threads.emplace_back([&] {
      for (const Pose& pose : poses) results.push_back(arm.inverse(pose));
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& results : found) EXPECT_EQ(results, found[0]);

  IkOptions other;
  other.seed = 1;
  int different = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) different += arm.inverse(poses[i], other) != found[0][i];
  EXPECT_GT(different, 0);
}

TEST(Arm, RefusesPosesAndOptionsThatCannotBe) {
  const Arm arm = Arm::baxter(Side::kRight);
  const Pose T_base_tip = arm.forward(arm.rest());
  Pose bad = T_base_tip;
  bad.R[0] += 0.1;
  EXPECT_MENTIONS(message_of([&] { arm.inverse(bad); }), "R must be a rotation");
  bad = T_base_tip;
  for (double& value : bad.R) value = -value;  // a reflection
  EXPECT_MENTIONS(message_of([&] { arm.inverse(bad); }), "R must be a rotation");
  bad = T_base_tip;
  bad.t[1] = NAN;
  EXPECT_MENTIONS(message_of([&] { arm.inverse(bad); }), "t finite");

  IkOptions options;
  options.reference = {0, 0};
  EXPECT_MENTIONS(message_of([&] { arm.inverse(T_base_tip, options); }), "reference:");
  options.reference = {9, 0, 0, 0, 0, 0, 0};
  EXPECT_MENTIONS(message_of([&] { arm.inverse(T_base_tip, options); }), "reference:");
  options = {};
  options.restarts = -1;
  EXPECT_MENTIONS(message_of([&] { arm.inverse(T_base_tip, options); }), "restarts:");
  options = {};
  options.candidates = 0;
  EXPECT_MENTIONS(message_of([&] { arm.inverse(T_base_tip, options); }), "candidates:");
}

TEST(Arm, FindsJointsThatStandAtTheirLimits) {
  const Arm arm = Arm::baxter(Side::kRight);
  std::mt19937_64 generator(13);
  int found = 0;
  constexpr int kPoses = 200;
  for (int i = 0; i < kPoses; ++i) {
    JointVector q = random_positions(arm, generator);
    for (std::size_t k = 0; k < q.size(); ++k) {
      const int where = static_cast<int>(generator() % 4);
      if (where < 2) q[k] = where ? arm.joints()[k].upper : arm.joints()[k].lower;
    }
    IkOptions options;
    options.restarts = 12;  // enough, if limits are heeded on the way and not only in the end
    options.fallback_restarts = 0;
    const Pose T_base_tip = arm.forward(q);
    const auto solution = arm.inverse(T_base_tip, options);
    if (!solution) continue;
    ++found;
    EXPECT_TRUE(arm.within_limits(*solution));
    EXPECT_LT(distance(arm.forward(*solution), T_base_tip), 1.01e-5);
    EXPECT_LT(angle(arm.forward(*solution), T_base_tip), 1.01e-4);
  }
  EXPECT_GE(found, kPoses * 9 / 10);
}

TEST(Arm, AJointThatTurnsMoreThanOnceStaysInItsTurn) {
  const Arm arm = gantry_arm();  // turns by 3.5 rad both ways
  for (const double roll : {3.3, -3.3, 3.1, 0.2}) {
    const JointVector there = {0.4, 0.1, -0.2, 0.3, 0.2, roll};
    IkOptions options;
    options.reference = {0.4, 0.1, -0.2, 0.3, 0.2, roll + (roll < 0 ? -0.1 : 0.1)};
    const auto q = arm.inverse(arm.forward(there), options);
    ASSERT_TRUE(q);
    for (std::size_t k = 0; k < there.size(); ++k) EXPECT_NEAR((*q)[k], there[k], 1e-3);
  }
}

TEST(Arm, ASlideStopsAtItsLimit) {
  const Arm arm = gantry_arm();
  for (const double x : {1.9, 2.1}) {
    const Pose T_base_tip = sensor::translation(x, 0, 0) * arm.forward(arm.rest());
    EXPECT_TRUE(arm.may_reach(T_base_tip));
    EXPECT_EQ(arm.inverse(T_base_tip).has_value(), x < 2);
  }
}

}  // namespace
}  // namespace handhold::plan
