// Grasps that the planner gives: where they are, and in which order they come. (planner_grasps_test: that they can be
// carried out.)
#include "handhold/planner.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <map>
#include <thread>

#include "hand_poses.h"
#include "planner_helpers.h"

namespace handhold::plan {
namespace {

constexpr double kPi = 3.141592653589793;

const Arm& baxter() {
  static const Arm arm = Arm::baxter(Side::kRight);
  return arm;
}
PlannerOptions all_grasps() {
  PlannerOptions options;
  options.max_grasps = 0;
  return options;
}

// ---- Where the hand goes --------------------------------------------------------------------------------------------

/// Of a straight handle: what every grasp has to be, whichever place and approach were chosen.
void expect_on_handle(const Grasp& grasp, const Handle& handle, const PlannerOptions& options, const Vector3& mount) {
  const Vector3 x = column(grasp.grasp, 0), y = column(grasp.grasp, 1), z = column(grasp.grasp, 2);
  EXPECT_NEAR(norm(x), 1, 1e-9);
  EXPECT_NEAR(norm(cross(x, y) - z), 0, 1e-9);
  EXPECT_NEAR(dot(z, handle.axis), 0, 1e-9);
  EXPECT_NEAR(dot(y, handle.axis), 0, 1e-9);
  EXPECT_NEAR(norm(z - grasp.approach), 0, 1e-9);

  // Along its approach, the hand's frame passes the axis at one of the places, and goes one of the depths beyond.
  const Vector3 off = grasp.grasp.t - handle.center;
  const double depth = dot(off, z), shift = dot(off, handle.axis);
  EXPECT_NEAR(dot(off, y), 0, 1e-9);
  const auto is_one_of = [](double value, const std::vector<double>& values, double scale) {
    return std::any_of(values.begin(), values.end(), [&](double v) { return std::fabs(scale * v - value) < 1e-9; });
  };
  EXPECT_TRUE(is_one_of(depth, options.depths, 1)) << depth;
  EXPECT_TRUE(is_one_of(shift, options.places, handle.length / 2)) << shift;

  // Turned back by its angle, the approach lies in the plane of the axis and the line from the mount.
  const Vector3 place = handle.center + shift * handle.axis;
  const Vector3 paper = sensor::rotation(handle.axis, -grasp.angle).direction(grasp.approach);
  EXPECT_NEAR(dot(paper, cross(handle.axis, place - mount)), 0, 1e-9);
  EXPECT_GT(dot(paper, place - mount), 0);
  EXPECT_LE(std::acos(std::min(1.0, dot(grasp.approach, handle.approach))), options.max_angle + 1e-6);

  EXPECT_EQ(grasp.pregrasp.R, grasp.grasp.R);
  EXPECT_NEAR(norm(grasp.grasp.t - grasp.pregrasp.t - options.pregrasp_distance * z), 0, 1e-9);
  EXPECT_EQ(grasp.lifted.R, grasp.grasp.R);
  EXPECT_NEAR(norm(grasp.lifted.t - grasp.grasp.t - options.lift * kZ), 0, 1e-9);
  EXPECT_EQ(grasp.width, 2 * handle.radius);
  EXPECT_GE(grasp.opening, grasp.width + 2 * options.finger_clearance - 1e-12);
}

TEST(PlannerPoses, LieOnTheHandle) {
  std::mt19937_64 generator(1);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(generator); };
  PlannerOptions options = all_grasps();
  options.lift = 0;  // of these places, few are high enough for one
  const GraspPlanner planner(baxter(), options);
  std::vector<Handle> handles;
  for (int i = 0; i < 20; ++i) {
    const Vector3 axis = normalized({uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)});
    const Vector3 center = {uniform(0.5, 0.8), uniform(-0.5, 0.1), uniform(-0.1, 0.3)};
    const Vector3 approach = normalized(cross(axis, cross(center, axis)));
    handles.push_back(handle_at(center, axis, approach, uniform(0.018, 0.027), uniform(0, 0.2)));
  }
  const Plan plan = planner.plan(handles, {});
  EXPECT_EQ(plan.grasps.size() + plan.rejected.size(), handles.size());
  EXPECT_GT(plan.grasps.size(), 10u);
  for (const Grasp& grasp : plan.grasps) {
    SCOPED_TRACE(grasp.handle);
    expect_on_handle(grasp, handles[grasp.handle], options, baxter().mount());
  }
}

