// handhold plan: its JSON, table and picture, and what it refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "process.h"
#include "refusal.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

/// Before Baxter, looking ahead: the cylinder stands at (0.75, -0.25, 0.15) of its base.
const Words kPose = {"--camera-pose", "0.05", "-0.2", "0.15", "-0.5", "0.5", "-0.5", "0.5"};

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
Words keys(const Json& json) {
  Words names;
  for (const auto& [key, value] : json.items()) names.push_back(key);
  return names;
}

/// Three slides, three turns and two fingers: data enough for --arm-file.
const char* const kUrdf = R"(<robot name="slides">
<link name="floor"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/><link name="f"/>
<link name="hand"/><link name="left"/><link name="right"/>
<joint name="x" type="prismatic"><parent link="floor"/><child link="a"/><axis xyz="1 0 0"/>
 <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="y" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
 <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="z" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
 <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="yaw" type="revolute"><parent link="c"/><child link="d"/><axis xyz="0 0 1"/>
 <limit lower="-3.5" upper="3.5" effort="1" velocity="1"/></joint>
<joint name="pitch" type="revolute"><parent link="d"/><child link="e"/><axis xyz="0 1 0"/>
 <limit lower="-3.5" upper="3.5" effort="1" velocity="1"/></joint>
<joint name="roll" type="revolute"><parent link="e"/><child link="f"/><axis xyz="1 0 0"/>
 <limit lower="-3.5" upper="3.5" effort="1" velocity="1"/></joint>
<joint name="mounting" type="fixed"><parent link="f"/><child link="hand"/>
 <origin xyz="0.1 0 0" rpy="0 1.5707963267948966 0"/></joint>
<joint name="l" type="prismatic"><parent link="hand"/><child link="left"/><axis xyz="0 1 0"/>
 <limit lower="0" upper="0.04" effort="1" velocity="1"/></joint>
<joint name="r" type="prismatic"><parent link="hand"/><child link="right"/><axis xyz="0 -1 0"/>
 <limit lower="0" upper="0.04" effort="1" velocity="1"/></joint>
</robot>)";
const char* const kArm = R"(urdf = "slides.urdf"
base = "floor"
tip = "hand"
[hand]
opening_min_m = 0.0
opening_max_m = 0.08
finger_joints = ["l", "r"]
)";

class PlanCommand : public ::testing::Test {
 protected:
  PlanCommand() { folder_.write("cloud.pcd", binary_pcd(cylinder())); }

  Outcome plan(const Words& arguments) { return run_program(Words{"plan"} + arguments, folder_.path()); }
  std::string output(const Words& arguments) {
    const Outcome done = plan(arguments);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_EQ(done.err, "");
    return done.out;
  }
  Json json(const Words& arguments) { return Json::parse(output(arguments + Words{"--json", "-"})); }

  /// One line of error with all of `parts` in it, and nothing written.
  void expect_refusal(const Words& words, int exit_code, const Words& parts) {
    expect_one_line_refusal(
        folder_, [&](const Words& w) { return plan(w); }, words, exit_code, parts);
  }
  /// With a cloud and a pose that are right.
  void expect_refused(const Words& words, const Words& parts, int exit_code = 2) {
    expect_refusal(Words{"cloud.pcd", "--json", "out.json"} + kPose + words, exit_code, parts);
  }

  Folder folder_;
};

void expect_rigid(const Json& T) {
  ASSERT_EQ(T.size(), 4u);
  for (const Json& row : T) ASSERT_EQ(row.size(), 4u);
  EXPECT_EQ(T[3], Json::parse("[0.0, 0.0, 0.0, 1.0]"));
  const auto at = [&](int r, int c) { return T[r][c].get<double>(); };
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += at(k, i) * at(k, j);
      EXPECT_NEAR(sum, i == j ? 1 : 0, 1e-9);
    }
  }
  EXPECT_NEAR(at(0, 0) * (at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)) -
                  at(0, 1) * (at(1, 0) * at(2, 2) - at(1, 2) * at(2, 0)) +
                  at(0, 2) * (at(1, 0) * at(2, 1) - at(1, 1) * at(2, 0)),
              1, 1e-9);
}

/// Of a path and its times, both of that length, joints and all.
void expect_path(const Json& path, const Json& times, std::size_t joints) {
  ASSERT_GE(path.size(), 2u);
  ASSERT_EQ(path.size(), times.size());
  EXPECT_EQ(times[0], 0.0);
  for (std::size_t i = 0; i < path.size(); ++i) {
    ASSERT_EQ(path[i].size(), joints);
    for (const Json& q : path[i]) EXPECT_TRUE(q.is_number_float());
    if (i > 0) {
      EXPECT_GT(times[i].get<double>(), times[i - 1].get<double>());
    }
  }
}

