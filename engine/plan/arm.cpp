// An arm from its URDF, and its forward kinematics.
#include "handhold/arm.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <urdf_model/model.h>
#include "model.h"

#include "urdf.h"
#include "vec3.h"

namespace handhold::plan {

KDL::Frame to_kdl(const Pose& pose) {
  const auto& R = pose.R;
  return {KDL::Rotation(R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8]),
          KDL::Vector(pose.t[0], pose.t[1], pose.t[2])};
}

Pose from_kdl(const KDL::Frame& frame) {
  Pose pose;
  std::copy(frame.M.data, frame.M.data + 9, pose.R.begin());
  std::copy(frame.p.data, frame.p.data + 3, pose.t.begin());
  return pose;
}

namespace {

[[noreturn]] void fail(const std::string& message) {
  throw std::invalid_argument(message);
}

// ---- From the URDF --------------------------------------------------------------------------------------------------

KDL::Vector to_kdl(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}
KDL::Frame to_kdl(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  return {KDL::Rotation::Quaternion(q.x, q.y, q.z, q.w), to_kdl(pose.position)};
}

bool is_angle(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
}
bool moves(const urdf::Joint& joint) {
  return is_angle(joint) || joint.type == urdf::Joint::PRISMATIC;
}

Mount mount_of(const urdf::Joint& joint) {
  Mount mount;
  mount.T_parent_zero = to_kdl(joint.parent_to_joint_origin_transform);
  if (!moves(joint)) return mount;
  mount.motion = is_angle(joint) ? Mount::Motion::kTurn : Mount::Motion::kSlide;
  mount.axis = to_kdl(joint.axis);
  const double length = mount.axis.Norm();
  if (!(length > 0)) fail("joint '" + joint.name + "': its axis is zero; give a direction");
  mount.axis = mount.axis / length;
  return mount;
}

/// The position of a joint that nothing moves.
double rest_position(const urdf::Joint& joint, const Posture& rest) {
  const auto named = rest.find(joint.name);
  if (!joint.limits || joint.type == urdf::Joint::CONTINUOUS) return named == rest.end() ? 0 : named->second;
  const double lower = joint.limits->lower, upper = joint.limits->upper;
  if (named == rest.end()) return std::min(std::max(0.0, lower), upper);
  if (!(named->second >= lower && named->second <= upper)) {
    fail("rest of joint '" + joint.name + "': " + std::to_string(named->second) + " is beyond its limits");
  }
  return named->second;
}

Joint checked_joint(const urdf::Joint& joint) {
  if (!moves(joint)) fail("joint '" + joint.name + "' is floating or planar: an arm has revolute and prismatic joints");
  if (joint.mimic) fail("joint '" + joint.name + "' mimics another: the arm's own joints move by themselves");
  if (!joint.limits || joint.type == urdf::Joint::CONTINUOUS) {
    fail("joint '" + joint.name + "' has no limits; make it a revolute joint with a <limit>");
  }
  const urdf::JointLimits& limits = *joint.limits;
  if (!(limits.lower < limits.upper) || !std::isfinite(limits.upper - limits.lower)) {
    fail("joint '" + joint.name + "' has no range: its lower limit must be below its upper one");
  }
  return {joint.name, !is_angle(joint), limits.lower, limits.upper, limits.velocity};
}

/// How far (m) a shape's farthest point is from its own origin.
double extent_of(const Shape& shape) {
  return shape.kind == Shape::Kind::kBox ? norm(shape.size) / 2 : shape.radius + shape.length / 2;
}

/// Builds an arm's model step by step.
class Builder {
 public:
  Builder(const urdf::ModelInterface& robot, ArmModel& model, const Posture& rest)
      : robot_(robot), model_(model), rest_(rest) {}

  void build() {
    for (const auto& [name, position] : rest_) joint_named(name, "rest");
    make_chain();
    check_hand();
    add_link(*robot_.getRoot(), 0, 0);
    model_.base_link = static_cast<std::size_t>(
        std::find(model_.link_names.begin(), model_.link_names.end(), model_.base) - model_.link_names.begin());
    measure_reach();
    measure_sweeps();
  }

 private:
  const urdf::Joint& joint_named(const std::string& name, const std::string& what) const {
    const auto joint = robot_.getJoint(name);
    if (!joint) fail(what + ": there is no joint '" + name + "'");
    if (!moves(*joint)) fail(what + ": joint '" + name + "' does not move");
    return *joint;
  }

