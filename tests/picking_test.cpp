// The robot that grasps in physics: which gripper it takes, what it knows of a held object, and whole attempts.
#include "picking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
  /// Whether it comes to within `margin` of a ball of 10 mm at p.
  static bool is_near(const HeldObject& object, const plan::Pose& hand, const Vector3& p, double margin) {
    plan::Body ball;
    ball.kind = plan::Shape::Kind::kSphere;
    ball.radius = 0.01;
    ball.T_base_body.t = p;
    return object.near(hand, ball, margin);
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

  EXPECT_EQ(HeldObject().reach(), 0);
  EXPECT_FALSE(is_near(HeldObject(), tip_, {0.61, 0, 0.1}, 1));
}

TEST_F(HeldObjectTest, KeepsAwayFromTheRestButNotFromTheTable) {
  const Cloud cloud = shaft_on_block({0.56, 0.09, 0}, {0.66, 0.19, 0.3});
  const HeldObject object(cloud.view(), {}, handle_, 0, tip_);
  EXPECT_FALSE(object.near_others(tip_));
  EXPECT_FALSE(object.near_others(sensor::translation(0, 0, -0.1) * tip_));
  EXPECT_TRUE(object.near_others(sensor::translation(0, 0.05, 0) * tip_));
  EXPECT_FALSE(object.near_others(sensor::translation(0, 0.05, 0.4) * tip_));
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

TEST_F(HeldObjectTest, GivesUpGuessesThatAreWrong) {
  const Cloud cloud = shaft_on_block({0.7, -0.05, 0}, {0.8, 0.05, 0.3});
  HeldObject object(cloud.view(), {}, handle_, 0, tip_);
  // What may be behind the block is where the other thing is.
  EXPECT_TRUE(object.near_others(tip_));
  object.correct(tip_);
  EXPECT_FALSE(object.near_others(tip_));
  EXPECT_TRUE(is_near(object, tip_, {0.57, 0.04, 0.04}, 0));
  EXPECT_TRUE(object.near_others(sensor::translation(0.05, 0, 0) * tip_));
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
