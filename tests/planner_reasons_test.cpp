// Why a candidate is no grasp: every reason from a cause made for it, and gone with it. And what a planner refuses.
#include <gtest/gtest.h>

#include "planner_helpers.h"

namespace handhold::plan {
namespace {

std::string name_of(Reason reason) {
  return std::string(to_string(reason));
}

/// The handle's rejection; none: it has a grasp.
std::optional<Rejection> rejection_of(const GraspPlanner& planner, const Handle& handle) {
  const Plan plan = planner.plan({handle}, {});
  EXPECT_EQ(plan.grasps.size() + plan.rejected.size(), 1u);
  if (plan.rejected.empty()) return std::nullopt;
  return plan.rejected[0];
}
void expect_grasp(const GraspPlanner& planner, const Handle& handle) {
  const auto rejection = rejection_of(planner, handle);
  EXPECT_FALSE(rejection) << name_of(rejection->reason) << " " << rejection->what;
}
/// All `candidates`, which are two flips unless said otherwise, for the same reason.
void expect_rejected(const GraspPlanner& planner, const Handle& handle, Reason reason, const std::string& what,
                     std::size_t candidates = 2) {
  const auto rejection = rejection_of(planner, handle);
  ASSERT_TRUE(rejection) << "not " << name_of(reason);
  EXPECT_EQ(name_of(rejection->reason), name_of(reason));
  EXPECT_EQ(rejection->what, what);
  for (std::size_t i = 0; i < kReasons; ++i) {
    EXPECT_EQ(rejection->counts[i], i == static_cast<std::size_t>(reason) ? candidates : 0)
        << name_of(static_cast<Reason>(i));
  }
}
/// With a known body it is rejected, without it it is not.
void expect_body_rejects(const Body& body, Reason reason, const PlannerOptions& options = one_approach(),
                         const Handle& handle = gantry_handle()) {
  GraspPlanner planner(gantry_arm(), options);
  expect_grasp(planner, handle);
  planner.obstacles().add("thing", body);
  expect_rejected(planner, handle, reason, "thing");
  planner.obstacles().clear_bodies();
  expect_grasp(planner, handle);
}
/// The same with its surface as a cloud. @param step  m; between points
void expect_cloud_rejects(const Body& body, Reason reason) {
  GraspPlanner planner(gantry_arm(), one_approach());
  std::vector<float> xyz;
  constexpr int kSteps = 12;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      for (int k = 0; k <= kSteps; ++k) {
        const int at[] = {i, j, k};
        for (int c = 0; c < 3; ++c) {
          xyz.push_back(static_cast<float>(body.T_base_body.t[c] + body.size[c] * (at[c] / double{kSteps} - 0.5)));
        }
      }
    }
  }
  const CloudView cloud = {xyz.data(), 12, static_cast<std::uint32_t>(xyz.size() / 3), 1, std::nullopt};
  planner.obstacles().set_cloud(cloud, {});
  expect_rejected(planner, gantry_handle(), reason, "cloud");
  planner.obstacles().set_cloud({}, {});
  expect_grasp(planner, gantry_handle());
}

// ---- One cause, one reason ------------------------------------------------------------------------------------------

TEST(Reasons, TooWide) {
  PlannerOptions options = one_approach();
  const GraspPlanner planner(gantry_arm(), options);  // opens 0.1 m
  Handle handle = gantry_handle();
  handle.radius = 0.0459;
  expect_grasp(planner, handle);
  handle.radius = 0.0461;
  expect_rejected(planner, handle, Reason::kTooWide, "");
  options.finger_clearance = 0.003;
  expect_grasp(GraspPlanner(gantry_arm(), options), handle);
}

TEST(Reasons, TooThin) {
  const Arm baxter = Arm::baxter(Side::kRight);
  const GraspPlanner planner(baxter);
  Handle handle = handle_at({0.7, -0.3, 0.1}, kZ, kX);
  handle.radius = baxter.hand().opening_min / 2 + 0.001;
  expect_grasp(planner, handle);
  handle.radius = baxter.hand().opening_min / 2 - 0.001;
  EXPECT_EQ(rejection_of(planner, handle)->reason, Reason::kTooThin);
  // With the fingers screwed on farther inwards they meet it.
  ElectricGripper gripper;
  gripper.slot = 2;
  expect_grasp(GraspPlanner(Arm::baxter(Side::kRight, gripper)), handle);
}

