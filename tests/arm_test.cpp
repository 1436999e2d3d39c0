// Arms: Baxter's published numbers, forward kinematics, other arms from URDF and TOML.
#include "handhold/arm.h"

#include <filesystem>
#include <fstream>
#include <random>

#include "arm_helpers.h"

namespace handhold::plan {
namespace {

// ---- Forward kinematics ---------------------------------------------------------------------------------------------

struct Vector {
  std::string link;
  JointVector q;
  Pose T_base_link;
};

/// Published frames: baxter_common 1.2.0, electric gripper with extended narrow fingers.
const std::vector<Vector> kVectors = {
    {"right_hand",
     {0, 0, 0, 0, 0, 0, 0},
     {{1.3849759044e-11, 0.707108079849, 0.707105482522, 6.9249066049e-12, 0.707105482522, -0.707108079849, -1,
       1.46899159503e-11, 4.8965831391e-12},
      {0.797461795007, -0.992464633716, 0.320976000003}}},
    {"right_hand",
     {0.08, -1, 1.19, 1.94, -0.67, 1.03, 0.5},
     {{-0.959067131123, -0.278031411001, 0.0537473022158, -0.279220009576, 0.960095691065, -0.0158886831164,
       -0.0471850002779, -0.0302456359731, -0.998428153276},
      {0.571234838321, -0.180788602664, 0.271152390396}}},
    {"right_hand",
     {-0.35, 0.4, -0.8, 1.2, 0.6, -0.5, 1.9},
     {{0.898935489183, 0.202917564722, -0.388251784562, -0.187665318321, -0.622448662859, -0.759828526975,
       -0.395849358453, 0.755898223329, -0.521460603862},
      {-0.123700964534, -0.927882904578, -0.185234115847}}},
    {"right_hand",
     {1, -1.5, 2.2, 0.3, -2.4, 1.7, -0.9},
     {{0.021018561257, 0.016216403249, 0.999647562068, -0.898236763257, 0.439354574534, 0.0117590378128,
       -0.439009040017, -0.898167348606, 0.0238007706045},
      {0.286726946009, -0.11093576028, 1.13459427326}}},
    {"right_gripper_base",
     {0, 0, 0, 0, 0, 0, 0},
     {{1.3849759044e-11, 0.707108079849, 0.707105482522, 6.9249066049e-12, 0.707105482522, -0.707108079849, -1,
       1.46899159503e-11, 4.8965831391e-12},
      {0.81513943207, -1.01014233571, 0.320976000003}}},
    {"right_gripper_base",
     {0.08, -1, 1.19, 1.94, -0.67, 1.03, 0.5},
     {{-0.959067131123, -0.278031411001, 0.0537473022158, -0.279220009576, 0.960095691065, -0.0158886831164,
       -0.0471850002779, -0.0302456359731, -0.998428153276},
      {0.572578520876, -0.181185819742, 0.246191686564}}},
    {"right_gripper_base",
     {-0.35, 0.4, -0.8, 1.2, 0.6, -0.5, 1.9},
     {{0.898935489183, 0.202917564722, -0.388251784562, -0.187665318321, -0.622448662859, -0.759828526975,
       -0.395849358453, 0.755898223329, -0.521460603862},
      {-0.133407259148, -0.946878617752, -0.198270630944}}},
    {"right_gripper_base",
     {1, -1.5, 2.2, 0.3, -2.4, 1.7, -0.9},
     {{0.021018561257, 0.016216403249, 0.999647562068, -0.898236763257, 0.439354574534, 0.0117590378128,
       -0.439009040017, -0.898167348606, 0.0238007706045},
      {0.311718135061, -0.110641784335, 1.13518929253}}},
    {"right_gripper",
     {0, 0, 0, 0, 0, 0, 0},
     {{1.3849759044e-11, 0.707108079849, 0.707105482522, 6.9249066049e-12, 0.707105482522, -0.707108079849, -1,
       1.46899159503e-11, 4.8965831391e-12},
      {0.9089723296, -1.10397557791, 0.320976000004}}},
    {"right_gripper",
     {0.08, -1, 1.19, 1.94, -0.67, 1.03, 0.5},
     {{-0.959067131123, -0.278031411001, 0.0537473022158, -0.279220009576, 0.960095691065, -0.0158886831164,
       -0.0471850002779, -0.0302456359731, -0.998428153276},
      {0.57971078788, -0.183294247991, 0.113700270625}}},
    {"right_gripper",
     {-0.35, 0.4, -0.8, 1.2, 0.6, -0.5, 1.9},
     {{0.898935489183, 0.202917564722, -0.388251784562, -0.187665318321, -0.622448662859, -0.759828526975,
       -0.395849358453, 0.755898223329, -0.521460603862},
      {-0.18492827096, -1.04770786328, -0.267468453076}}},
    {"right_gripper",
     {1, -1.5, 2.2, 0.3, -2.4, 1.7, -0.9},
     {{0.021018561257, 0.016216403249, 0.999647562068, -0.898236763257, 0.439354574534, 0.0117590378128,
       -0.439009040017, -0.898167348606, 0.0238007706045},
      {0.444371366547, -0.109081360017, 1.13834765479}}},
    {"left_hand",
     {0, 0, 0, 0, 0, 0, 0},
     {{-6.92495747785e-12, -0.70710807987, 0.707105482501, 1.38497336073e-11, 0.707105482501, 0.70710807987, -1,
       1.46899159503e-11, 4.8965831391e-12},
      {0.797461794996, 0.992464633727, 0.320976000003}}},
    {"left_hand",
     {0.08, -1, 1.19, 1.94, -0.67, 1.03, 0.5},
     {{0.279223532424, -0.960094669792, 0.0158884856914, -0.959066105485, -0.278034937628, 0.0537473605778,
       -0.0471850002779, -0.0302456359731, -0.998428153276},
      {-0.0142134050724, 0.76623469559, 0.271152390396}}},
    {"left_hand",
     {-0.35, 0.4, -0.8, 1.2, 0.6, -0.5, 1.9},
     {{0.187662016345, 0.622447917497, 0.759829953098, 0.89893617851, 0.202919851102, -0.388248993553, -0.395849358453,
       0.755898223329, -0.521460603862},
      {0.732883449478, 0.0713016369697, -0.185234115847}}},
    {"left_hand",
     {1, -1.5, 2.2, 0.3, -2.4, 1.7, -0.9},
     {{0.898236686045, -0.439354634097, -0.0117627097233, 0.0210218606647, 0.0162147894095, 0.999647518868,
       -0.439009040017, -0.898167348606, 0.0238007706045},
      {-0.0840652024001, 0.481726546696, 1.13459427326}}},
    {"left_gripper_base",
     {0, 0, 0, 0, 0, 0, 0},
     {{-6.92495747785e-12, -0.70710807987, 0.707105482501, 1.38497336073e-11, 0.707105482501, 0.70710807987, -1,
       1.46899159503e-11, 4.8965831391e-12},
      {0.815139432058, 1.01014233572, 0.320976000003}}},
    {"left_gripper_base",
     {0.08, -1, 1.19, 1.94, -0.67, 1.03, 0.5},
     {{0.279223532424, -0.960094669792, 0.0158884856914, -0.959066105485, -0.278034937628, 0.0537473605778,
       -0.0471850002779, -0.0302456359731, -0.998428153276},
      {-0.0138161929301, 0.767578379604, 0.246191686564}}},
    {"left_gripper_base",
     {-0.35, 0.4, -0.8, 1.2, 0.6, -0.5, 1.9},
     {{0.187662016345, 0.622447917497, 0.759829953098, 0.89893617851, 0.202919851102, -0.388248993553, -0.395849358453,
       0.755898223329, -0.521460603862},
      {0.751879198306, 0.0615954121309, -0.198270630944}}},
    {"left_gripper_base",
     {1, -1.5, 2.2, 0.3, -2.4, 1.7, -0.9},
     {{0.898236686045, -0.439354634097, -0.0117627097233, 0.0210218606647, 0.0162147894095, 0.999647518868,
       -0.439009040017, -0.898167348606, 0.0238007706045},
      {-0.0843592701432, 0.506717734667, 1.13518929253}}},
    {"left_gripper",
     {0, 0, 0, 0, 0, 0, 0},
     {{-6.92495747785e-12, -0.70710807987, 0.707105482501, 1.38497336073e-11, 0.707105482501, 0.70710807987, -1,
       1.46899159503e-11, 4.8965831391e-12},
      {0.908972329586, 1.10397557792, 0.320976000004}}},
    {"left_gripper",
     {0.08, -1, 1.19, 1.94, -0.67, 1.03, 0.5},
     {{0.279223532424, -0.960094669792, 0.0158884856914, -0.959066105485, -0.278034937628, 0.0537473605778,
       -0.0471850002779, -0.0302456359731, -0.998428153276},
      {-0.0117077908789, 0.774710654353, 0.113700270625}}},
    {"left_gripper",
     {-0.35, 0.4, -0.8, 1.2, 0.6, -0.5, 1.9},
     {{0.187662016345, 0.622447917497, 0.759829953098, 0.89893617851, 0.202919851102, -0.388248993553, -0.395849358453,
       0.755898223329, -0.521460603862},
      {0.852708633082, 0.0100747706864, -0.267468453076}}},
    {"left_gripper",
     {1, -1.5, 2.2, 0.3, -2.4, 1.7, -0.9},
     {{0.898236686045, -0.439354634097, -0.0117627097233, 0.0210218606647, 0.0162147894095, 0.999647518868,
       -0.439009040017, -0.898167348606, 0.0238007706045},
      {-0.0859201817235, 0.639370960421, 1.13834765479}}},
};

TEST(Arm, BaxterStandsWhereThePublishedModelStands) {
  const Arm right = Arm::baxter(Side::kRight, kExtendedNarrow), left = Arm::baxter(Side::kLeft, kExtendedNarrow);
  for (const Vector& vector : kVectors) {
    const bool is_right = vector.link.rfind("right_", 0) == 0;
    const Arm& arm = is_right ? right : left;
    const Pose T_base_link = arm.link_poses(vector.q)[arm.link_index(vector.link)];
    EXPECT_LT(distance(T_base_link, vector.T_base_link), 1e-6) << vector.link;
    EXPECT_LT(angle(T_base_link, vector.T_base_link), 1e-6) << vector.link;
    if (vector.link != arm.tip()) continue;
    EXPECT_LT(distance(arm.forward(vector.q), vector.T_base_link), 1e-6);
    EXPECT_LT(angle(arm.forward(vector.q), vector.T_base_link), 1e-6);
  }
}

TEST(Arm, BaxterHasItsJointsWithTheirLimits) {
  const Arm arm = Arm::baxter(Side::kLeft);
  EXPECT_EQ(arm.base(), "base");
  EXPECT_EQ(arm.tip(), "left_gripper");
  const std::vector<Joint> expected = {{"left_s0", false, -1.70167993878, 1.70167993878, 1.5},
                                       {"left_s1", false, -2.147, 1.047, 1.5},
                                       {"left_e0", false, -3.05417993878, 3.05417993878, 1.5},
                                       {"left_e1", false, -0.05, 2.618, 1.5},
                                       {"left_w0", false, -3.059, 3.059, 4},
                                       {"left_w1", false, -1.57079632679, 2.094, 4},
                                       {"left_w2", false, -3.059, 3.059, 4}};
  ASSERT_EQ(arm.joints().size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(arm.joints()[i].name, expected[i].name);
    EXPECT_FALSE(arm.joints()[i].prismatic);
    EXPECT_DOUBLE_EQ(arm.joints()[i].lower, expected[i].lower);
    EXPECT_DOUBLE_EQ(arm.joints()[i].upper, expected[i].upper);
    EXPECT_DOUBLE_EQ(arm.joints()[i].velocity, expected[i].velocity);
  }
  EXPECT_TRUE(arm.within_limits(arm.rest()));
}

TEST(Arm, RefusesAWrongNumberOfJoints) {
  const Arm arm = Arm::baxter(Side::kRight);
  EXPECT_EQ(message_of([&] { arm.forward({0, 0}); }), "the arm has 7 joints, not 2");
  EXPECT_EQ(message_of([&] { arm.link_poses({}); }), "the arm has 7 joints, not 0");
  EXPECT_FALSE(arm.within_limits({0, 0}));
}

// ---- Shapes ---------------------------------------------------------------------------------------------------------

std::vector<Shape> shapes_of(const Arm& arm, const std::string& link) {
  std::vector<Shape> shapes;
  for (const Shape& shape : arm.shapes()) {
    if (arm.links()[shape.link] == link) shapes.push_back(shape);
  }
  return shapes;
}

TEST(Arm, BodiesHaveShapes) {
  const Arm arm = Arm::baxter(Side::kRight);
  EXPECT_TRUE(arm.links_with_meshes().empty());
  const std::vector<std::pair<std::string, std::size_t>> counts = {{"torso", 2},
                                                                   {"pedestal", 1},
                                                                   {"collision_head_link_1", 1},
                                                                   {"collision_head_link_2", 1},
                                                                   {"_upper_shoulder", 1},
                                                                   {"_lower_shoulder", 1},
                                                                   {"_upper_elbow", 2},
                                                                   {"_lower_elbow", 1},
                                                                   {"_upper_forearm", 2},
                                                                   {"_lower_forearm", 1},
                                                                   {"_wrist", 1},
                                                                   {"_hand", 1},
                                                                   {"_gripper_base", 1},
                                                                   {"r_gripper_l_finger", 1},
                                                                   {"r_gripper_r_finger_tip", 1}};
  for (const auto& [link, count] : counts) {
    if (link[0] != '_') {
      EXPECT_EQ(shapes_of(arm, link).size(), count) << link;
      continue;
    }
    for (const std::string side : {"right", "left"}) EXPECT_EQ(shapes_of(arm, side + link).size(), count) << link;
  }

  const Shape wrist = shapes_of(arm, "right_wrist").front();
  EXPECT_EQ(wrist.kind, Shape::Kind::kCapsule);
  EXPECT_DOUBLE_EQ(wrist.radius, 0.06);
  EXPECT_DOUBLE_EQ(wrist.length, 0.165);
  const Shape head = shapes_of(arm, "collision_head_link_1").front();
  EXPECT_EQ(head.kind, Shape::Kind::kSphere);
  EXPECT_DOUBLE_EQ(head.radius, 0.22);
  EXPECT_EQ(head.T_link_shape.t, (Vector3{-0.07, -0.04, 0}));
  const Shape finger = shapes_of(arm, "r_gripper_l_finger").front();
  EXPECT_EQ(finger.kind, Shape::Kind::kBox);
  EXPECT_EQ(finger.size, (Vector3{0.01, 0.0135, 0.075}));
}

TEST(Arm, TheOtherArmRestsAndFixedBodiesStay) {
  const Arm arm = Arm::baxter(Side::kRight), other = Arm::baxter(Side::kLeft);
  std::mt19937_64 generator(3);
  const std::vector<Pose> before = arm.link_poses(arm.rest()), after = arm.link_poses(random_positions(arm, generator));
  for (const std::string link : {"torso", "pedestal", "collision_head_link_1", "left_wrist"}) {
    EXPECT_LT(distance(before[arm.link_index(link)], after[arm.link_index(link)]), 1e-12) << link;
  }
  EXPECT_GT(distance(before[arm.link_index("right_wrist")], after[arm.link_index("right_wrist")]), 0.01);
  EXPECT_LT(distance(before[arm.link_index("left_gripper")], other.forward(other.rest())), 1e-9);
}

// ---- Other arms -----------------------------------------------------------------------------------------------------

/// Three joints, a mesh, a gripper whose second finger mimics the first.
std::string small_urdf() {
  return R"(<robot name="small">
  <link name="table"/> <link name="base"/> <link name="lift"/> <link name="tip"/> <link name="finger"/>
  <link name="thumb"/> <link name="tool"/>
  <link name="upper"><collision><geometry><mesh filename="upper.stl"/></geometry></collision></link>
  <joint name="stand" type="fixed"><parent link="table"/><child link="base"/><origin xyz="0 0 1"/></joint>
  <joint name="turn" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="raise" type="prismatic"><parent link="upper"/><child link="lift"/><origin xyz="0.3 0 0"/>
    <axis xyz="0 0 1"/><limit lower="0.1" upper="0.5" velocity="0.2" effort="1"/></joint>
  <joint name="hold" type="fixed"><parent link="lift"/><child link="tip"/><origin xyz="0.2 0 0"/></joint>
  <joint name="pinch" type="prismatic"><parent link="tip"/><child link="finger"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>
  <joint name="follow" type="prismatic"><parent link="tip"/><child link="thumb"/><axis xyz="0 1 0"/>
    <limit lower="-0.05" upper="0" velocity="1" effort="1"/>
    <mimic joint="pinch" multiplier="-1" offset="-0.01"/></joint>
  <joint name="spin" type="continuous"><parent link="tip"/><child link="tool"/><axis xyz="1 0 0"/></joint>
</robot>)";
}
const Hand kSmallHand = {0.01, 0.09, {"pinch"}, std::nullopt, std::nullopt};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

TEST(Arm, AnyUrdfIsAnArm) {
  const Arm arm = Arm::from_urdf(small_urdf(), "base", "tip", kSmallHand, {{"raise", 0.3}});
  ASSERT_EQ(arm.joints().size(), 2u);
  EXPECT_TRUE(arm.joints()[1].prismatic);
  EXPECT_EQ(arm.rest(), (JointVector{0, 0.3}));
  const Pose T_base_tip = arm.forward({M_PI / 2, 0.2});
  EXPECT_LT(distance(T_base_tip, sensor::translation(0, 0.5, 0.3)), 1e-12);
  ASSERT_EQ(arm.links_with_meshes().size(), 1u);
  EXPECT_EQ(arm.links()[arm.links_with_meshes()[0]], "upper");

  const std::vector<Pose> T_base_link = arm.link_poses({0, 0.1}, 0.05);
  EXPECT_NEAR(T_base_link[arm.link_index("table")].t[2], -1, 1e-12);
  EXPECT_NEAR(T_base_link[arm.link_index("finger")].t[1], 0.02, 1e-12);
  EXPECT_NEAR(T_base_link[arm.link_index("thumb")].t[1], -0.03, 1e-12);

  const auto q = arm.inverse(T_base_tip);  // fewer joints than a pose has freedoms
  ASSERT_TRUE(q);
  EXPECT_NEAR((*q)[0], M_PI / 2, 1e-3);
  EXPECT_NEAR((*q)[1], 0.2, 2e-5);
  EXPECT_FALSE(arm.may_reach(sensor::translation(0.5, 0, 1)));
}

TEST(Arm, BadUrdfsAreOneClearLine) {
  const auto message = [](const std::string& urdf, const std::string& base = "base", const std::string& tip = "tip",
                          const Hand& hand = kSmallHand, const Posture& rest = {}) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const std::string line = message_of([&] { Arm::from_urdf(urdf, base, tip, hand, rest); });
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    return line;
  };
  const std::string good = small_urdf();
  for (const std::string text :
       {"", "this is no XML", "<robot name='x'><link></robot>", "<sdf/>", "<robot name='x'/>"}) {
    EXPECT_MENTIONS(message(text), "bad URDF: ");
    EXPECT_GT(message(text).size(), 12u) << text;
  }
  EXPECT_EQ(message(good, "bass"), "there is no link 'bass'");
  EXPECT_EQ(message(good, "base", "hand"), "there is no link 'hand'");
  EXPECT_MENTIONS(message(good, "tip", "base"), "no chain from 'tip' to 'base'");
  EXPECT_MENTIONS(message(good, "lift", "tip"), "no joint moves between");
  EXPECT_MENTIONS(message(good, "base", "tool"), "joint 'spin' has no limits");
  EXPECT_MENTIONS(message(replaced(good, R"(<limit lower="-3" upper="3" velocity="1" effort="1"/>)", "")), "turn");
  EXPECT_MENTIONS(message(replaced(good, R"(lower="-3" upper="3")", "")), "joint 'turn' has no range");
  EXPECT_MENTIONS(message(replaced(good, R"(velocity="0.2")", "")), "bad URDF: ");
  EXPECT_MENTIONS(message(replaced(good, "revolute", "planar")), "joint 'turn' is floating or planar");
  EXPECT_MENTIONS(message(replaced(good, "0 0 1\"/><limit lower=\"0.1\"", "0 0 0\"/><limit lower=\"0.1\"")), "axis");
  EXPECT_MENTIONS(message(replaced(good, "joint=\"pinch\"", "joint=\"pinhc\"")), "there is no joint 'pinhc'");
  EXPECT_MENTIONS(message(replaced(good, "joint=\"pinch\"", "joint=\"follow\"")), "mimics itself");
  EXPECT_MENTIONS(message(good, "base", "tip", {0, 0.1, {"pnich"}, {}, {}}), "there is no joint 'pnich'");
  EXPECT_MENTIONS(message(good, "base", "tip", {0, 0.1, {"hold"}, {}, {}}), "'hold' does not move");
  EXPECT_MENTIONS(message(good, "base", "tip", {0, 0.1, {"raise"}, {}, {}}), "one of the arm's");
  EXPECT_MENTIONS(message(good, "base", "tip", {0, 0.1, {"spin"}, {}, {}}), "give finger_closed and finger_open");
  EXPECT_MENTIONS(message(good, "base", "tip", {0.2, 0.1, {}, {}, {}}), "opening_min");
  EXPECT_MENTIONS(message(good, "base", "tip", kSmallHand, {{"rise", 0.2}}), "there is no joint 'rise'");
  EXPECT_MENTIONS(message(good, "base", "tip", kSmallHand, {{"raise", 0.7}}), "beyond its limits");
}