void expect_grasp(const Json& grasp, std::size_t joints) {
  EXPECT_EQ(keys(grasp),
            (Words{"handle", "arm", "frame", "pregrasp", "grasp", "lift", "opening", "width", "approach", "angle",
                   "tilt", "flipped", "pregrasp_index", "path", "times", "lift_path", "lift_times"}));
  for (const char* pose : {"pregrasp", "grasp", "lift"}) expect_rigid(grasp[pose]);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(grasp["approach"][k].get<double>(), grasp["grasp"][k][2].get<double>(), 1e-12) << "the hand's z";
    const double lift = grasp["lift"][k][3].get<double>() - grasp["grasp"][k][3].get<double>();
    EXPECT_NEAR(lift, k == 2 ? 0.15 : 0, 1e-9);
  }
  EXPECT_GT(grasp["opening"].get<double>(), grasp["width"].get<double>());
  EXPECT_LT(grasp["pregrasp_index"].get<std::size_t>(), grasp["path"].size());
  expect_path(grasp["path"], grasp["times"], joints);
  expect_path(grasp["lift_path"], grasp["lift_times"], joints);
  EXPECT_EQ(grasp["path"].back(), grasp["lift_path"][0]);
}

TEST_F(PlanCommand, JsonHasTheSchemaThatOtherProgramsRead) {
  const Json plan = json(Words{"cloud.pcd", "--arm", "right"} + kPose);
  EXPECT_EQ(keys(plan), (Words{"schema", "base", "joints", "grasps", "rejected", "handles"}));
  EXPECT_EQ(plan["schema"], "handhold.plan/1");
  EXPECT_EQ(plan["base"], "base");
  EXPECT_EQ(plan["joints"], Json::parse(R"(["right_s0", "right_s1", "right_e0", "right_e1", "right_w0", "right_w1",
                                            "right_w2"])"));
  ASSERT_EQ(plan["handles"].size(), 1u);
  ASSERT_EQ(plan["grasps"].size(), 1u);
  EXPECT_TRUE(plan["rejected"].empty());
  const Json& grasp = plan["grasps"][0];
  expect_grasp(grasp, 7);
  EXPECT_EQ(grasp["handle"], 0);
  EXPECT_EQ(grasp["arm"], "right");
  EXPECT_EQ(grasp["frame"], "right_gripper");
  // At the cylinder, in the robot's frame.
  EXPECT_NEAR(grasp["grasp"][0][3].get<double>(), 0.05 + kCylinderCenter[2], 0.02);
  EXPECT_NEAR(grasp["grasp"][1][3].get<double>(), -0.2 - kCylinderCenter[0], 0.02);
  EXPECT_NEAR(grasp["width"].get<double>(), 2 * kCylinderRadius, 0.004);
}

TEST_F(PlanCommand, TheOtherArm) {
  const Json plan =
      json({"cloud.pcd", "--arm", "left", "--camera-pose", "0.05", "0.3", "0.15", "-0.5", "0.5", "-0.5", "0.5"});
  EXPECT_EQ(plan["joints"][0], "left_s0");
  ASSERT_EQ(plan["grasps"].size(), 1u);
  expect_grasp(plan["grasps"][0], 7);
  EXPECT_EQ(plan["grasps"][0]["arm"], "left");
  EXPECT_EQ(plan["grasps"][0]["frame"], "left_gripper");
}

TEST_F(PlanCommand, WhatIsRejectedHasItsReason) {
  // 3 m away.
  Json plan = json({"cloud.pcd", "--camera-pose", "3", "-0.2", "0.15", "-0.5", "0.5", "-0.5", "0.5"});
  EXPECT_TRUE(plan["grasps"].empty());
  ASSERT_EQ(plan["rejected"].size(), 1u);
  EXPECT_EQ(keys(plan["rejected"][0]), (Words{"handle", "reason", "what", "counts"}));
  EXPECT_EQ(plan["rejected"][0]["handle"], 0);
  EXPECT_EQ(plan["rejected"][0]["reason"], "out of reach");
  EXPECT_EQ(keys(plan["rejected"][0]["counts"]), Words{"out of reach"});
  // A table that reaches up to the cylinder's top.
  plan = json(Words{"cloud.pcd", "--table", "0.3", "1.2", "-1", "1", "0.3"} + kPose);
  ASSERT_EQ(plan["rejected"].size(), 1u);
  EXPECT_EQ(plan["rejected"][0]["what"], "table");
  const std::string text = output(Words{"cloud.pcd", "--table", "0.3", "1.2", "-1", "1", "0.3"} + kPose);
  EXPECT_NE(text.find("1 rejected: "), std::string::npos) << text;
  EXPECT_NE(text.find("(table)"), std::string::npos) << text;
}