TEST(Reasons, OutOfReach) {
  const GraspPlanner planner(gantry_arm(), one_approach());
  Handle handle = gantry_handle();
  handle.center[0] = 10;
  expect_rejected(planner, handle, Reason::kOutOfReach, "");
  handle.center[0] = 2;
  expect_grasp(planner, handle);
}

TEST(Reasons, JointLimits) {
  Handle handle = gantry_handle();
  handle.center[0] = 1.5;  // the slides together would reach, but not the one along x
  Gantry gantry;
  gantry.x_limit = 1;
  expect_rejected(GraspPlanner(gantry_arm(gantry), one_approach()), handle, Reason::kJointLimits, "");
  gantry.x_limit = 1.5;
  expect_grasp(GraspPlanner(gantry_arm(gantry), one_approach()), handle);
}

TEST(Reasons, JointLimitsOnTheWayThere) {
  // The grasp is within the limits, the pre-grasp behind it is not.
  PlannerOptions options = one_approach();
  options.pregrasp_distance = 2.5;
  expect_rejected(GraspPlanner(gantry_arm(), options), gantry_handle(), Reason::kJointLimits, "");
  options.pregrasp_distance = 2.3;
  expect_grasp(GraspPlanner(gantry_arm(), options), gantry_handle());
}

TEST(Reasons, HandHits) {
  const Body thing = box_body({0.5, 0, 0}, {0.04, 0.12, 0.04});  // where the fingers go
  expect_body_rejects(thing, Reason::kHandHits);
  expect_cloud_rejects(thing, Reason::kHandHits);
  // On the way, not at the grasp: behind the palm, which it meets 8 cm before.
  expect_body_rejects(box_body({0.36, 0.06, 0}, {0.02, 0.02, 0.02}), Reason::kHandHits);
}

TEST(Reasons, ArmHitsItself) {
  // The weight on the z slide, 0.2 m behind the wrist and above it, against a pillar of the frame.
  Gantry gantry;
  gantry.fixed = collision_box({0.2, 0, 0.2}, {0.06, 0.06, 0.06});
  expect_rejected(GraspPlanner(gantry_arm(gantry), one_approach()), gantry_handle(), Reason::kArmHitsItself, "base");
  gantry.fixed = collision_box({0.2, 0, 0.4}, {0.06, 0.06, 0.06});
  PlannerOptions options = one_approach();
  options.lift = 0.1;
  expect_grasp(GraspPlanner(gantry_arm(gantry), options), gantry_handle());
  // 2 cm are left between them.
  gantry.fixed = collision_box({0.2, 0, 0.3}, {0.06, 0.06, 0.06});
  options.lift = 0;
  for (const double clearance : {0.019, 0.021}) {
    options.self_clearance = clearance;
    const GraspPlanner planner(gantry_arm(gantry), options);
    if (clearance < 0.02) {
      expect_grasp(planner, gantry_handle());
    } else {
      expect_rejected(planner, gantry_handle(), Reason::kArmHitsItself, "base");
    }
  }
}

TEST(Reasons, ArmHits) {
  const Body thing = box_body({0.2, 0, 0.2}, {0.06, 0.06, 0.06});
  expect_body_rejects(thing, Reason::kArmHits);
  expect_cloud_rejects(thing, Reason::kArmHits);
  // The weight's face is at z = 0.15 m; 2 cm are left.
  PlannerOptions options = one_approach();
  options.arm_clearance = 0.021;
  const Body below = box_body({0.2, 0, 0.1}, {0.06, 0.06, 0.06});
  expect_body_rejects(below, Reason::kArmHits, options);
  options.arm_clearance = 0.019;
  GraspPlanner planner(gantry_arm(), options);
  planner.obstacles().add("thing", below);
  expect_grasp(planner, gantry_handle());
}

