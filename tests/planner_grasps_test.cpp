// Grasps that the planner gives can be carried out: against plain loops over all points and links.
#include "handhold/planner.h"

#include <gtest/gtest.h>

#include <set>

#include "planner_helpers.h"
#include "robot_check.h"

namespace handhold::plan {
namespace {

const Arm& baxter() {
  static const Arm arm = Arm::baxter(Side::kRight);
  return arm;
}

/// Least distance (m) of what moves from any point, beyond what is required: by a plain loop.
double room(const Arm& arm, const JointVector& q, double opening, bool hand, const std::vector<Vector3>& points,
            const PlannerOptions& options) {
  const std::vector<Pose> links = arm.link_poses(q, opening);
  double least = 0.1;  // more room is enough
  for (const Shape& shape : arm.shapes()) {
    const std::size_t joints = arm.link_joints()[shape.link];
    const bool of_hand = joints == arm.joints().size();
    if (joints == 0 || (of_hand && !hand)) continue;
    const Body body = placed(shape, links[shape.link]);
    const double required = of_hand ? options.hand_clearance : options.arm_clearance;
    const double reach = shape.radius + norm({shape.size[0], shape.size[1], shape.size[2] + shape.length}) + least +
                         required;  // farther points need no look
    for (const Vector3& p : points) {
      const Vector3 off = p - body.T_base_body.t;
      if (dot(off, off) < reach * reach) least = std::min(least, distance(body, p) - required);
    }
  }
  return least;
}
/// Least distance (m) of links that are held against each other. Cylinders are taken as the capsules within.
double self_distance(const Arm& arm, const RobotCheck& check, const JointVector& q, double opening) {
  const std::vector<Pose> links = arm.link_poses(q, opening);
  std::vector<Body> bodies;
  for (Shape shape : arm.shapes()) {
    if (shape.kind == Shape::Kind::kCapsule) {
      shape.radius = std::min(shape.radius, shape.length / 2);
      shape.length -= 2 * shape.radius;
    }
    bodies.push_back(placed(shape, links[shape.link]));
  }
  double least = 1;
  for (const auto& [a, b] : check.pairs()) least = std::min(least, distance(bodies[a], bodies[b]));
  return least;
}

TEST(PlannerPairs, OfLinksAreAllButThoseThatHangTogether) {
  const RobotCheck check(baxter(), {0.001, 0.01, 0.015});
  std::set<std::pair<std::size_t, std::size_t>> held;
  for (const auto& [a, b] : check.pairs()) held.insert({std::max(a, b), std::min(a, b)});
  std::set<std::string> left_out;
  for (std::size_t a = 0; a < baxter().shapes().size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const std::size_t link_a = baxter().shapes()[a].link, link_b = baxter().shapes()[b].link;
      const std::size_t of_a = baxter().link_joints()[link_a], of_b = baxter().link_joints()[link_b];
      if (std::max(of_a, of_b) <= 1 + std::min(of_a, of_b)) {
        EXPECT_EQ(held.count({a, b}), 0u);
      } else if (!held.count({a, b})) {
        left_out.insert(baxter().links()[link_a] + " " + baxter().links()[link_b]);
      }
    }
  }
  // Cylinders that roll about their own axis, so that one joint alone moves them against the other one.
  EXPECT_EQ(left_out,
            (std::set<std::string>{"right_upper_elbow right_upper_shoulder", "right_lower_elbow right_lower_shoulder",
                                   "right_upper_forearm right_upper_elbow", "right_lower_forearm right_lower_elbow",
                                   "right_wrist right_upper_forearm", "right_hand right_upper_forearm"}));
}

TEST(PlannerPairs, TheArmMayGoWhereItsJointsDo) {
  const GraspPlanner planner(baxter());
  for (const double shoulder : {-1.5, -1.0, 0.0, 0.4, 0.8}) {
    const auto hit = planner.hit({0, shoulder, 0, 0, 0, 0, 0}, 0.05);
    EXPECT_FALSE(hit) << shoulder << " rad: " << hit->what;
  }
  // Folded onto itself it may not.
  EXPECT_TRUE(planner.hit({0, -1, 0, 2.6, 0, 2, 0}, 0.05));
}

std::vector<JointVector> five_times_finer(const std::vector<JointVector>& path) {
  std::vector<JointVector> fine = {path.front()};
  for (std::size_t i = 1; i < path.size(); ++i) {
    for (int k = 1; k <= 5; ++k) {
      JointVector q = path[i];
      for (std::size_t j = 0; j < q.size(); ++j) q[j] = path[i - 1][j] + k / 5.0 * (path[i][j] - path[i - 1][j]);
      fine.push_back(q);
    }
  }
  return fine;
}

void expect_clear(const Arm& arm, const std::vector<JointVector>& path, double opening, bool hand,
                  const std::vector<Vector3>& points, const PlannerOptions& options) {
  const RobotCheck check(arm, {options.hand_clearance, options.self_clearance, options.arm_clearance});
  constexpr double kSingle = 1e-5;    // m; of single precision
  constexpr double kBetween = 0.001;  // m; of clearance that is given up between samples
  for (const JointVector& q : path) {
    EXPECT_GE(room(arm, q, opening, hand, points, options), -kSingle);
    EXPECT_GE(self_distance(arm, check, q, opening), options.self_clearance - 1e-9);
  }
  for (const JointVector& q : five_times_finer(path)) {
    EXPECT_GE(room(arm, q, opening, hand, points, options), -kBetween - kSingle);
    EXPECT_GT(self_distance(arm, check, q, opening), 0);
  }
}

void expect_executable(const Arm& arm, const Grasp& grasp, const PlannerOptions& options, const JointVector& start,
                       const std::vector<Vector3>& points) {
  ASSERT_LT(grasp.pregrasp_index, grasp.path.size() - 1);
  EXPECT_EQ(grasp.path.front(), start);
  EXPECT_EQ(grasp.lift_path.front(), grasp.path.back());
  const auto expect_at = [&](const JointVector& q, const Pose& pose) {
    EXPECT_LT(distance(arm.forward(q), pose), 1e-4);
    EXPECT_LT(angle(arm.forward(q), pose), 1e-4 + 1e-9);
  };
  expect_at(grasp.path[grasp.pregrasp_index], grasp.pregrasp);
  expect_at(grasp.path.back(), grasp.grasp);
  expect_at(grasp.lift_path.back(), grasp.lifted);
  for (const auto* path : {&grasp.path, &grasp.lift_path}) {
    const auto& times = path == &grasp.path ? grasp.times : grasp.lift_times;
    ASSERT_EQ(times.size(), path->size());
    EXPECT_EQ(times[0], 0);
    for (std::size_t i = 0; i < path->size(); ++i) {
      EXPECT_TRUE(arm.within_limits((*path)[i]));
      for (std::size_t j = 0; i > 0 && j < start.size(); ++j) {
        const double way = std::fabs((*path)[i][j] - (*path)[i - 1][j]), time = times[i] - times[i - 1];
        EXPECT_LE(way, options.step * (1 + 1e-9));
        const bool is_slow = path == &grasp.lift_path || i > grasp.pregrasp_index;
        EXPECT_LE(way, (is_slow ? options.approach_speed : options.speed) * arm.joints()[j].velocity * time + 1e-12);
      }
    }
  }
  // The way to the pre-grasp is straight in joint space, and so short that the hand nearly is, from there on.
  EXPECT_EQ(GraspPlanner(arm, options).straight(start, grasp.path[grasp.pregrasp_index]),
            std::vector<JointVector>(grasp.path.begin(),
                                     grasp.path.begin() + static_cast<std::ptrdiff_t>(grasp.pregrasp_index) + 1));
  double along = -1;
  for (std::size_t i = grasp.pregrasp_index; i < grasp.path.size(); ++i) {
    const Pose pose = arm.forward(grasp.path[i]);
    const Vector3 off = pose.t - grasp.pregrasp.t;
    EXPECT_GT(dot(off, grasp.approach), along);
    along = dot(off, grasp.approach);
    EXPECT_LT(norm(off - along * grasp.approach), 0.003);
    EXPECT_LT(angle(pose, grasp.grasp), 0.03);
  }
  expect_clear(arm, grasp.path, grasp.opening, true, points, options);
  expect_clear(arm, grasp.lift_path, grasp.width, false, points, options);
}

TEST(PlannerGrasps, CanBeCarriedOut) {
  for (const Side side : {Side::kRight, Side::kLeft}) {
    const CanScene scene = can_scene(side == Side::kRight ? -1 : 1);
    const Arm arm = Arm::baxter(side);
    const PlannerOptions options;
    const GraspPlanner planner = planner_for(scene, arm, options);
    const Plan plan = planner.plan(scene.handles, scene.T_base_camera);
    ASSERT_EQ(plan.grasps.size(), 1u);
    EXPECT_TRUE(plan.rejected.empty());
    const std::vector<Vector3> points = points_in_base(scene);
    ASSERT_GT(points.size(), 8000u);
    expect_executable(arm, plan.grasps[0], options, arm.rest(), points);

    // The can is between the fingers: points on both sides of the hand's middle, all between the fingers' faces.
    const Pose T_grasp_base = plan.grasps[0].grasp.inverse();
    std::size_t between = 0;
    for (const Vector3& p : points) {
      const Vector3 q = T_grasp_base.point(p);
      if (std::fabs(q[0]) > 0.005 || q[2] > 0 || q[2] < -0.03) continue;
      EXPECT_LT(std::fabs(q[1]), plan.grasps[0].opening / 2);
      between += std::fabs(q[1]) <= kCanRadius + 1e-6;
    }
    EXPECT_GE(between, 8u);
  }
}

TEST(PlannerGrasps, CanBeCarriedOutFromAnotherStart) {
  const CanScene scene = can_scene();
  PlannerOptions options;
  options.start = {0.3, -0.8, 0.2, 1.2, 0.1, 0.9, 0.4};
  options.step = 0.03;
  options.pregrasp_distance = 0.08;
  options.lift = 0.1;
  const GraspPlanner planner = planner_for(scene, baxter(), options);
  const Plan plan = planner.plan(scene.handles, scene.T_base_camera);
  ASSERT_EQ(plan.grasps.size(), 1u);
  expect_executable(baxter(), plan.grasps[0], options, options.start, points_in_base(scene));
}

TEST(PlannerGrasps, OfAGantryAreThoseOfPencilAndPaper) {
  PlannerOptions options = one_approach();
  options.start = {-0.1, 0.2, 0, 0, 0, 0};
  const GraspPlanner planner(gantry_arm(), options);
  const Plan plan = planner.plan({gantry_handle()}, {});
  ASSERT_EQ(plan.grasps.size(), 1u);
  const Grasp& grasp = plan.grasps[0];
  const JointVector at_grasp = {0.5 - kWristToTip, 0, 0, 0, 0, 0};
  JointVector before = at_grasp, after = at_grasp;
  before[0] -= options.pregrasp_distance;
  after[2] += options.lift;
  const auto expect_near = [](const JointVector& q, const JointVector& expected) {
    for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(q[j], expected[j], 1e-4);
  };
  EXPECT_EQ(grasp.path.front(), options.start);
  expect_near(grasp.path[grasp.pregrasp_index], before);
  expect_near(grasp.path.back(), at_grasp);
  expect_near(grasp.lift_path.back(), after);
  EXPECT_LT(angle(gantry_arm().forward(grasp.path.back()), grasp.grasp), 1e-4);
  EXPECT_EQ(grasp.opening, 0.1) << "there is room";
}

TEST(PlannerGrasps, OpenAsWideAsThereIsRoom) {
  GraspPlanner planner(gantry_arm(), one_approach());
  for (const double wall : {0.064, 0.052}) {
    // Walls on both sides, `wall` from the axis; fingers are 10 mm thick.
    planner.obstacles().clear_bodies();
    for (const int side : {1, -1}) {
      planner.obstacles().add("wall", box_body({0.5, side * (wall + 0.02), 0}, {0.03, 0.04, 0.2}));
    }
    const Plan plan = planner.plan({gantry_handle()}, {});
    ASSERT_EQ(plan.grasps.size(), 1u) << wall;
    EXPECT_EQ(plan.grasps[0].opening, wall > 0.06 ? 0.1 : (0.1 + 0.048) / 2);
  }
}

}  // namespace
}  // namespace handhold::plan