TEST_F(PlanCommand, AllListsEveryCandidate) {
  const Json few = json(Words{"cloud.pcd"} + kPose), all = json(Words{"cloud.pcd", "--all"} + kPose);
  EXPECT_EQ(keys(all), (Words{"schema", "base", "joints", "grasps", "rejected", "handles", "candidates"}));
  EXPECT_EQ(all["grasps"], few["grasps"]);
  EXPECT_GE(all["candidates"].size(), 2u * 12);
  std::size_t good = 0;
  for (const Json& candidate : all["candidates"]) {
    EXPECT_EQ(keys(candidate), (Words{"handle", "place", "angle", "tilt", "flipped", "reason", "what"}));
    good += candidate["reason"].is_null();
  }
  EXPECT_GT(good, 0u);
}

TEST_F(PlanCommand, AsManyGraspsAsAskedFor) {
  // Two cylinders, side by side.
  Points points = cylinder();
  for (const auto& p : cylinder()) points.push_back({p[0] - 0.2f, p[1], p[2]});
  folder_.write("two.pcd", binary_pcd(points));
  EXPECT_EQ(json(Words{"two.pcd"} + kPose)["grasps"].size(), 2u);
  const Json one = json(Words{"two.pcd", "--grasps", "1"} + kPose);
  ASSERT_EQ(one["grasps"].size(), 1u);
  EXPECT_TRUE(one["rejected"].empty()) << "the other one was not looked at";
  // The right arm's mount is nearer to the one on the right; the picture's x runs to the right.
  const Json& handle = one["handles"][one["grasps"][0]["handle"].get<std::size_t>()];
  EXPECT_GT(handle["center"][0].get<double>(), -0.05);
}

TEST_F(PlanCommand, WithoutJsonThereIsATable) {
  const std::string text = output(Words{"cloud.pcd"} + kPose);
  EXPECT_EQ(text.rfind("grasps of right_gripper in base:\n", 0), 0u) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
}

TEST_F(PlanCommand, FilesForJsonAndPicture) {
  EXPECT_EQ(output(Words{"cloud.pcd", "--json", "out.json", "--picture", "out.png"} + kPose), "");
  EXPECT_EQ(folder_.entries(), (Words{"cloud.pcd", "out.json", "out.png"}));
  EXPECT_EQ(Json::parse(folder_.read("out.json")), json(Words{"cloud.pcd"} + kPose));
  const std::string with = folder_.read("out.png");
  EXPECT_EQ(with.substr(1, 3), "PNG");
  // The hand is in it: out of reach there is none, all else is the same.
  output({"cloud.pcd", "--picture", "none.png", "--camera-pose", "9", "0", "0", "-0.5", "0.5", "-0.5", "0.5"});
  EXPECT_NE(folder_.read("none.png"), with);
}

TEST_F(PlanCommand, AnotherArmFromAFile) {
  folder_.write("slides.urdf", kUrdf);
  folder_.write("slides.toml", kArm);
  const Json plan = json(Words{"cloud.pcd", "--arm-file", "slides.toml"} + kPose);
  EXPECT_EQ(plan["base"], "floor");
  EXPECT_EQ(plan["joints"], Json::parse(R"(["x", "y", "z", "yaw", "pitch", "roll"])"));
  ASSERT_EQ(plan["grasps"].size(), 1u);
  expect_grasp(plan["grasps"][0], 6);
  EXPECT_EQ(plan["grasps"][0]["arm"], "slides.toml");
  EXPECT_EQ(plan["grasps"][0]["frame"], "hand");
  const Words there = {"--start", "0.1", "0.2", "-0.1", "0", "0.5", "0"};
  const Json from_there = json(Words{"cloud.pcd", "--arm-file", "slides.toml"} + there + kPose);
  EXPECT_EQ(from_there["grasps"][0]["path"][0], Json::parse("[0.1, 0.2, -0.1, 0.0, 0.5, 0.0]"));

  expect_refused({"--arm-file", "slides.toml", "--arm", "left"}, {"--arm ", "--arm-file"});
  expect_refused({"--arm-file", "slides.toml", "--slot", "2"}, {"--slot", "--arm-file"});
  expect_refused({"--arm-file", "slides.toml", "--start", "0", "0"}, {"--start", "6 numbers"});
  expect_refused({"--arm-file", "slides.toml", "--start", "2", "0", "0", "0", "0", "0"}, {"--start", "'x'", "1.0"});
  expect_refused({"--arm-file", "none.toml"}, {"none.toml"}, 1);
  folder_.write("bad.toml", std::string(kArm) + "opening = 3\n");
  expect_refused({"--arm-file", "bad.toml"}, {"bad.toml", "opening"}, 1);
  folder_.write("lost.toml", "urdf = \"none.urdf\"\n" + std::string(kArm).substr(std::string(kArm).find("base")));
  expect_refused({"--arm-file", "lost.toml"}, {"none.urdf"}, 1);
}