TEST(Reasons, AClearanceOfNothingStillTouches) {
  PlannerOptions options = one_approach();
  options.arm_clearance = options.hand_clearance = options.self_clearance = 0;
  expect_body_rejects(box_body({0.2, 0, 0.2}, {0.06, 0.06, 0.06}), Reason::kArmHits, options);
  expect_body_rejects(box_body({0.5, 0, 0}, {0.04, 0.12, 0.04}), Reason::kHandHits, options);
  const GraspPlanner planner(gantry_arm(), options);
  EXPECT_FALSE(planner.hit(gantry_arm().rest(), 0.1));
}

TEST(Reasons, PathHits) {
  const Body wall = box_body({0.2, 0, 0}, {0.01, 0.2, 0.1});  // between the hand's start and the pre-grasp
  expect_body_rejects(wall, Reason::kPathHits);
  expect_cloud_rejects(wall, Reason::kPathHits);
  // Thinner than a step is long.
  PlannerOptions options = one_approach();
  options.step = 0.5;
  options.approach_pieces = 1;
  expect_body_rejects(box_body({0.2, 0, 0}, {0.0005, 0.2, 0.1}), Reason::kPathHits, options);
}

TEST(Reasons, PathClearanceHoldsOnTheWayToThePregraspOnly) {
  // 30 mm beside the hand's back where it starts, which reaches to y = 0.07 m: no turn on the way avoids it.
  const Body beside = box_body({0.04, 0.15, 0}, {0.02, 0.1, 0.02});
  PlannerOptions options = one_approach();
  options.path_clearance = 0.027;
  GraspPlanner planner(gantry_arm(), options);
  planner.obstacles().add("thing", beside);
  expect_grasp(planner, gantry_handle());
  options.path_clearance = 0.033;
  expect_body_rejects(beside, Reason::kPathHits, options);
  // The same beside the grasp: there only the hand's clearance counts.
  GraspPlanner at_the_part(gantry_arm(), options);
  at_the_part.obstacles().add("thing", box_body({0.44, 0.15, 0}, {0.02, 0.1, 0.02}));
  expect_grasp(at_the_part, gantry_handle());
}

TEST(Reasons, LiftHits) {
  const Body ceiling = box_body({0.2, 0, 0.4}, {0.2, 0.2, 0.05});  // above the weight
  expect_body_rejects(ceiling, Reason::kLiftHits);
  expect_cloud_rejects(ceiling, Reason::kLiftHits);
  PlannerOptions options = one_approach();
  options.lift = 0.1;  // the weight ends at 0.35 m, 25 mm below
  GraspPlanner planner(gantry_arm(), options);
  planner.obstacles().add("thing", ceiling);
  expect_grasp(planner, gantry_handle());
  // No way up at all: the slide along z ends at 1 m.
  Handle high = gantry_handle();
  high.center[2] = 0.9;
  expect_rejected(GraspPlanner(gantry_arm(), one_approach()), high, Reason::kLiftHits, "");
}

TEST(Reasons, TheHandMayTouchWhatItLifts) {
  GraspPlanner planner(gantry_arm(), one_approach());
  // Just beyond the fingers' tips, and above them: in the way of the hand, but only of the hand.
  planner.obstacles().add("thing", box_body({0.5, 0, 0.06}, {0.04, 0.2, 0.04}));
  expect_grasp(planner, gantry_handle());
}

TEST(Reasons, OfManyCandidatesTheOneThatCameFurthest) {
  // From the direction seen the arm hits; from everywhere else the hand does.
  PlannerOptions options = one_approach();
  options.max_angle = 1.3;
  options.angle_step = 1.2;
  GraspPlanner planner(gantry_arm(), options);
  planner.obstacles().add("pillar", box_body({0.2, 0, 0.2}, {0.06, 0.06, 0.06}));
  const double c = 0.5 - 0.12 * std::cos(1.2), s = 0.12 * std::sin(1.2);
  for (const int side : {1, -1}) {
    planner.obstacles().add("post", box_body({c, side * s, 0}, {0.02, 0.02, 0.02}));
  }
  const auto rejection = rejection_of(planner, gantry_handle());
  ASSERT_TRUE(rejection);
  EXPECT_EQ(rejection->reason, Reason::kArmHits);
  EXPECT_EQ(rejection->what, "pillar");
  EXPECT_EQ(rejection->counts[static_cast<std::size_t>(Reason::kArmHits)], 2u);
  EXPECT_EQ(rejection->counts[static_cast<std::size_t>(Reason::kHandHits)], 4u);
}

