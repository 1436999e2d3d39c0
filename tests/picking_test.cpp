// The robot that grasps in physics: which gripper it takes, what it knows of a held object, and whole attempts.
#include "picking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "handhold/random_scene.h"

namespace handhold::experiments {
namespace {

using Tip = plan::ElectricGripper::Tip;

plan::ElectricGripper in_slot(int slot) {
  plan::ElectricGripper gripper;
  gripper.slot = slot;
  return gripper;
}

TEST(Gripper, HoldsWhatItsStrokeAllows) {
  // Slot 2 with hard tips opens from 16 to 57.7 mm.
  EXPECT_FALSE(can_hold(in_slot(2), 0.015, 0.004));
  EXPECT_TRUE(can_hold(in_slot(2), 0.020, 0.004));
  EXPECT_TRUE(can_hold(in_slot(2), 0.049, 0.004));
  EXPECT_FALSE(can_hold(in_slot(2), 0.051, 0.004));
  EXPECT_TRUE(can_hold(in_slot(2), 0.051, 0.003));
  EXPECT_FALSE(can_hold(in_slot(1), 0, 0.004));
}

TEST(Gripper, IsChosenForTheObjects) {
  for (const physics::ObjectFacts& facts : physics::paper_objects()) {
    SCOPED_TRACE(facts.family);
    const plan::ElectricGripper gripper = gripper_for({facts.family});
    const sensor::Object object = sensor::make_object(facts.family);
    EXPECT_TRUE(std::any_of(object.parts.begin(), object.parts.end(), [&](const sensor::Part& part) {
      return part.confidence >= 0.5 && can_hold(gripper, 2 * part.radius, 0.003);
    }));
    EXPECT_EQ(gripper.tip, Tip::kHard);
  }
  // A handle of 15 mm is thinner than slot 2 closes.
  EXPECT_EQ(gripper_for({"pot"}).slot, 1);
  EXPECT_EQ(gripper_for({"plunger"}).slot, 2);
  // One slot holds 15 and 32 mm; no gripper holds 15 and 58.
  EXPECT_EQ(gripper_for({"pot", "purex_bottle"}).slot, 1);
  EXPECT_EQ(gripper_for({"pot", "purex_bottle"}).tip, Tip::kHard);
}

/// Points every 5 mm on a box.
void add_box(std::vector<float>& xyz, const Vector3& low, const Vector3& high) {
  for (double x = low[0]; x <= high[0] + 1e-9; x += 0.005) {
    for (double y = low[1]; y <= high[1] + 1e-9; y += 0.005) {
      for (double z = low[2]; z <= high[2] + 1e-9; z += 0.005) {
        for (const double v : {x, y, z}) xyz.push_back(static_cast<float>(v));
      }
    }
  }
}

/// A shaft on a block, and another thing beside or behind it, on a table; seen from the origin, along x.
Cloud shaft_on_block(const Vector3& other_low, const Vector3& other_high) {
  Cloud cloud;
  add_box(cloud.xyz, {0.6, -0.01, 0}, {0.62, 0.01, 0.2});
  add_box(cloud.xyz, {0.56, -0.05, 0.02}, {0.66, 0.05, 0.06});
  add_box(cloud.xyz, other_low, other_high);
  add_box(cloud.xyz, {0.4, -0.2, 0}, {0.9, 0.3, 0});
  cloud.xyz.insert(cloud.xyz.end(), 3, std::nanf(""));
  cloud.width = static_cast<std::uint32_t>(cloud.xyz.size() / 3);
  return cloud;
}

class HeldObjectTest : public ::testing::Test {
 protected:
  void SetUp() override {
    handle_.center = {0.61, 0, 0.15};
    handle_.axis = {0, 0, 1};
    handle_.radius = 0.012;
    handle_.length = 0.08;
    tip_.t = {0.61, 0, 0.15};
  }
  static plan::Body ball_at(const Vector3& p) {
    plan::Body ball;
    ball.kind = plan::Shape::Kind::kSphere;
    ball.radius = 0.01;
    ball.T_base_body.t = p;
    return ball;
  }
  /// Whether it comes to within `margin` of a ball of 10 mm at p. Body of the arm or obstacle is the same.
  static bool is_near(const HeldObject& object, const plan::Pose& hand, const Vector3& p, double margin,
                      bool guesses = true) {
    plan::Obstacles none, one;
    one.add("ball", ball_at(p));
    const bool near = object.room(hand, one, {}, {margin, 1, guesses}) < 0;
    EXPECT_EQ(object.room(hand, none, {ball_at(p)}, {1, margin, guesses}) < 0, near);
    return near;
  }
  /// Whether it is nearer than 15 mm to what is left of the cloud, above the table.
  static bool is_near_rest(const HeldObject& object, const plan::Pose& hand) {
    Cloud rest = object.rest();
    for (std::size_t i = 0; i < rest.size(); ++i) {
      if (rest.xyz[3 * i + 2] < 0.011f) rest.xyz[3 * i] = std::nanf("");
    }
    plan::Obstacles obstacles;
    obstacles.set_cloud(rest.view(), {});
    return object.room(hand, obstacles, {}, {0.015, 0, true}) < 0;
  }