  void make_chain() {
    for (const std::string& name : {model_.base, model_.tip}) {
      if (!robot_.getLink(name)) fail("there is no link '" + name + "'");
    }
    std::vector<urdf::JointSharedPtr> joints;
    urdf::LinkConstSharedPtr link = robot_.getLink(model_.tip);
    for (; link && link->name != model_.base; link = link->getParent()) {
      if (link->parent_joint) joints.push_back(link->parent_joint);
    }
    if (!link) fail("no chain from '" + model_.base + "' to '" + model_.tip + "': the tip does not hang on the base");
    std::reverse(joints.begin(), joints.end());
    for (const urdf::JointSharedPtr& joint : joints) {
      model_.mounts.push_back(mount_of(*joint));
      if (joint->type == urdf::Joint::FIXED) continue;
      model_.joints.push_back(checked_joint(*joint));
      model_.rest.push_back(rest_position(*joint, rest_));
    }
    if (model_.joints.empty()) fail("no joint moves between '" + model_.base + "' and '" + model_.tip + "'");
  }

  void check_hand() {
    Hand& hand = model_.hand;
    if (!(hand.opening_min >= 0 && hand.opening_min <= hand.opening_max && std::isfinite(hand.opening_max))) {
      fail("hand: opening_min must be from 0 to opening_max");
    }
    for (const std::string& name : hand.finger_joints) {
      const urdf::Joint& joint = joint_named(name, "hand");
      if (arm_joint(name) < model_.joints.size()) fail("hand: joint '" + name + "' is one of the arm's");
      if ((!joint.limits || joint.type == urdf::Joint::CONTINUOUS) && !(hand.finger_closed && hand.finger_open)) {
        fail("hand: joint '" + name + "' has no limits; give finger_closed and finger_open");
      }
    }
  }

  /// Index of one of the arm's joints; their number: it is none.
  std::size_t arm_joint(const std::string& name) const {
    const auto is_it = [&](const Joint& joint) { return joint.name == name; };
    return static_cast<std::size_t>(std::find_if(model_.joints.begin(), model_.joints.end(), is_it) -
                                    model_.joints.begin());
  }

  /// @param depth  of mimicking: a URDF can hold a circle
  Drive drive_of(const urdf::Joint& joint, int depth = 0) const {
    if (joint.mimic) {
      if (depth > 100) fail("joint '" + joint.name + "' mimics itself");
      Drive drive = drive_of(joint_named(joint.mimic->joint_name, "joint '" + joint.name + "' mimics"), depth + 1);
      drive.factor *= joint.mimic->multiplier;
      drive.offset = joint.mimic->multiplier * drive.offset + joint.mimic->offset;
      return drive;
    }
    if (const std::size_t index = arm_joint(joint.name); index < model_.joints.size()) {
      return {Drive::By::kArm, index, 1, 0};
    }
    const Hand& hand = model_.hand;
    if (std::count(hand.finger_joints.begin(), hand.finger_joints.end(), joint.name)) {
      const double closed = hand.finger_closed ? *hand.finger_closed : joint.limits->lower;
      const double open = hand.finger_open ? *hand.finger_open : joint.limits->upper;
      return {Drive::By::kHand, 0, open - closed, closed};
    }
    return {Drive::By::kNothing, 0, 0, moves(joint) ? rest_position(joint, rest_) : 0};
  }

  /// @param joints  of the arm, that move the parent
  void add_link(const urdf::Link& link, std::size_t parent, std::size_t joints) {
    const std::size_t index = model_.links.size();
    Link ours{link.name, parent, {}, {}};
    if (link.parent_joint) {
      ours.mount = mount_of(*link.parent_joint);
      ours.drive = drive_of(*link.parent_joint);
      if (ours.drive.by == Drive::By::kArm) ++joints;
    }
    model_.links.push_back(std::move(ours));
    model_.link_joints.push_back(joints);
    model_.link_names.push_back(link.name);
    for (const urdf::CollisionSharedPtr& collision : link.collision_array) add_shape(*collision, index);
    for (const urdf::LinkSharedPtr& child : link.child_links) add_link(*child, index, joints);
  }