TEST(PlannerPoses, TheCamerasFrameMakesNoDifference) {
  const Handle in_base = handle_at({0.7, -0.2, 0.1}, kZ, kX);
  const sensor::Pose T_base_camera = sensor::look_at({0.1, 0.1, 0.6}, {0.7, -0.2, 0}), back = T_base_camera.inverse();
  Handle seen = in_base;
  seen.center = back.point(in_base.center);
  seen.axis = 3.0 * back.direction(in_base.axis);  // any length
  seen.approach = 0.2 * back.direction(in_base.approach);
  const GraspPlanner planner(baxter());
  const Plan ours = planner.plan({in_base}, {}), theirs = planner.plan({seen}, T_base_camera);
  ASSERT_EQ(ours.grasps.size(), 1u);
  ASSERT_EQ(theirs.grasps.size(), 1u);
  EXPECT_LT(distance(ours.grasps[0].grasp, theirs.grasps[0].grasp), 1e-9);
  EXPECT_LT(angle(ours.grasps[0].grasp, theirs.grasps[0].grasp), 1e-9);
}

TEST(PlannerPoses, ApproachesSweepAboutTheAxisWithinTheLimit) {
  const HandlePlace place = {{0.5, 0.2, 0}, kZ, 0};
  const Vector3 seen = normalized({1, -0.5, 0});
  const std::vector<Approach> approaches = approaches_to(place, {0.1, 0, 0.4}, seen, kPi / 12, kPi / 3);
  // The paper's is along (0.4, 0.2, 0); beyond a third of pi from `seen` there are fewer on one side.
  EXPECT_LT(norm(approaches[0].direction - normalized({0.4, 0.2, 0})), 1e-12);
  EXPECT_EQ(approaches[0].angle, 0);
  EXPECT_LT(norm(approaches[1].direction - seen), 1e-12);
  std::size_t expected = 2;
  for (int k = -12; k <= 12; ++k) {
    const Vector3 direction = sensor::rotation(kZ, k * kPi / 12).direction(approaches[0].direction);
    if (k != 0 && k != -12 && std::acos(dot(direction, seen)) <= kPi / 3) ++expected;
  }
  EXPECT_EQ(approaches.size(), expected);
  for (const Approach& approach : approaches) {
    EXPECT_LE(std::acos(std::min(1.0, dot(approach.direction, seen))), kPi / 3 + 1e-9);
    const Vector3 turned = sensor::rotation(kZ, approach.angle).direction(approaches[0].direction);
    EXPECT_LT(norm(turned - approach.direction), 1e-9);
  }
  // Nearer to the paper's come first.
  for (std::size_t i = 3; i < approaches.size(); ++i) {
    EXPECT_GE(std::fabs(approaches[i].angle), std::fabs(approaches[i - 1].angle) - 1e-9);
  }
  EXPECT_EQ(approaches_to(place, {0.1, 0, 0.4}, seen, kPi / 12, 0).size(), 1u) << "`seen` alone";
  EXPECT_EQ(approaches_to(place, {0.1, 0, 0.4}, approaches[0].direction, kPi / 12, 0).size(), 1u) << "both the same";
  const Vector3 nearly = sensor::rotation(kZ, 5e-4).direction(approaches[0].direction);
  EXPECT_EQ(approaches_to(place, {0.1, 0, 0.4}, nearly, kPi / 12, 0).size(), 1u) << "as good as the same";
  EXPECT_EQ(approaches_to(place, {0.1, 0, 0.4}, approaches[0].direction, kPi / 12, kPi).size(), 24u) << "all around";
  // From right above, the paper gives none.
  EXPECT_LT(norm(approaches_to(place, {0.5, 0.2, 0.9}, seen, 0.3, 1)[0].direction - seen), 1e-12);
}