  Handle handle_;
  plan::Pose tip_;
};

TEST_F(HeldObjectTest, IsWhatHangsTogetherWithTheHandle) {
  const Cloud cloud = shaft_on_block({0.56, 0.09, 0}, {0.66, 0.19, 0.3});
  const HeldObject object(cloud.view(), {}, handle_, 0, tip_);
  // To the lower edge of the block, and 60 mm of what may be behind it.
  EXPECT_NEAR(object.reach(), std::hypot(0.11, 0.05, 0.13), 0.013);
  EXPECT_TRUE(is_near(object, tip_, {0.61, 0, 0.1}, 0));           // in the shaft
  EXPECT_TRUE(is_near(object, tip_, {0.57, 0.04, 0.04}, 0));       // in the block
  EXPECT_FALSE(is_near(object, tip_, {0.6, 0.14, 0.25}, 0.005));   // in the other thing
  EXPECT_FALSE(is_near(object, tip_, {0.5, 0.15, 0}, 0.005));      // on the table
  EXPECT_FALSE(is_near(object, tip_, {0.57, -0.09, 0.04}, 0.02));  // 30 mm beside the block
  EXPECT_TRUE(is_near(object, tip_, {0.57, -0.09, 0.04}, 0.04));
  // There may be more of the block behind it, but the handle is as thick as it is.
  EXPECT_TRUE(is_near(object, tip_, {0.71, 0, 0.04}, 0.01));
  EXPECT_FALSE(is_near(object, tip_, {0.76, 0, 0.04}, 0.01));
  EXPECT_FALSE(is_near(object, tip_, {0.68, 0, 0.16}, 0.01));
  // It goes where the hand goes, and turns with it.
  EXPECT_TRUE(is_near(object, sensor::translation(0, 0, 1) * tip_, {0.61, 0, 1.1}, 0));
  EXPECT_FALSE(is_near(object, sensor::translation(0, 0, 1) * tip_, {0.61, 0, 0.1}, 0.005));
  const plan::Pose upside_down = tip_ * sensor::rotation({1, 0, 0}, 3.141592653589793);
  EXPECT_TRUE(is_near(object, upside_down, {0.57, 0.04, 0.26}, 0));

  // Guesses do not count where they are not asked for.
  EXPECT_FALSE(is_near(object, tip_, {0.71, 0, 0.04}, 0.01, false));
  EXPECT_TRUE(is_near(object, tip_, {0.57, 0.04, 0.04}, 0, false));

  EXPECT_EQ(HeldObject().reach(), 0);
  EXPECT_FALSE(is_near(HeldObject(), tip_, {0.61, 0, 0.1}, 1));
}

TEST_F(HeldObjectTest, KeepsAwayFromTheRestButNotFromTheTable) {
  const Cloud cloud = shaft_on_block({0.56, 0.09, 0}, {0.66, 0.19, 0.3});
  const HeldObject object(cloud.view(), {}, handle_, 0, tip_);
  EXPECT_FALSE(is_near_rest(object, tip_));
  EXPECT_TRUE(is_near_rest(object, sensor::translation(0, 0.05, 0) * tip_));
  EXPECT_FALSE(is_near_rest(object, sensor::translation(0, 0.05, 0.4) * tip_));
  // Taken away, it leaves the other thing and the table.
  const Cloud& rest = object.rest();
  ASSERT_EQ(rest.size(), cloud.size());
  for (std::size_t i = 0; i + 1 < rest.size(); ++i) {
    const float *p = &cloud.xyz[3 * i], *q = &rest.xyz[3 * i];
    if (p[2] > 0.012f) {
      EXPECT_EQ(std::isnan(q[0]), p[1] < 0.07f) << p[0] << " " << p[1] << " " << p[2];
    }
    if (p[2] == 0) {
      EXPECT_EQ(q[0], p[0]);
    }
  }
}

TEST_F(HeldObjectTest, TellsHowFarItMayMove) {
  const HeldObject object(shaft_on_block({0.56, 0.09, 0}, {0.66, 0.19, 0.3}).view(), {}, handle_, 0, tip_);
  plan::Obstacles obstacles;
  obstacles.add("ball", ball_at({0.56, -0.16, 0.04}));  // 100 mm beside the block
  const double room = object.room(tip_, obstacles, {}, {0.01, 0.01, true});
  EXPECT_LE(room, 0.09);
  EXPECT_GE(room, 0);
  for (const double way : {0.5, 0.99}) {
    const plan::Pose moved = sensor::translation(0, -way * room, 0) * tip_;
    EXPECT_GE(object.room(moved, obstacles, {}, {0.01, 0.01, true}), 0);
  }
  EXPECT_LT(object.room(sensor::translation(0, -0.092, 0) * tip_, obstacles, {}, {0.01, 0.01, true}), 0);
  EXPECT_GT(HeldObject().room(tip_, obstacles, {}, {0.01, 0.01, true}), 0);
}

TEST_F(HeldObjectTest, GivesUpGuessesThatAreWrongAndLetsWhatWasSeenStay) {
  // 30 mm behind the block, where there might be more of it; and 8 mm beside it.
  const Cloud cloud = shaft_on_block({0.69, -0.05, 0}, {0.79, 0.05, 0.3});
  HeldObject object(cloud.view(), {}, handle_, 0, tip_);
  plan::Obstacles obstacles;
  obstacles.set_cloud(object.rest().view(), {});
  obstacles.add("ball", ball_at({0.57, 0.068, 0.04}));
  const HeldObject::Care care{0.015, 0.015, true};
  const plan::Pose lifted = sensor::translation(0, 0, 0.05) * tip_, back = sensor::translation(-0.02, 0, 0.05) * tip_;
  EXPECT_LT(object.room(tip_, obstacles, {}, care), 0);
  const double reach = object.reach();
  object.leave_room(tip_, obstacles, {}, care);
  EXPECT_LT(object.reach(), reach);
  EXPECT_GE(object.room(tip_, obstacles, {}, care), 0);
  EXPECT_GE(object.room(lifted, obstacles, {}, care), 0);
  EXPECT_GE(object.room(back, obstacles, {}, care), 0);
  EXPECT_TRUE(is_near(object, tip_, {0.57, 0.04, 0.04}, 0));
  // Nearer to the ball, nearer to what is behind.
  EXPECT_LT(object.room(sensor::translation(0, 0.004, 0) * tip_, obstacles, {}, care), 0);
  EXPECT_LT(object.room(sensor::translation(0.03, 0, 0) * tip_, obstacles, {}, care), 0);
}

TEST_F(HeldObjectTest, HangsBelowTheFingers) {
  const HeldObject object(shaft_on_block({0.56, 0.09, 0}, {0.66, 0.19, 0.3}).view(), {}, handle_, 0, tip_);
  // The block is straight below already.
  const plan::Pose still = object.hung(tip_);
  for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(still.R[k], k % 4 == 0, 0.1);
  // However the hand turns about the axis through its fingers, the block stays below them, and its height is right.
  for (const double angle : {0.3, 1.5, 3.0, -2.0}) {
    const plan::Pose turned = tip_ * sensor::rotation({0, 1, 0}, angle), hung = turned * object.hung(turned);
    EXPECT_TRUE(is_near(object, hung, {0.57, 0.04, 0.04}, 0.005)) << angle;
    EXPECT_FALSE(is_near(object, hung, {0.61, 0, 0.27}, 0.02)) << angle;
    EXPECT_FALSE(std::fabs(angle) > 1 && is_near(object, turned, {0.57, 0.04, 0.04}, 0.005)) << angle;
    EXPECT_EQ(hung.t, turned.t);
  }
  // About the approach nothing turns between two tips.
  const plan::Pose along_x = tip_ * sensor::rotation({0, 1, 0}, 1.5707963267948966);
  const HeldObject same(shaft_on_block({0.56, 0.09, 0}, {0.66, 0.19, 0.3}).view(), {}, handle_, 0, along_x);
  EXPECT_EQ(same.hung(along_x * sensor::rotation({0, 0, 1}, 1.5)).R, plan::Pose().R);
}

// ---- Ways to the box ------------------------------------------------------------------------------------------------

/// Baxter's right arm at rest, holding a rod that hangs 0.2 m below its hand.
class CarrierTest : public ::testing::Test {
 protected:
  static constexpr double kRod = 0.2;