  void add_shape(const urdf::Collision& collision, std::size_t link) {
    if (!collision.geometry) return;
    Shape shape;
    shape.link = link;
    shape.T_link_shape = from_kdl(to_kdl(collision.origin));
    if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(collision.geometry.get())) {
      shape.kind = Shape::Kind::kCapsule;
      shape.radius = cylinder->radius;
      shape.length = cylinder->length;
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(collision.geometry.get())) {
      shape.kind = Shape::Kind::kSphere;
      shape.radius = sphere->radius;
    } else if (const auto* box = dynamic_cast<const urdf::Box*>(collision.geometry.get())) {
      shape.kind = Shape::Kind::kBox;
      shape.size = {box->dim.x, box->dim.y, box->dim.z};
    } else {
      auto& meshes = model_.links_with_meshes;
      if (meshes.empty() || meshes.back() != link) meshes.push_back(link);
      return;
    }
    model_.shapes.push_back(shape);
  }

  /// The way from the first to the last joint is at most the sum of the ways from joint to joint. Both ends of it
  /// follow from the tip's pose alone: a revolute joint leaves its own origin where it is.
  void measure_reach() {
    KDL::Frame T_joint_link;  // of the last joint met
    std::size_t met = 0;
    for (const Mount& mount : model_.mounts) {
      T_joint_link = T_joint_link * mount.T_parent_zero;
      if (mount.motion == Mount::Motion::kNone) continue;
      const Joint& joint = model_.joints[met];
      if (met == 0) {
        const KDL::Frame T_base_mount = T_joint_link * mount.T_parent_zero.Inverse();
        std::copy(T_base_mount.p.data, T_base_mount.p.data + 3, model_.mount.begin());
        model_.shoulder = T_joint_link.p;
      } else {
        model_.reach += T_joint_link.p.Norm();
      }
      if (joint.prismatic) model_.reach += std::max(std::fabs(joint.lower), std::fabs(joint.upper));
      T_joint_link = KDL::Frame();
      ++met;
    }
    model_.last_joint = T_joint_link.Inverse().p;
  }

  /// From the links without children to the root: no point of a link's shapes, or of what hangs on it, is farther from
  /// its origin than its own extent or the way to a child and that one's extent.
  void measure_sweeps() {
    model_.sweeps.assign(model_.joints.size(), 0);
    std::vector<double> extents(model_.links.size(), 0);
    for (const Shape& shape : model_.shapes) {
      extents[shape.link] = std::max(extents[shape.link], norm(shape.T_link_shape.t) + extent_of(shape));
    }
    for (std::size_t i = model_.links.size(); i-- > 0;) {
      const Link& link = model_.links[i];
      if (link.drive.by == Drive::By::kArm) {
        double& sweep = model_.sweeps[link.drive.joint];
        sweep = std::max(sweep, std::fabs(link.drive.factor) * (slides(link) ? 1 : extents[i]));
      }
      double& parent = extents[link.parent];
      parent = std::max(parent, link.mount.T_parent_zero.p.Norm() + farthest_slide(link) + extents[i]);
    }
  }
  static bool slides(const Link& link) { return link.mount.motion == Mount::Motion::kSlide; }
  double farthest_slide(const Link& link) const {
    if (!slides(link)) return 0;
    double low = 0, high = link.drive.by == Drive::By::kHand ? 1 : 0;
    if (link.drive.by == Drive::By::kArm) {
      low = model_.joints[link.drive.joint].lower, high = model_.joints[link.drive.joint].upper;
    }
    return std::max(std::fabs(link.drive.factor * low + link.drive.offset),
                    std::fabs(link.drive.factor * high + link.drive.offset));
  }

  const urdf::ModelInterface& robot_;
  ArmModel& model_;
  const Posture& rest_;
};

double position_of(const Drive& drive, const JointVector& q, double share_open) {
  switch (drive.by) {
    case Drive::By::kNothing:
      return drive.offset;
    case Drive::By::kArm:
      return drive.factor * q[drive.joint] + drive.offset;
    case Drive::By::kHand:
      return drive.factor * share_open + drive.offset;
  }
  return 0;
}

double share_open(const Hand& hand, std::optional<double> opening) {
  if (!opening || !(hand.opening_max > hand.opening_min)) return 1;
  const double inside = std::min(std::max(*opening, hand.opening_min), hand.opening_max);
  return (inside - hand.opening_min) / (hand.opening_max - hand.opening_min);
}

