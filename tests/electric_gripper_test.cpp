// Baxter's electric gripper: its openings, and the URDF with its frame and fingers.
#include "arm_helpers.h"
#include "handhold/options.h"

namespace handhold::plan {
namespace {

struct Opening {
  Finger finger;
  int slot;
  Tip tip;
  double closed, open;
};
/// Computed from the published collision shapes (m).
const Opening kOpenings[] = {
    {Finger::kStandardNarrow, 1, Tip::kHard, -0.003, 0.03867},
    {Finger::kStandardNarrow, 1, Tip::kSoft, -0.0035, 0.03817},
    {Finger::kStandardNarrow, 1, Tip::kPaddle, -0.003, 0.03867},
    {Finger::kStandardNarrow, 1, Tip::kHalfRound, -0.0125, 0.02917},
    {Finger::kStandardNarrow, 2, Tip::kHard, 0.016, 0.05767},
    {Finger::kStandardNarrow, 2, Tip::kSoft, 0.0155, 0.05717},
    {Finger::kStandardNarrow, 2, Tip::kPaddle, 0.016, 0.05767},
    {Finger::kStandardNarrow, 2, Tip::kHalfRound, 0.0065, 0.04817},
    {Finger::kStandardNarrow, 3, Tip::kHard, 0.035, 0.07667},
    {Finger::kStandardNarrow, 3, Tip::kSoft, 0.0345, 0.07617},
    {Finger::kStandardNarrow, 3, Tip::kPaddle, 0.035, 0.07667},
    {Finger::kStandardNarrow, 3, Tip::kHalfRound, 0.0255, 0.06717},
    {Finger::kStandardNarrow, 4, Tip::kHard, 0.054, 0.09567},
    {Finger::kStandardNarrow, 4, Tip::kSoft, 0.0535, 0.09517},
    {Finger::kStandardNarrow, 4, Tip::kPaddle, 0.054, 0.09567},
    {Finger::kStandardNarrow, 4, Tip::kHalfRound, 0.0445, 0.08617},
    {Finger::kStandardWide, 1, Tip::kHard, 0.07256, 0.11423},
    {Finger::kStandardWide, 1, Tip::kSoft, 0.07206, 0.11373},
    {Finger::kStandardWide, 1, Tip::kPaddle, 0.07256, 0.11423},
    {Finger::kStandardWide, 1, Tip::kHalfRound, 0.06306, 0.10473},
    {Finger::kStandardWide, 2, Tip::kHard, 0.09156, 0.13323},
    {Finger::kStandardWide, 2, Tip::kSoft, 0.09106, 0.13273},
    {Finger::kStandardWide, 2, Tip::kPaddle, 0.09156, 0.13323},
    {Finger::kStandardWide, 2, Tip::kHalfRound, 0.08206, 0.12373},
    {Finger::kStandardWide, 3, Tip::kHard, 0.11056, 0.15223},
    {Finger::kStandardWide, 3, Tip::kSoft, 0.11006, 0.15173},
    {Finger::kStandardWide, 3, Tip::kPaddle, 0.11056, 0.15223},
    {Finger::kStandardWide, 3, Tip::kHalfRound, 0.10106, 0.14273},
    {Finger::kStandardWide, 4, Tip::kHard, 0.12956, 0.17123},
    {Finger::kStandardWide, 4, Tip::kSoft, 0.12906, 0.17073},
    {Finger::kStandardWide, 4, Tip::kPaddle, 0.12956, 0.17123},
    {Finger::kStandardWide, 4, Tip::kHalfRound, 0.12006, 0.16173},
    {Finger::kExtendedNarrow, 1, Tip::kHard, -0.003, 0.03867},
    {Finger::kExtendedNarrow, 1, Tip::kSoft, -0.0035, 0.03817},
    {Finger::kExtendedNarrow, 1, Tip::kPaddle, -0.003, 0.03867},
    {Finger::kExtendedNarrow, 1, Tip::kHalfRound, -0.0125, 0.02917},
    {Finger::kExtendedNarrow, 2, Tip::kHard, 0.016, 0.05767},
    {Finger::kExtendedNarrow, 2, Tip::kSoft, 0.0155, 0.05717},
    {Finger::kExtendedNarrow, 2, Tip::kPaddle, 0.016, 0.05767},
    {Finger::kExtendedNarrow, 2, Tip::kHalfRound, 0.0065, 0.04817},
    {Finger::kExtendedNarrow, 3, Tip::kHard, 0.035, 0.07667},
    {Finger::kExtendedNarrow, 3, Tip::kSoft, 0.0345, 0.07617},
    {Finger::kExtendedNarrow, 3, Tip::kPaddle, 0.035, 0.07667},
    {Finger::kExtendedNarrow, 3, Tip::kHalfRound, 0.0255, 0.06717},
    {Finger::kExtendedNarrow, 4, Tip::kHard, 0.054, 0.09567},
    {Finger::kExtendedNarrow, 4, Tip::kSoft, 0.0535, 0.09517},
    {Finger::kExtendedNarrow, 4, Tip::kPaddle, 0.054, 0.09567},
    {Finger::kExtendedNarrow, 4, Tip::kHalfRound, 0.0445, 0.08617},
    {Finger::kExtendedWide, 1, Tip::kHard, 0.07256, 0.11423},
    {Finger::kExtendedWide, 1, Tip::kSoft, 0.07206, 0.11373},
    {Finger::kExtendedWide, 1, Tip::kPaddle, 0.07256, 0.11423},
    {Finger::kExtendedWide, 1, Tip::kHalfRound, 0.06306, 0.10473},
    {Finger::kExtendedWide, 2, Tip::kHard, 0.09156, 0.13323},
    {Finger::kExtendedWide, 2, Tip::kSoft, 0.09106, 0.13273},
    {Finger::kExtendedWide, 2, Tip::kPaddle, 0.09156, 0.13323},
    {Finger::kExtendedWide, 2, Tip::kHalfRound, 0.08206, 0.12373},
    {Finger::kExtendedWide, 3, Tip::kHard, 0.11056, 0.15223},
    {Finger::kExtendedWide, 3, Tip::kSoft, 0.11006, 0.15173},
    {Finger::kExtendedWide, 3, Tip::kPaddle, 0.11056, 0.15223},
    {Finger::kExtendedWide, 3, Tip::kHalfRound, 0.10106, 0.14273},
    {Finger::kExtendedWide, 4, Tip::kHard, 0.12956, 0.17123},
    {Finger::kExtendedWide, 4, Tip::kSoft, 0.12906, 0.17073},
    {Finger::kExtendedWide, 4, Tip::kPaddle, 0.12956, 0.17123},
    {Finger::kExtendedWide, 4, Tip::kHalfRound, 0.12006, 0.16173},
};

TEST(ElectricGripper, OpensAsItsShapesSay) {
  for (const Opening& row : kOpenings) {
    const ElectricGripper gripper = {row.finger, row.slot, row.tip};
    EXPECT_NEAR(gripper.opening_closed(), row.closed, 1e-5);
    EXPECT_NEAR(gripper.opening_open(), row.open, 1e-5);
  }
}

TEST(ElectricGripper, DefaultIsTheHandOfTheLocalizer) {
  const ElectricGripper gripper;
  const Options options = Options::baxter();
  EXPECT_NEAR(gripper.opening_closed(), options.hand_minimum, 1e-9);
  EXPECT_NEAR(gripper.opening_open(), options.hand_aperture, 1e-4);
}

/// Distance between the two tips' inner faces, from the arm's shapes.
double opening_between_tips(const Arm& arm, double opening, double half_width) {
  const std::vector<Pose> T_base_link = arm.link_poses(arm.rest(), opening);
  std::vector<Pose> tips;
  for (const Shape& shape : arm.shapes()) {
    const std::string& link = arm.links()[shape.link];
    if (link == "l_gripper_l_finger_tip" || link == "l_gripper_r_finger_tip") {
      tips.push_back(T_base_link[shape.link] * shape.T_link_shape);
    }
  }
  EXPECT_EQ(tips.size(), 2u);
  return tips.size() == 2 ? distance(tips[0], tips[1]) - 2 * half_width : 0;
}

TEST(ElectricGripper, EveryConfigurationGivesAUrdfWithItsFrameAndFingers) {
  for (const Opening& row : kOpenings) {
    const ElectricGripper gripper = {row.finger, row.slot, row.tip};
    const Arm arm = Arm::baxter(Side::kLeft, gripper);
    const std::vector<Pose> T_base_link = arm.link_poses(arm.rest());
    const Pose T_gripper_base_tip =
        T_base_link[arm.link_index("left_gripper_base")].inverse() * arm.forward(arm.rest());
    EXPECT_NEAR(T_gripper_base_tip.t[2], gripper.finger_length() + 0.02, 1e-12);
    EXPECT_NEAR(gripper.endpoint_offset(), gripper.finger_length() + 0.02, 1e-12);
    const double half_width = row.tip == Tip::kHalfRound ? 0.008 : row.tip == Tip::kSoft ? 0.0035 : 0.00325;
    const Hand& hand = arm.hand();
    EXPECT_EQ(hand.opening_min, std::max(0.0, gripper.opening_closed()));
    for (const double share : {0.0, 0.3, 1.0}) {
      const double opening = hand.opening_min + share * (hand.opening_max - hand.opening_min);
      EXPECT_NEAR(opening_between_tips(arm, opening, half_width), opening, 1e-9);
    }
    EXPECT_NEAR(opening_between_tips(arm, -1, half_width), hand.opening_min, 1e-9);
    EXPECT_NEAR(opening_between_tips(arm, 9, half_width), hand.opening_max, 1e-9);
  }
}

TEST(ElectricGripper, RefusesASlotThatIsNotThere) {
  for (const int slot : {0, 5}) {
    const ElectricGripper gripper = {Finger::kStandardNarrow, slot, Tip::kHard};
    EXPECT_MENTIONS(message_of([&] { Arm::baxter(Side::kRight, gripper); }), "must be 1, 2, 3 or 4");
  }
}

TEST(ElectricGripper, TheUrdfFileIsTheDefault) {
  EXPECT_EQ(baxter_urdf(), text_of_file(kUrdfFile));
}

}  // namespace
}  // namespace handhold::plan