  CarrierTest() : arm_(plan::Arm::baxter(plan::Side::kRight, in_slot(2))), start_(arm_.rest()) {
    bin_ = workplace(in_slot(2)).world.bin;
    floor_.kind = plan::Shape::Kind::kBox;
    floor_.size = {4, 4, 0.1};
    floor_.T_base_body = sensor::translation(0, 0, -0.6);
  }
  /// A cloud of the rod and of a box.
  Cloud cloud_with(const Vector3& low, const Vector3& high) const {
    Cloud cloud;
    const Vector3 tip = arm_.forward(start_).t;
    add_box(cloud.xyz, {tip[0], tip[1], tip[2] - kRod}, tip);
    add_box(cloud.xyz, low, high);
    cloud.width = static_cast<std::uint32_t>(cloud.xyz.size() / 3);
    return cloud;
  }
  std::optional<Carrier::Way> way(const Cloud& cloud,
                                  std::vector<std::pair<std::string, plan::Body>> known = {}) const {
    known.emplace_back("floor", floor_);
    Carrier carrier(arm_, bin_, known);
    Handle handle;
    handle.center = arm_.forward(start_).t;
    handle.axis = {0, 0, 1};
    handle.radius = 0.01;
    handle.length = 0.06;
    carrier.hold(HeldObject(cloud.view(), {}, handle, -1, arm_.forward(start_)), {}, {});
    auto found = carrier.to_box(start_, start_);
    if (found) turned_down_ = carrier.turned_down(found->stops.back());
    return found;
  }
  /// The least distance of the rod's points from a body on the way.
  double least_distance(const Carrier::Way& way, const plan::Body& body) const {
    const plan::GraspPlanner planner(arm_);
    const plan::Pose T_tip_start = arm_.forward(start_).inverse();
    double least = 10;
    plan::JointVector from = start_;
    for (const plan::JointVector& to : way.stops) {
      for (const plan::JointVector& q : planner.straight(from, to)) {
        const plan::Pose moved = arm_.forward(q) * T_tip_start;
        for (double below = 0; below <= kRod; below += 0.01) {
          Vector3 p = arm_.forward(start_).t;
          p[2] -= below;
          least = std::min(least, plan::distance(body, moved.point(p)));
        }
      }
      from = to;
    }
    return least;
  }

