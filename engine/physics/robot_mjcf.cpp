// The robot, from its URDF.
#include <urdf_model/model.h>

#include <set>

#include "mjcf.h"
#include "urdf.h"
#include "vec.h"

namespace handhold::physics {
namespace {

/// A motor: a spring to the position asked for and a damper to the velocity asked for, of limited force.
struct Gains {
  double spring;   // N m/rad, N/m
  double damper;   // N m s/rad, N s/m
  double inertia;  // kg m^2, kg; of the motor itself, seen through its gears
};
// Springs hold 1 kg at the end of a stretched arm to within 0.003 rad; dampers are about critical for the arm's own
// inertia. The motors' inertias are assumptions.
constexpr Gains kShoulder = {6000, 250, 0.5}, kWrist = {2000, 25, 0.05}, kFinger = {2000, 20, 0.05};
constexpr double kStrong = 20;  // N m; joints with more effort than this belong to the shoulder and elbow

std::string text_of_urdf(const urdf::Vector3& v) {
  return text_of(Vector3{v.x, v.y, v.z});
}
std::string place_text(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  return " pos=\"" + text_of_urdf(pose.position) + "\" quat=\"" + text_of(q.w) + " " + text_of(Vector3{q.x, q.y, q.z}) +
         "\"";
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

class RobotWriter {
 public:
  RobotWriter(const urdf::ModelInterface& robot, const WorldOptions& options, const plan::Arm& arm)
      : robot_(robot), options_(options), arm_(arm), T_base_link_(arm.link_poses(arm.rest())) {
    for (const plan::Joint& joint : arm.joints()) moving_.insert(joint.name);
    const FingerJoints fingers = finger_joints(options.side);
    moving_.insert(fingers.moved);
    moving_.insert(fingers.mimic);
  }

  RobotText write() {
    add_link(*robot_.getRoot(), false);
    for (const plan::Joint& joint : arm_.joints()) {
      const urdf::Joint& published = *robot_.getJoint(joint.name);
      add_motor(joint.name, gains_of(published), published.limits->effort);
    }
    const FingerJoints fingers = finger_joints(options_.side);
    for (const std::string& name : {fingers.moved, fingers.mimic}) add_motor(name, kFinger, options_.grip_force);
    text_.equalities = "    <joint joint1=\"" + fingers.moved + "\" joint2=\"" + fingers.mimic +
                       "\" polycoef=\"0 -1 0 0 0\" solref=\"0.004 1\"/>\n";
    return text_;
  }

 private:
  /// @param carried  by a joint that moves
  void add_link(const urdf::Link& link, bool carried) {
    const urdf::JointSharedPtr joint = link.parent_joint;
    const bool moves = joint && moving_.count(joint->name);
    carried |= moves;
    text_.bodies += "    <body name=\"" + link.name + "\"" + place_of(link, moves) + ">\n";
    if (moves) add_joint(*joint);
    if (carried && link.inertial) add_inertia(*link.inertial);
    for (const urdf::CollisionSharedPtr& collision : link.collision_array) add_geom(link.name, *collision);
    for (const urdf::LinkSharedPtr& child : link.child_links) add_link(*child, carried);
    text_.bodies += "    </body>\n";
  }

  /// What no joint moves stands as it does at the arm's rest.
  std::string place_of(const urdf::Link& link, bool moves) const {
    if (moves) return place_text(link.parent_joint->parent_to_joint_origin_transform);
    const Pose& T_base_link = T_base_link_[arm_.link_index(link.name)];
    if (!link.getParent()) return physics::place_text(T_base_link);
    return physics::place_text(T_base_link_[arm_.link_index(link.getParent()->name)].inverse() * T_base_link);
  }

  void add_joint(const urdf::Joint& joint) {
    const bool slides = joint.type == urdf::Joint::PRISMATIC;
    const Gains& gains = gains_of(joint);
    text_.bodies += "      <joint name=\"" + joint.name + "\" type=\"" + (slides ? "slide" : "hinge") + "\" axis=\"" +
                    text_of_urdf(joint.axis) + "\" range=\"" + text_of(joint.limits->lower) + " " +
                    text_of(joint.limits->upper) + "\" armature=\"" + text_of(gains.inertia) + "\" damping=\"" +
                    text_of(joint.dynamics ? joint.dynamics->damping : 0) + "\"/>\n";
  }
  static const Gains& gains_of(const urdf::Joint& joint) {
    if (joint.type == urdf::Joint::PRISMATIC) return kFinger;
    return joint.limits->effort > kStrong ? kShoulder : kWrist;
  }

  /// Inertias are given in the link's axes about its centre of mass: Baxter's inertial frames are not turned.
  void add_inertia(const urdf::Inertial& inertial) {
    text_.bodies += "      <inertial pos=\"" + text_of_urdf(inertial.origin.position) + "\" mass=\"" +
                    text_of(inertial.mass) + "\" fullinertia=\"" +
                    text_of(Vector3{inertial.ixx, inertial.iyy, inertial.izz}) + " " +
                    text_of(Vector3{inertial.ixy, inertial.ixz, inertial.iyz}) + "\"/>\n";
  }

  void add_geom(const std::string& link, const urdf::Collision& collision) {
    std::string shape;
    const urdf::Geometry* geometry = collision.geometry.get();
    if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(geometry)) {
      shape = "cylinder\" size=\"" + text_of(cylinder->radius) + " " + text_of(cylinder->length / 2);
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(geometry)) {
      shape = "sphere\" size=\"" + text_of(sphere->radius);
    } else if (const auto* box = dynamic_cast<const urdf::Box*>(geometry)) {
      shape = "box\" size=\"" + text_of(0.5 * Vector3{box->dim.x, box->dim.y, box->dim.z});
    } else {
      return;
    }
    text_.bodies += "      <geom class=\"" + std::string(ends_with(link, "finger_tip") ? "tip" : "link") +
                    "\" type=\"" + shape + "\"" + place_text(collision.origin) + "/>\n";
  }

  void add_motor(const std::string& joint, const Gains& gains, double effort) {
    text_.motors += "    <general name=\"" + joint + "\" joint=\"" + joint + "\" gainprm=\"" + text_of(gains.spring) +
                    "\" biastype=\"affine\" biasprm=\"" + text_of(Vector3{0, -gains.spring, -gains.damper}) +
                    "\" forcerange=\"" + text_of(-effort) + " " + text_of(effort) + "\"/>\n";
  }

  const urdf::ModelInterface& robot_;
  const WorldOptions& options_;
  const plan::Arm& arm_;
  const std::vector<Pose> T_base_link_;
  std::set<std::string> moving_;
  RobotText text_;
};

}  // namespace

FingerJoints finger_joints(plan::Side side) {
  const std::string prefix = side == plan::Side::kRight ? "r_gripper_" : "l_gripper_";
  return {prefix + "l_finger_joint", prefix + "r_finger_joint"};
}

double full_force_travel(const WorldOptions& options) {
  return options.grip_force / kFinger.spring;
}

RobotText robot_text(const WorldOptions& options, const plan::Arm& arm) {
  const urdf::ModelInterfaceSharedPtr robot = plan::parse_urdf(plan::baxter_urdf(options.gripper));
  return RobotWriter(*robot, options, arm).write();
}

}  // namespace handhold::physics