// ---- TOML -----------------------------------------------------------------------------------------------------------

class ArmToml : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("arm_toml_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
    write("small.urdf", small_urdf());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) {
    const std::filesystem::path path = folder_ / name;
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }
  std::string error_of(const std::string& toml) {
    const std::string path = write("arm.toml", toml);
    const std::string message = message_of([&] { read_arm(path); });
    EXPECT_EQ(message.rfind(path + ": ", 0), 0u) << message;
    return message;
  }

  std::filesystem::path folder_;
};

const std::string kSmallToml = R"(urdf = "small.urdf"
base = "base"
tip = "tip"
[hand]
opening_min_m = 0.01
opening_max_m = 0.09
finger_joints = ["pinch"]
[rest]
raise = 0.3
)";

TEST_F(ArmToml, ReadsAnArm) {
  const Arm arm = read_arm(write("arm.toml", kSmallToml));
  EXPECT_EQ(arm.tip(), "tip");
  EXPECT_EQ(arm.rest(), (JointVector{0, 0.3}));
  EXPECT_EQ(arm.hand().opening_max, 0.09);
  EXPECT_NEAR(arm.link_poses(arm.rest())[arm.link_index("finger")].t[1], 0.04, 1e-12);
}

TEST_F(ArmToml, ReadsBaxter) {
  const Arm read = read_arm(write("baxter.toml", "urdf = \"" + std::filesystem::canonical(kUrdfFile).string() + R"("
base = "base"
tip = "right_gripper"
[hand]
opening_min_m = 0.035
opening_max_m = 0.076666
finger_joints = ["r_gripper_l_finger_joint"]
finger_closed = 0
finger_open = 0.020833
[rest]
right_s1 = -0.55
right_e1 = 0.75
right_w1 = 1.26
left_s1 = -0.55
left_e1 = 0.75
left_w1 = 1.26
)"));
  const Arm baxter = Arm::baxter(Side::kRight);
  EXPECT_EQ(read.links(), baxter.links());
  const std::vector<Pose> a = read.link_poses(read.rest(), 0.05), b = baxter.link_poses(baxter.rest(), 0.05);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT(distance(a[i], b[i]), 1e-9) << read.links()[i];
  EXPECT_EQ(read.shapes().size(), baxter.shapes().size());
}

TEST_F(ArmToml, MistakesAreOneClearLine) {
  EXPECT_MENTIONS(message_of([] { read_arm("no/such/arm.toml"); }), "no/such/arm.toml: cannot be read");
  EXPECT_MENTIONS(error_of("urdf = \n"), "line 1: ");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "base = \"base\"\n", "")), "'base' is missing");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "tip = \"tip\"", "tip = 3")), "'tip' must be a string");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "tip =", "tips =")), "unknown key 'tips'; known are urdf, base, tip");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "opening_min_m", "opening_min")), "unknown key 'hand.opening_min'");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "opening_max_m = 0.09\n", "")), "'hand.opening_max_m' is missing");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "0.09", "\"wide\"")), "'hand.opening_max_m' must be a number");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "[\"pinch\"]", "\"pinch\"")), "'hand.finger_joints' must be a list");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "[\"pinch\"]", "[1]")), "'hand.finger_joints' must be a list");
  EXPECT_MENTIONS(error_of("hand = 3\n" + replaced(kSmallToml, "[hand]", "[rest]")), "line ");
  EXPECT_MENTIONS(error_of("urdf = \"small.urdf\"\nbase = \"base\"\ntip = \"tip\"\n"), "'hand' is missing");
  EXPECT_MENTIONS(error_of("urdf = \"small.urdf\"\nbase = \"base\"\ntip = \"tip\"\nhand = 1\n"),
                  "'hand' must be a table");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "raise = 0.3", "raise = \"up\"")), "'rest.raise' must be a number");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "raise", "rise")), "there is no joint 'rise'");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "\"small.urdf\"", "\"large.urdf\"")), "'urdf': '");
  EXPECT_MENTIONS(error_of(replaced(kSmallToml, "\"tip\"", "\"top\"")), "there is no link 'top'");
}

}  // namespace
}  // namespace handhold::plan