TEST(Reasons, WhereThePapersApproachFailsAnotherOneIsTaken) {
  PlannerOptions options = one_approach();
  options.max_angle = 1.6;
  GraspPlanner planner(gantry_arm(), options);
  planner.obstacles().add("post", box_body({0.41, 0, 0}, {0.02, 0.02, 0.02}));
  const Plan plan = planner.plan({gantry_handle()}, {});
  ASSERT_EQ(plan.grasps.size(), 1u);
  EXPECT_GT(std::fabs(plan.grasps[0].angle), 0.2);
}

TEST(Reasons, Names) {
  const char* names[] = {"too wide",        "too thin", "out of reach", "hand hits", "joint limits",
                         "arm hits itself", "arm hits", "path hits",    "lift hits"};
  ASSERT_EQ(std::size(names), kReasons);
  for (std::size_t i = 0; i < kReasons; ++i) EXPECT_EQ(to_string(static_cast<Reason>(i)), names[i]);
}

// ---- hit() ----------------------------------------------------------------------------------------------------------

TEST(Hit, OfAPostureSaysWhat) {
  GraspPlanner planner(gantry_arm());
  const JointVector q = {0.4, 0, 0, 0, 0, 0};
  EXPECT_FALSE(planner.hit(q, 0.1));
  planner.obstacles().add("post", box_body({0.5, 0.05, 0}, {0.01, 0.01, 0.01}));  // at the left finger, when open
  const auto hit = planner.hit(q, 0.1);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->reason, Reason::kArmHits);
  EXPECT_EQ(hit->what, "post");
  EXPECT_FALSE(planner.hit(q, 0.04)) << "the finger is farther in";
  EXPECT_FALSE(planner.hit(q, 0.1, false)) << "the hand is not looked at";
  EXPECT_MENTIONS(message_of([&] { planner.hit(JointVector{0, 0}, 0.1); }), "joints");
}

TEST(Hit, OfAPathIsFoundBetweenItsSamples) {
  GraspPlanner planner(gantry_arm());
  planner.obstacles().add("sheet", box_body({0.5, 0, 0.2}, {0.0005, 0.3, 0.3}));
  const std::vector<JointVector> path = {{0, 0, 0, 0, 0, 0}, {1, 0, 0, 0, 0, 0}};
  for (const JointVector& q : path) EXPECT_FALSE(planner.hit(q, 0.1));
  const auto hit = planner.hit(path, 0.1);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->what, "sheet");
  EXPECT_TRUE(planner.hit(path, 0.1, false)) << "the weight goes through it, too";
  EXPECT_FALSE(planner.hit(std::vector<JointVector>{}, 0.1));
}

// ---- What is refused ------------------------------------------------------------------------------------------------

TEST(PlannerInput, NothingToDoIsNoError) {
  GraspPlanner planner(gantry_arm());
  const Plan nothing = planner.plan({}, {});
  EXPECT_TRUE(nothing.grasps.empty() && nothing.rejected.empty() && nothing.candidates.empty());
  planner.obstacles().set_cloud({}, {});
  EXPECT_EQ(planner.obstacles().points(), 0u);
  expect_grasp(planner, gantry_handle());
}

template <class Change>
std::string message_with(Change change) {
  PlannerOptions options;
  change(options);
  return message_of([&] { GraspPlanner(gantry_arm(), options); });
}