TEST(PlannerPoses, FlippedIsHalfATurnAboutTheApproach) {
  const HandlePlace place = {{0.5, 0.2, 0.1}, normalized({1, 2, 3}), 0};
  const Vector3 approach = normalized(cross(place.axis, kX));
  const Pose pose = hand_pose(place, approach, 0.01, false), flipped = hand_pose(place, approach, 0.01, true);
  EXPECT_LT(angle(pose * sensor::rotation(kZ, kPi), flipped), 1e-9);
  EXPECT_LT(distance(pose, flipped), 1e-12);
}

TEST(PlannerPoses, OnACurvedHandleTheAxisIsTheTangent) {
  // Half a ring of 0.1 m about the origin, in the xz plane, in pieces of 3 degrees; some points twice.
  Handle ring = handle_at({0, 0, 0.1}, kX, {0, 1, 0}, 0.01, 0.1 * kPi);
  for (int i = 0; i <= 60; ++i) {
    const double a = kPi * i / 60;
    for (int twice = 0; twice < (i % 7 == 0 ? 2 : 1); ++twice) {
      ring.path.push_back({-0.1 * std::cos(a), 0, 0.1 * std::sin(a)});
    }
  }
  const Handle ours = in_base(ring, sensor::translation(0.5, 0.2, 0.1), 0);
  const std::vector<HandlePlace> places = places_along(ours, {0, 0.5, -0.5, 1, -1});
  ASSERT_EQ(places.size(), 5u);
  const double shares[] = {0, 0.5, -0.5, 1, -1};
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double a = kPi / 2 * (1 + shares[i]);  // along the ring from its end at -x
    const Vector3 on_ring = {0.5 - 0.1 * std::cos(a), 0.2, 0.1 + 0.1 * std::sin(a)};
    const Vector3 tangent = {std::sin(a), 0, std::cos(a)};
    EXPECT_NEAR(norm(places[i].point - on_ring), 0, 1e-3) << shares[i];
    EXPECT_GT(dot(places[i].axis, tangent), std::cos(kPi / 60)) << shares[i];
    EXPECT_NEAR(norm(places[i].axis), 1, 1e-12);
  }
  // All in one place: no direction but the handle's.
  ring.path.assign(4, ring.center);
  const Handle point = in_base(ring, {}, 0);
  for (const HandlePlace& place : places_along(point, {0, 0.5})) EXPECT_LT(norm(place.axis - kX), 1e-12);
}

// ---- Which, how many, in which order --------------------------------------------------------------------------------

std::vector<std::size_t> handles_of(const Plan& plan) {
  std::vector<std::size_t> handles;
  for (const Grasp& grasp : plan.grasps) handles.push_back(grasp.handle);
  return handles;
}

std::vector<Handle> three_handles() {
  std::vector<Handle> handles = {handle_at({0.6, 0.1, 0.1}, kZ, kX), handle_at({0.5, 0, 0}, kZ, kX),
                                 handle_at({0.7, -0.1, 0.2}, kZ, kX)};
  handles[0].confidence = 0.9, handles[1].confidence = 0.5, handles[2].confidence = 0.7;
  return handles;
}