TEST_F(PlanCommand, HelpNamesItsFlags) {
  const std::string help = output({"--help"});
  for (const char* flag : {"--arm ", "--fingers", "--slot", "--tip", "--arm-file", "--start", "--camera-pose",
                           "--table", "--order", "--grasps", "--all", "--json", "--picture", "--html", "--depth"}) {
    EXPECT_NE(help.find(flag), std::string::npos) << flag;
  }
}

TEST_F(PlanCommand, WrongUse) {
  expect_refusal({"cloud.pcd"}, 2, {"--camera-pose", "X Y Z"});
  expect_refusal({"cloud.pcd", "--camera-pose", "0", "0", "0"}, 2, {"--camera-pose", "seven numbers"});
  expect_refusal({"cloud.pcd", "--camera-pose", "0", "0", "0", "0", "0", "0", "1", "1"}, 2, {"seven numbers"});
  expect_refusal({"cloud.pcd", "--camera-pose", "0", "0", "0", "0", "0", "0", "0"}, 2, {"unit quaternion"});
  expect_refusal({"cloud.pcd", "--camera-pose", "0", "0", "0", "1", "1", "0", "0"}, 2, {"unit quaternion"});
  expect_refusal({"cloud.pcd", "--camera-pose", "0", "0", "nan", "0", "0", "0", "1"}, 2, {"--camera-pose"});
  expect_refusal({"cloud.pcd", "--camera-pose", "0", "0", "1e300", "0", "0", "0", "1"}, 2, {"--camera-pose"});
  expect_refusal({"cloud.pcd", "--camera-pose", "here"}, 2, {"--camera-pose", "here"});
  expect_refusal(kPose, 2, {"no cloud", "handhold plan"});
  expect_refused({"--arm", "middle"}, {"--arm", "'middle'", "right, left"});
  expect_refused({"--fingers", "long"}, {"--fingers", "'long'", "extended-narrow"});
  expect_refused({"--tip", "sharp"}, {"--tip", "'sharp'", "half-round"});
  expect_refused({"--order", "best"}, {"--order", "'best'", "nearest, confidence, highest"});
  for (const char* slot : {"0", "5", "-1", "1.5", "three"})
    expect_refused({"--slot", slot}, {"--slot", slot, "1 to 4"});
  for (const char* count : {"-1", "1.5", "many"}) expect_refused({"--grasps", count}, {"--grasps", count});
  expect_refused({"--start", "0", "0", "0"}, {"--start", "7 numbers"});
  expect_refused({"--start", "0", "2", "0", "1", "0", "0", "0"}, {"--start", "right_s1", "1.047"});
  expect_refused({"--table", "1", "0", "0", "1", "0"}, {"--table", "XMIN"});
  expect_refused({"--table", "0", "1", "1", "1", "0"}, {"--table", "YMIN"});
  expect_refused({"--table", "0", "1", "0", "1"}, {"--table", "five numbers"});
  expect_refused({"--picture", "-"}, {"--picture", "standard output"});
  expect_refused({"--picture", "cloud.pcd"}, {"--picture", "overwrite", "cloud.pcd"});
  expect_refused({"--picture", "out.json"}, {"--json", "--picture", "out.json"});
  expect_refused({"--samples", "0"}, {"--samples"});
  expect_refused({"--grasp", "1"}, {"--grasp", "--grasps"});
  expect_refused({"other.pcd"}, {"other.pcd"});
}

TEST_F(PlanCommand, BadFiles) {
  expect_refusal(Words{"none.pcd"} + kPose, 1, {"none.pcd"});
  expect_refusal(Words{"."} + kPose, 1, {"cannot read ."});
  folder_.write("empty.pcd", ascii_pcd({}));
  expect_refusal(Words{"empty.pcd"} + kPose, 1, {"empty.pcd", "no points"});
  folder_.write("few.pcd", ascii_pcd(Points(5, {0, 0, 1})));
  expect_refusal(Words{"few.pcd"} + kPose, 1, {"few.pcd", "only 5"});
  expect_refused({"--picture", "none/out.png"}, {"none/out.png"}, 1);
  expect_refusal(Words{"cloud.pcd", "--json", "none/out.json"} + kPose, 1, {"none/out.json"});
}

}  // namespace
}  // namespace handhold::test