TEST(PlannerInput, OptionsOutOfRangeAreNamed) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -1.0}) {
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.pregrasp_distance = bad; }), "pregrasp_distance");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.lift = bad; }), "lift");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.angle_step = bad; }), "angle_step");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.max_angle = bad; }), "max_angle");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.finger_clearance = bad; }), "finger_clearance");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.hand_clearance = bad; }), "hand_clearance");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.self_clearance = bad; }), "self_clearance");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.arm_clearance = bad; }), "arm_clearance");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.path_clearance = bad; }), "path_clearance");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.step = bad; }), "step");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.speed = bad; }), "speed");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.approach_speed = bad; }), "approach_speed");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.acceleration_time = bad; }), "acceleration_time");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.depths = {0, bad - 1}; }), "depths");
    EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.places = {0, bad - 1}; }), "places");
  }
  EXPECT_MENTIONS(message_with([](PlannerOptions& o) { o.depths.clear(); }), "depths");
  EXPECT_MENTIONS(message_with([](PlannerOptions& o) { o.places.clear(); }), "places");
  EXPECT_MENTIONS(message_with([](PlannerOptions& o) { o.solutions = 0; }), "solutions");
  EXPECT_MENTIONS(message_with([](PlannerOptions& o) { o.approach_pieces = 0; }), "approach_pieces");
  EXPECT_MENTIONS(message_with([](PlannerOptions& o) { o.inverse.restarts = -1; }), "inverse.restarts");
  EXPECT_MENTIONS(message_with([](PlannerOptions& o) { o.inverse.fallback_restarts = -1; }), "fallback_restarts");
  EXPECT_MENTIONS(message_with([](PlannerOptions& o) { o.inverse.candidates = 0; }), "inverse.candidates");
  EXPECT_MENTIONS(message_with([&](PlannerOptions& o) { o.inverse.min_distance = nan; }), "inverse.min_distance");
  EXPECT_MENTIONS(message_with([](PlannerOptions& o) { o.start = {0, 0}; }), "start");
  EXPECT_MENTIONS(message_with([](PlannerOptions& o) { o.start = {0, 5, 0, 0, 0, 0}; }), "start");
}

TEST(PlannerInput, ArmsThatCannotGraspAreNamed) {
  const Arm no_hand = Arm::from_urdf(gantry_urdf({}), "base", "hand");
  EXPECT_MENTIONS(message_of([&] { GraspPlanner{no_hand}; }), "opening_max");
  Gantry still;
  still.velocity = 0;
  EXPECT_MENTIONS(message_of([&] { GraspPlanner{gantry_arm(still)}; }), "'x'");
}

TEST(PlannerInput, BadPosesAndHandlesAreNamed) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const GraspPlanner planner(gantry_arm());
  const auto with_pose = [&](const Pose& pose) { return message_of([&] { planner.plan({gantry_handle()}, pose); }); };
  Pose pose;
  pose.t[1] = nan;
  EXPECT_MENTIONS(with_pose(pose), "T_base_camera");
  pose = {};
  pose.R[0] = -1;  // a mirror
  EXPECT_MENTIONS(with_pose(pose), "T_base_camera");
  pose = {};
  pose.R[1] = 0.1;
  EXPECT_MENTIONS(with_pose(pose), "T_base_camera");

  const auto with_handle = [&](auto change) {
    Handle handle = gantry_handle();
    change(handle);
    const std::string message = message_of([&] { planner.plan({gantry_handle(), handle}, {}); });
    EXPECT_MENTIONS(message, "handle 1");
    return message;
  };
  for (const double bad : {nan, inf, 1e300}) {
    EXPECT_MENTIONS(with_handle([&](Handle& h) { h.center[0] = bad; }), "center");
    EXPECT_MENTIONS(with_handle([&](Handle& h) { h.path = {h.center, {0, bad, 0}}; }), "path");
  }
  for (const double bad : {nan, inf, -0.01}) {
    EXPECT_MENTIONS(with_handle([&](Handle& h) { h.radius = bad; }), "radius");
    EXPECT_MENTIONS(with_handle([&](Handle& h) { h.length = bad; }), "length");
  }
  for (const Vector3& bad : {Vector3{0, 0, 0}, Vector3{nan, 0, 1}, Vector3{inf, 0, 0}}) {
    EXPECT_MENTIONS(with_handle([&](Handle& h) { h.axis = bad; }), "axis");
    EXPECT_MENTIONS(with_handle([&](Handle& h) { h.approach = bad; }), "approach");
  }
  EXPECT_MENTIONS(with_handle([&](Handle& h) { h.confidence = nan; }), "confidence");
}

}  // namespace
}  // namespace handhold::plan