TEST(PlannerOrder, IsTheOneAskedFor) {
  using Indices = std::vector<std::size_t>;
  PlannerOptions options = all_grasps();
  for (const auto& [order, expected] :
       {std::pair(Order::kNearest, Indices{1, 0, 2}), std::pair(Order::kConfidence, Indices{0, 2, 1}),
        std::pair(Order::kHighest, Indices{2, 0, 1})}) {
    options.order = order;
    for (std::size_t most = 0; most <= 4; ++most) {
      options.max_grasps = most;
      const Plan plan = GraspPlanner(gantry_arm(), options).plan(three_handles(), {});
      const std::size_t count = most == 0 ? 3 : std::min<std::size_t>(most, 3);
      EXPECT_EQ(handles_of(plan), Indices(expected.begin(), expected.begin() + static_cast<std::ptrdiff_t>(count)));
      EXPECT_TRUE(plan.rejected.empty());
      EXPECT_TRUE(plan.candidates.empty());
    }
  }
  // Of the same key, the first comes first.
  options.order = Order::kConfidence;
  options.max_grasps = 0;
  std::vector<Handle> handles = three_handles();
  for (Handle& handle : handles) handle.confidence = 0.5;
  EXPECT_EQ(handles_of(GraspPlanner(gantry_arm(), options).plan(handles, {})), (Indices{0, 1, 2}));
}

TEST(PlannerOrder, NoMoreHandlesAreLookedAtThanNeeded) {
  std::vector<Handle> handles = three_handles();
  handles[1].radius = 1;  // the nearest one
  handles.push_back(handle_at({0.8, 0, 0}, kZ, kX, 1));
  const Plan plan = GraspPlanner(gantry_arm()).plan(handles, {});
  EXPECT_EQ(handles_of(plan), std::vector<std::size_t>{0});
  ASSERT_EQ(plan.rejected.size(), 1u) << "the last one was not looked at";
  EXPECT_EQ(plan.rejected[0].handle, 1u);
}

TEST(PlannerOrder, AllListsEveryCandidateAndTheSameGrasps) {
  const CanScene scene = can_scene();
  std::vector<Handle> handles = scene.handles;
  const sensor::Pose T_camera_base = scene.T_base_camera.inverse();
  const auto seen_at = [&](const Vector3& center, double radius) {
    return handle_at(T_camera_base.point(center), T_camera_base.direction(kZ), T_camera_base.direction(kX), radius);
  };
  handles.push_back(seen_at({0.75, -0.35, 0.1}, 0.02));  // in the air
  handles.push_back(seen_at({3, 0, 0}, 0.02));
  handles.push_back(seen_at({0.6, -0.3, 0.1}, 0.06));
  PlannerOptions options = all_grasps();
  const GraspPlanner few = planner_for(scene, baxter(), options);
  options.all = true;
  const GraspPlanner all = planner_for(scene, baxter(), options);
  const Plan plan = few.plan(handles, scene.T_base_camera), listed = all.plan(handles, scene.T_base_camera);
  ASSERT_EQ(plan.grasps.size(), 2u);
  ASSERT_EQ(listed.grasps.size(), plan.grasps.size());
  for (std::size_t i = 0; i < plan.grasps.size(); ++i) EXPECT_TRUE(same(plan.grasps[i], listed.grasps[i]));
  EXPECT_TRUE(plan.candidates.empty());

  // Five places of every handle, or three where they lie within 5 mm; directions in the half turn about the one seen.
  std::vector<std::size_t> count(handles.size(), 0), accepted(handles.size(), 0);
  std::vector<std::array<std::size_t, kReasons>> reasons(handles.size());
  for (const Candidate& candidate : listed.candidates) {
    ++count[candidate.handle];
    candidate.reason ? ++reasons[candidate.handle][static_cast<std::size_t>(*candidate.reason)]
                     : ++accepted[candidate.handle];
  }
  for (std::size_t i = 0; i < handles.size(); ++i) {
    std::size_t expected = 0;
    const Handle ours = in_base(handles[i], scene.T_base_camera, i);
    for (const HandlePlace& place : places_along(ours, options.places)) {
      expected += 2 * options.tilts.size() *
                  approaches_to(place, baxter().mount(), ours.approach, options.angle_step, options.max_angle).size();
    }
    EXPECT_EQ(count[i], expected);
    EXPECT_GE(count[i], 5u * 2 * 13 * 3) << "13 directions in half a turn, both flips, three tilts";
    EXPECT_EQ(accepted[i] > 0, i < 2);
  }
  ASSERT_EQ(listed.rejected.size(), 2u);
  for (const Rejection& rejection : listed.rejected) {
    EXPECT_EQ(rejection.counts, reasons[rejection.handle]);
    EXPECT_EQ(rejection.reason, rejection.handle == 2 ? Reason::kOutOfReach : Reason::kTooWide);
  }
  // The grasp is the first candidate that is one.
  const auto first = std::find_if(listed.candidates.begin(), listed.candidates.end(), [&](const Candidate& candidate) {
    return candidate.handle == listed.grasps[0].handle && !candidate.reason;
  });
  ASSERT_NE(first, listed.candidates.end());
  EXPECT_EQ(first->angle, listed.grasps[0].angle);
  EXPECT_EQ(first->flipped, listed.grasps[0].flipped);
}

