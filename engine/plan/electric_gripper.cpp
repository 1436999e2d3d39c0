// Baxter's electric gripper, and Baxter's URDF with it.
#include <algorithm>
#include <cstdio>
#include <initializer_list>
#include <stdexcept>
#include <string>

#include "baxter_urdf.h"
#include "handhold/arm.h"

namespace handhold::plan {
namespace {

constexpr double kStroke = 0.020833;    // m, of each finger
constexpr double kSlotPitch = 0.0095;   // m
constexpr double kFirstSlot = -0.011;   // m, of the left finger: slot 1 starts beyond the middle
constexpr double kFingerMass = 0.02;    // kg
constexpr double kTipMass = 0.01;       // kg
constexpr double kTipInwards = 0.0045;  // m, from the tip's frame to its body
constexpr double kFingerX = 0.01;       // m, edges of the box of a finger, which is as high as it is long
constexpr double kFingerY = 0.0135;
constexpr double kHalfRoundRadius = 0.008;  // m
constexpr double kTipLength = 0.037;        // m

struct FingerShape {
  double length;  // m
  double width;   // m, from the joint's frame outwards to finger and tip
  double middle;  // m, height of the box's centre
};

FingerShape shape_of(ElectricGripper::Finger finger) {
  using Finger = ElectricGripper::Finger;
  const bool is_extended = finger == Finger::kExtendedNarrow || finger == Finger::kExtendedWide;
  const bool is_wide = finger == Finger::kStandardWide || finger == Finger::kExtendedWide;
  return {is_extended ? 0.1127 : 0.075, is_wide ? 0.05503 : 0.01725, is_extended ? 0.0615 : 0.04};
}

/// Edges of the tip (m); the half round one's are those about its cylinder.
Vector3 size_of(ElectricGripper::Tip tip) {
  switch (tip) {
    case ElectricGripper::Tip::kHard:
      return {0.016, 0.0065, kTipLength};
    case ElectricGripper::Tip::kSoft:
      return {0.016, 0.007, kTipLength};
    case ElectricGripper::Tip::kPaddle:
      return {0.042, 0.0065, kTipLength};
    case ElectricGripper::Tip::kHalfRound:
      return {2 * kHalfRoundRadius, 2 * kHalfRoundRadius, kTipLength};
  }
  return {};
}

double slot_offset(const ElectricGripper& gripper) {
  return kFirstSlot + (gripper.slot - 1) * kSlotPitch;
}

void check(const ElectricGripper& gripper) {
  if (gripper.slot < 1 || gripper.slot > 4) {
    throw std::invalid_argument("slot " + std::to_string(gripper.slot) +
                                " of the electric gripper: must be 1, 2, 3 or 4");
  }
}

// ---- URDF -----------------------------------------------------------------------------------------------------------

std::string text_of(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", value);
  return digits;
}
std::string text_of(const Vector3& v) {
  return text_of(v[0]) + " " + text_of(v[1]) + " " + text_of(v[2]);
}

/// Lines of one link, a body of uniform density.
std::string link_text(const std::string& name, double mass, const Vector3& center, const Vector3& inertia,
                      const std::string& geometry, const std::string& rpy = "") {
  const std::string origin = "      <origin xyz=\"" + text_of(center) + "\"" + rpy + "/>\n";
  return "  <link name=\"" + name + "\">\n    <inertial>\n      <origin xyz=\"" + text_of(center) + "\"/>\n" +
         "      <mass value=\"" + text_of(mass) + "\"/>\n      <inertia ixx=\"" + text_of(inertia[0]) +
         "\" ixy=\"0\" ixz=\"0\" iyy=\"" + text_of(inertia[1]) + "\" iyz=\"0\" izz=\"" + text_of(inertia[2]) +
         "\"/>\n    </inertial>\n    <collision>\n" + origin + "      <geometry>" + geometry +
         "</geometry>\n    </collision>\n  </link>\n";
}
std::string box_link(const std::string& name, double mass, const Vector3& center, const Vector3& size) {
  const double x = size[0] * size[0], y = size[1] * size[1], z = size[2] * size[2];
  return link_text(name, mass, center, {mass * (y + z) / 12, mass * (x + z) / 12, mass * (x + y) / 12},
                   "<box size=\"" + text_of(size) + "\"/>");
}
std::string cylinder_text(double radius, double length) {
  return "<cylinder radius=\"" + text_of(radius) + "\" length=\"" + text_of(length) + "\"/>";
}
double about_axis(double mass, double radius) {
  return mass * radius * radius / 2;
}
double across_axis(double mass, double radius, double length) {
  return mass * (3 * radius * radius + length * length) / 12;
}

std::string joint_text(const std::string& name, const std::string& type, const std::string& parent,
                       const std::string& child, const Vector3& offset, const std::string& more = "") {
  return "  <joint name=\"" + name + "\" type=\"" + type + "\">\n    <parent link=\"" + parent +
         "\"/>\n    <child link=\"" + child + "\"/>\n    <origin xyz=\"" + text_of(offset) + "\"/>\n" + more +
         "  </joint>\n";
}

std::string tip_link(const std::string& name, ElectricGripper::Tip tip, double outwards) {
  const Vector3 center = {0, -outwards * kTipInwards, -0.015};
  if (tip != ElectricGripper::Tip::kHalfRound) return box_link(name, kTipMass, center, size_of(tip));
  const double across = across_axis(kTipMass, kHalfRoundRadius, kTipLength);
  return link_text(name, kTipMass, center, {across, across, about_axis(kTipMass, kHalfRoundRadius)},
                   cylinder_text(kHalfRoundRadius, kTipLength));
}

/// One finger with its tip. @param prefix  "r_gripper" @param outwards  1: left finger, -1: right one
std::string finger_text(const ElectricGripper& gripper, const std::string& base, const std::string& prefix,
                        int outwards) {
  const FingerShape shape = shape_of(gripper.finger);
  const std::string link = prefix + (outwards > 0 ? "_l_finger" : "_r_finger");
  const std::string limits = outwards > 0 ? "lower=\"0\" upper=\"" + text_of(kStroke) + "\""
                                          : "lower=\"" + text_of(-kStroke) + "\" upper=\"0\"";
  std::string motion = "    <axis xyz=\"0 1 0\"/>\n    <limit " + limits + " velocity=\"5\" effort=\"20\"/>\n";
  if (outwards < 0) motion += "    <mimic joint=\"" + prefix + "_l_finger_joint\" multiplier=\"-1\"/>\n";
  motion += "    <dynamics damping=\"0.7\" friction=\"0\"/>\n";

  return box_link(link, kFingerMass, {0, outwards * shape.width, shape.middle}, {kFingerX, kFingerY, shape.length}) +
         tip_link(link + "_tip", gripper.tip, outwards) +
         joint_text(link + "_joint", "prismatic", base, link, {0, outwards * slot_offset(gripper), 0.02}, motion) +
         joint_text(link + "_tip_joint", "fixed", link, link + "_tip", {0, outwards * shape.width, shape.length});
}

std::string gripper_text(const ElectricGripper& gripper, const std::string& side) {
  const std::string hand = side + "_hand", base = side + "_gripper_base", endpoint = side + "_gripper";
  const std::string prefix = side.substr(0, 1) + "_gripper";
  constexpr double kMass = 0.3, kRadius = 0.029, kLength = 0.1;
  const double across = across_axis(kMass, kRadius, kLength);
  // The housing lies across the fingers: its axis is y.
  return link_text(base, kMass, {0, 0, 0}, {across, about_axis(kMass, kRadius), across},
                   cylinder_text(kRadius, kLength), " rpy=\"-1.57079632679 3.14159265359 0\"") +
         "  <link name=\"" + endpoint + "\"/>\n" + joint_text(base, "fixed", hand, base, {0, 0, 0.025}) +
         joint_text(endpoint, "fixed", base, endpoint, {0, 0, gripper.endpoint_offset()}) +
         finger_text(gripper, base, prefix, 1) + finger_text(gripper, base, prefix, -1);
}

/// Replaces what stands between the comments about one side's gripper.
void replace_gripper(std::string& urdf, const ElectricGripper& gripper, const std::string& side) {
  const std::string first = "  <!-- The " + side + " gripper -->\n",
                    last = "  <!-- End of the " + side + " gripper -->\n";
  const std::size_t begin = urdf.find(first) + first.size();
  urdf.replace(begin, urdf.find(last) - begin, gripper_text(gripper, side));
}

}  // namespace

double ElectricGripper::finger_length() const {
  return shape_of(finger).length;
}

double ElectricGripper::endpoint_offset() const {
  return finger_length() + 0.02;
}

double ElectricGripper::opening_closed() const {
  return 2 * (slot_offset(*this) + shape_of(finger).width - kTipInwards - size_of(tip)[1] / 2);
}

double ElectricGripper::opening_open() const {
  return opening_closed() + 2 * kStroke;
}

Hand ElectricGripper::hand(Side side) const {
  check(*this);
  Hand hand;
  hand.opening_min = std::max(0.0, opening_closed());
  hand.opening_max = opening_open();
  hand.finger_joints = {side == Side::kRight ? "r_gripper_l_finger_joint" : "l_gripper_l_finger_joint"};
  hand.finger_closed = (hand.opening_min - opening_closed()) / 2;
  hand.finger_open = kStroke;
  return hand;
}

std::string baxter_urdf(const ElectricGripper& gripper) {
  check(gripper);
  std::string urdf = kBaxterUrdf;
  for (const char* side : {"right", "left"}) replace_gripper(urdf, gripper, side);
  return urdf;
}

}  // namespace handhold::plan