  plan::Arm arm_;
  plan::JointVector start_;
  physics::Bin bin_;
  plan::Body floor_;
  mutable std::optional<plan::JointVector> turned_down_;
};

TEST_F(CarrierTest, GoesOverTheBoxWithoutTiltingTheHand) {
  const auto found = way(cloud_with({2, 2, 2}, {2, 2, 2}));
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->care, Care::kAmple);
  const plan::Pose end = arm_.forward(found->stops.back());
  const Vector3& middle = bin_.T_world_bin.t;
  EXPECT_NEAR(end.t[0], middle[0], 1e-3);
  EXPECT_NEAR(end.t[1], middle[1], 1e-3);
  EXPECT_GE(end.t[2] - kRod, middle[2] + bin_.inner[2]);
  const auto down_in_hand = [&](const plan::JointVector& q) { return arm_.forward(q).inverse().direction({0, 0, -1}); };
  const plan::GraspPlanner planner(arm_);
  plan::JointVector from = start_;
  for (const plan::JointVector& to : found->stops) {
    for (const plan::JointVector& q : planner.straight(from, to)) {
      const Vector3 a = down_in_hand(from), b = down_in_hand(q);
      EXPECT_GT(a[0] * b[0] + a[1] * b[1] + a[2] * b[2], std::cos(0.36));
    }
    from = to;
  }
  // There it can point further down, over the box.
  ASSERT_TRUE(turned_down_.has_value());
  EXPECT_GE(down_in_hand(*turned_down_)[2], std::cos(0.81));
  EXPECT_NEAR(arm_.forward(*turned_down_).t[1], middle[1], 1e-3);
}

TEST_F(CarrierTest, KeepsWhatIsHeldAwayFromThings) {
  const Cloud cloud = cloud_with({2, 2, 2}, {2, 2, 2});
  const auto free = way(cloud);
  ASSERT_TRUE(free.has_value());
  // In the way of the rod, not of the arm: a post below the hand's way.
  const plan::GraspPlanner planner(arm_);
  const auto last = planner.straight(free->stops.size() > 1 ? free->stops[0] : start_, free->stops.back());
  plan::Body post;
  post.kind = plan::Shape::Kind::kSphere;
  post.radius = 0.03;
  post.T_base_body.t = arm_.forward(last[last.size() / 2]).t;
  post.T_base_body.t[2] -= 0.16;
  EXPECT_LT(least_distance(*free, post), 0.02);
  const auto found = way(cloud, {{"post", post}});
  ASSERT_TRUE(found.has_value());
  EXPECT_NE(found->stops, free->stops);
  if (found->care == Care::kAmple || found->care == Care::kAsTaken) {
    EXPECT_GE(least_distance(*found, post), 0.02);
  }
  EXPECT_NE(found->care, Care::kArmOnly);
  // The same as points.
  std::vector<float> ball;
  add_box(ball, {post.T_base_body.t[0] - 0.02, post.T_base_body.t[1] - 0.02, post.T_base_body.t[2] - 0.02},
          {post.T_base_body.t[0] + 0.02, post.T_base_body.t[1] + 0.02, post.T_base_body.t[2] + 0.02});
  Cloud with_ball = cloud;
  with_ball.xyz.insert(with_ball.xyz.end(), ball.begin(), ball.end());
  with_ball.width = static_cast<std::uint32_t>(with_ball.xyz.size() / 3);
  const auto around = way(with_ball);
  ASSERT_TRUE(around.has_value());
  EXPECT_NE(around->stops, free->stops);
}

TEST_F(CarrierTest, SaysWhenThereIsNoWay) {
  plan::Body lid;  // over the box
  lid.kind = plan::Shape::Kind::kBox;
  lid.size = {2, 1, 2};
  lid.T_base_body.t = bin_.T_world_bin.t;
  EXPECT_FALSE(way(cloud_with({2, 2, 2}, {2, 2, 2}), {{"lid", lid}}).has_value());
  bin_.T_world_bin.t = {5, 0, 0};
  EXPECT_FALSE(way(cloud_with({2, 2, 2}, {2, 2, 2})).has_value());
}

TEST_F(CarrierTest, KnowsWaysThatAreClear) {
  plan::JointVector turned = start_;
  turned[0] -= 0.5;
  const plan::GraspPlanner planner(arm_);
  const auto path = planner.straight(start_, turned);
  const plan::Pose between = arm_.forward(path[path.size() / 2]);
  plan::Body ball;
  ball.radius = 0.02;
  ball.T_base_body.t = between.t;
  EXPECT_TRUE(Carrier(arm_, bin_, {}).is_clear(start_, turned));
  EXPECT_FALSE(Carrier(arm_, bin_, {{"ball", ball}}).is_clear(start_, turned));
}

Options localizer() {
  Options options = Options::baxter();
  options.hand_aperture = in_slot(2).opening_open();
  options.hand_minimum = in_slot(2).opening_closed();
  return options;
}

/// The first scene of an object of the paper.
std::vector<physics::Thing> alone(const std::string& family, const Workplace& place) {
  for (const sensor::SceneFile& file : sensor::single_object_scenes()) {
    if (file.objects.back().family == family) return things_of(file, place.T_base_scene);
  }
  return {};
}

TEST(Picker, PutsAPlungerIntoTheBox) {
  const Workplace place = workplace(in_slot(2));
  std::vector<double> ends;
  for (int i = 0; i < 2; ++i) {
    Picker picker(place, alone("plunger", place), localizer());
    EXPECT_TRUE(picker.settle());
    EXPECT_EQ(picker.left().size(), 1u);
    const Attempt attempt = picker.attempt(7);
    EXPECT_EQ(attempt.ending, Ending::kGrasped) << attempt.why;
    EXPECT_EQ(attempt.thing, 0u);
    EXPECT_TRUE(picker.left().empty());
    EXPECT_TRUE(picker.world().in_bin(0));
    EXPECT_GT(attempt.seconds, 5);
    for (const double v : picker.world().pose(0).R) ends.push_back(v);
    for (const double v : picker.world().pose(0).t) ends.push_back(v);
  }
  // The same seed gives the same, to the last bit.
  EXPECT_TRUE(std::equal(ends.begin(), ends.begin() + 12, ends.begin() + 12));
}

TEST(Picker, LosesWhatIsTooSlippery) {
  const Workplace place = workplace(in_slot(2));
  std::vector<physics::Thing> things = alone("plunger", place);
  things[0].friction = 0.02;
  Picker picker(place, things, localizer());
  picker.settle();
  const Attempt attempt = picker.attempt(7);
  EXPECT_NE(attempt.ending, Ending::kGrasped);
  EXPECT_NE(attempt.ending, Ending::kNotLocalized);
  EXPECT_NE(attempt.ending, Ending::kNoPlan);
  EXPECT_FALSE(picker.world().in_bin(0));
}

TEST(Picker, SaysThatTheSimulationBrokeDown) {
  const Workplace place = workplace(in_slot(2));
  std::vector<physics::Thing> things;
  for (int i = 0; i < 12; ++i) {  // more contacts than there is room for
    things.push_back(alone("brush_2", place).front());
    things.back().name += std::to_string(i);
  }
  Picker picker(place, things, localizer());
  EXPECT_FALSE(picker.settle());
  const Attempt attempt = picker.attempt(1);
  EXPECT_EQ(attempt.ending, Ending::kBrokeDown) << attempt.why;
  EXPECT_NE(attempt.why.find("broke down"), std::string::npos) << attempt.why;
}

TEST(Picker, DoesNothingWithoutAHandleOrAPlan) {
  const Workplace place = workplace(in_slot(2));
  Picker nothing(place, {}, localizer());
  EXPECT_EQ(nothing.attempt(1).ending, Ending::kNotLocalized);
  EXPECT_TRUE(nothing.left().empty());

  // Found, but thinner than the fingers close in slot 4.
  const Workplace wide = workplace(in_slot(4));
  Options options = localizer();
  options.hand_minimum = 0;
  Picker wide_open(wide, alone("plunger", wide), options);
  wide_open.settle();
  const plan::JointVector before = wide_open.world().joints();
  const Attempt attempt = wide_open.attempt(1);
  EXPECT_EQ(attempt.ending, Ending::kNoPlan) << attempt.why;
  EXPECT_NE(attempt.why.find("too thin"), std::string::npos) << attempt.why;
  EXPECT_FALSE(attempt.thing.has_value());
  EXPECT_EQ(wide_open.world().joints(), before);
  EXPECT_EQ(wide_open.left().size(), 1u);
  EXPECT_EQ(attempt.pushed, 0);
}

}  // namespace
}  // namespace handhold::experiments