TEST(PlannerOrder, OfNearHandlesTheLongerOneFirstIfAskedFor) {
  const Arm arm = gantry_arm();
  std::vector<Handle> handles(4, gantry_handle());
  const double distances[] = {0.3, 0.36, 0.38, 0.44}, lengths[] = {0.03, 0.1, 0.05, 0.2};
  for (std::size_t i = 0; i < handles.size(); ++i) {
    handles[i].center = {arm.mount()[0] + distances[i], arm.mount()[1], arm.mount()[2]};
    handles[i].length = lengths[i];
    handles[i].radius = 1;  // none is a grasp: the order is that of the rejected
  }
  const auto order = [&](double tolerance, Order by = Order::kNearest) {
    PlannerOptions options = one_approach();
    options.max_grasps = 0;
    options.nearest_tolerance = tolerance;
    options.order = by;
    std::vector<std::size_t> indices;
    for (const Rejection& one : GraspPlanner(arm, options).plan(handles, {}).rejected) indices.push_back(one.handle);
    return indices;
  };
  using Indices = std::vector<std::size_t>;
  EXPECT_EQ(order(0), (Indices{0, 1, 2, 3}));
  EXPECT_EQ(order(0.05), (Indices{0, 1, 2, 3}));
  EXPECT_EQ(order(0.07), (Indices{1, 0, 3, 2}));
  EXPECT_EQ(order(0.2), (Indices{3, 1, 2, 0}));
  EXPECT_EQ(order(0.2, Order::kConfidence), (Indices{0, 1, 2, 3}));
}