void check_size(const JointVector& q, const std::vector<Joint>& joints) {
  if (q.size() == joints.size()) return;
  fail("the arm has " + std::to_string(joints.size()) + " joints, not " + std::to_string(q.size()));
}

}  // namespace

// ---- Arm ------------------------------------------------------------------------------------------------------------

Arm::Arm(std::shared_ptr<const ArmModel> model) : model_(std::move(model)) {}

Arm Arm::from_urdf(const std::string& text, const std::string& base, const std::string& tip, const Hand& hand,
                   const Posture& rest) {
  const urdf::ModelInterfaceSharedPtr robot = parse_urdf(text);
  auto model = std::make_shared<ArmModel>();
  model->base = base;
  model->tip = tip;
  model->hand = hand;
  Builder(*robot, *model, rest).build();
  return Arm(model);
}

Arm Arm::baxter(Side side, const ElectricGripper& gripper) {
  // Where Rethink's SDK moves the arms to with move_to_neutral().
  Posture neutral;
  for (const std::string arm : {"right", "left"}) {
    neutral[arm + "_s1"] = -0.55;
    neutral[arm + "_e1"] = 0.75;
    neutral[arm + "_w1"] = 1.26;
  }
  const std::string tip = side == Side::kRight ? "right_gripper" : "left_gripper";
  return from_urdf(baxter_urdf(gripper), "base", tip, gripper.hand(side), neutral);
}

const std::string& Arm::base() const {
  return model_->base;
}
const std::string& Arm::tip() const {
  return model_->tip;
}
const Vector3& Arm::mount() const {
  return model_->mount;
}
const std::vector<Joint>& Arm::joints() const {
  return model_->joints;
}
const Hand& Arm::hand() const {
  return model_->hand;
}
const JointVector& Arm::rest() const {
  return model_->rest;
}
const std::vector<std::string>& Arm::links() const {
  return model_->link_names;
}
const std::vector<std::size_t>& Arm::link_joints() const {
  return model_->link_joints;
}
const std::vector<double>& Arm::sweeps() const {
  return model_->sweeps;
}
const std::vector<Shape>& Arm::shapes() const {
  return model_->shapes;
}
const std::vector<std::size_t>& Arm::links_with_meshes() const {
  return model_->links_with_meshes;
}

bool Arm::within_limits(const JointVector& q) const {
  if (q.size() != joints().size()) return false;
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (!(q[i] >= joints()[i].lower && q[i] <= joints()[i].upper)) return false;
  }
  return true;
}

std::size_t Arm::link_index(const std::string& name) const {
  const auto place = std::find(links().begin(), links().end(), name);
  if (place == links().end()) fail("there is no link '" + name + "'");
  return static_cast<std::size_t>(place - links().begin());
}

Pose Arm::forward(const JointVector& q) const {
  check_size(q, joints());
  KDL::Frame T_base_link;
  std::size_t next = 0;
  for (const Mount& mount : model_->mounts) {
    T_base_link = T_base_link * mount.at(mount.motion == Mount::Motion::kNone ? 0 : q[next++]);
  }
  return from_kdl(T_base_link);
}

std::vector<Pose> Arm::link_poses(const JointVector& q, std::optional<double> opening) const {
  check_size(q, joints());
  const double open = share_open(hand(), opening);
  std::vector<KDL::Frame> T_root_link;
  T_root_link.reserve(model_->links.size());
  for (const Link& link : model_->links) {
    const KDL::Frame T_parent_link = link.mount.at(position_of(link.drive, q, open));
    T_root_link.push_back(T_root_link.empty() ? T_parent_link : T_root_link[link.parent] * T_parent_link);
  }
  const KDL::Frame T_base_root = T_root_link[model_->base_link].Inverse();
  std::vector<Pose> T_base_link;
  T_base_link.reserve(T_root_link.size());
  for (const KDL::Frame& frame : T_root_link) T_base_link.push_back(from_kdl(T_base_root * frame));
  return T_base_link;
}

bool Arm::may_reach(const Pose& T_base_tip) const {
  constexpr double kTolerance = 1e-5;  // m, as inverse()
  const KDL::Vector end = to_kdl(T_base_tip) * model_->last_joint;
  return (end - model_->shoulder).Norm() <= model_->reach + kTolerance;
}

}  // namespace handhold::plan