TEST(PlannerPose, ATiltLeansTowardsTheHandlesEnds) {
  PlannerOptions options = one_approach();
  options.tilts = {0.3, 0, -0.3};
  options.all = true;
  const Arm arm = gantry_arm();
  const Plan plan = GraspPlanner(arm, options).plan({gantry_handle()}, {});
  ASSERT_EQ(plan.candidates.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(plan.candidates[i].tilt, options.tilts[i / 2]);
  // The hand closes across the axis all the same, about the same point.
  const HandlePlace place = {gantry_handle().center, kZ, 0};
  for (const double tilt : options.tilts) {
    const Approach approach = tilted({kX, 0.5, 0}, kZ, tilt);
    EXPECT_EQ(approach.angle, 0.5);
    EXPECT_NEAR(dot(approach.direction, kZ), std::sin(tilt), 1e-12);
    EXPECT_NEAR(dot(approach.direction, kX), std::cos(tilt), 1e-12);
    const Pose T = hand_pose(place, approach.direction, 0.01, false);
    EXPECT_NEAR(T.R[7], 0, 1e-12) << "y is across the axis";
    EXPECT_NEAR(norm(T.t - place.point), 0.01, 1e-12);
    EXPECT_NEAR(dot(T.t - place.point, approach.direction), 0.01, 1e-12);
  }
  options.tilts = {};
  EXPECT_MENTIONS(message_of([&] { options.validate(); }), "tilts");
  options.tilts = {1.5};
  EXPECT_MENTIONS(message_of([&] { options.validate(); }), "tilts");
  options.tilts = {0};
  options.nearest_tolerance = -1;
  EXPECT_MENTIONS(message_of([&] { options.validate(); }), "nearest_tolerance");
}

TEST(PlannerOrder, TheFlipThatTurnsTheHandLessComesFirst) {
  PlannerOptions options = one_approach();
  options.all = true;
  std::mt19937_64 generator(3);
  const Arm arm = gantry_arm();
  for (int i = 0; i < 50; ++i) {
    options.start = random_positions(arm, generator);
    const Plan plan = GraspPlanner(arm, options).plan({gantry_handle()}, {});
    ASSERT_EQ(plan.candidates.size(), 2u);
    const HandlePlace place = {gantry_handle().center, kZ, 0};
    const Pose start = arm.forward(options.start);
    EXPECT_LT(angle(start, hand_pose(place, kX, 0, plan.candidates[0].flipped)),
              angle(start, hand_pose(place, kX, 0, plan.candidates[1].flipped)));
  }
}

// ---- The same plan, again and again ---------------------------------------------------------------------------------

TEST(PlannerSame, ForTheMirroredSceneAndTheOtherArm) {
  PlannerOptions options = all_grasps();
  options.places = {0};
  options.angle_step = kPi / 6;
  std::vector<Handle> right, left;
  for (const double x : {0.6, 0.8, 1.0, 1.3}) {
    for (const double y : {-0.5, -0.1}) {
      right.push_back(handle_at({x, y, 0.1}, kZ, kX));
      left.push_back(handle_at({x, -y, 0.1}, kZ, kX));
    }
  }
  const Plan ours = GraspPlanner(baxter(), options).plan(right, {});
  const Plan theirs = GraspPlanner(Arm::baxter(Side::kLeft), options).plan(left, {});
  // Inverse kinematics draws other seeds for a mirrored arm, but what is within reach does not hang on them.
  const auto reach_of = [](const Plan& plan) {
    std::map<std::size_t, std::size_t> out_of_reach;
    for (const Grasp& grasp : plan.grasps) out_of_reach[grasp.handle] = 0;
    for (const Rejection& r : plan.rejected) {
      out_of_reach[r.handle] = r.counts[static_cast<std::size_t>(Reason::kOutOfReach)];
    }
    return out_of_reach;
  };
  EXPECT_EQ(reach_of(ours), reach_of(theirs));
  ASSERT_EQ(handles_of(ours), handles_of(theirs));
  EXPECT_GE(ours.grasps.size(), 3u);
  EXPECT_GE(ours.rejected.size(), 2u);
  for (std::size_t i = 0; i < ours.grasps.size(); ++i) {
    EXPECT_NEAR(ours.grasps[i].grasp.t[1], -theirs.grasps[i].grasp.t[1], 0.02) << "depth and direction may differ";
  }
}

TEST(PlannerSame, ToTheLastBitFromManyThreads) {
  const CanScene scene = can_scene();
  PlannerOptions options = all_grasps();
  const GraspPlanner planner = planner_for(scene, baxter(), options);
  const Plan plan = planner.plan(scene.handles, scene.T_base_camera);
  ASSERT_EQ(plan.grasps.size(), 1u);
  std::vector<Plan> plans(6);
  std::vector<std::thread> threads;
  for (Plan& again : plans) {
    threads.emplace_back([&] { again = planner.plan(scene.handles, scene.T_base_camera); });
  }
  for (std::thread& thread : threads) thread.join();
  // Another planner, its cloud taken in by one thread.
  tbb::task_arena(1).execute(
      [&] { plans.push_back(planner_for(scene, baxter(), options).plan(scene.handles, scene.T_base_camera)); });
  for (const Plan& again : plans) {
    ASSERT_EQ(again.grasps.size(), 1u);
    EXPECT_TRUE(same(again.grasps[0], plan.grasps[0]));
  }
}

}  // namespace
}  // namespace handhold::plan
