// A robot's arm: where its links are, and which joint positions bring its hand to a pose. In a target of its own
// (handhold::plan), so that the core needs neither KDL nor urdfdom.
//
//   plan::Arm arm = plan::Arm::baxter(plan::Side::kRight);
//   std::optional<plan::JointVector> q = arm.inverse(T_base_tip);
//
// Metres and radians; the frame `base` is the arm's base link.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/sensor.h"

namespace handhold::plan {

using sensor::Pose;

/// Positions of the arm's joints, in the order of Arm::joints(): rad, or m for a prismatic one.
using JointVector = std::vector<double>;

/// Positions of joints by name (rad, m).
using Posture = std::map<std::string, double>;

// ---- Hands ----------------------------------------------------------------------------------------------------------

/// What opens and closes at the tip: two fingers, and the joints that move them apart.
struct Hand {
  double opening_min = 0;                  ///< m; between the fingers' inner faces, closed
  double opening_max = 0;                  ///< m; open
  std::vector<std::string> finger_joints;  ///< each moves from finger_closed to finger_open; joints that mimic follow
  std::optional<double> finger_closed;     ///< position at opening_min (m, rad); none: the joint's lower limit
  std::optional<double> finger_open;       ///< position at opening_max (m, rad); none: the joint's upper limit
};

enum class Side { kRight, kLeft };

/// Baxter's electric gripper as rethink_ee_description of baxter_common 1.2.0 has it; grasps are inner ones. The
/// default is the gripper of Options::baxter(). (The flat baxter.urdf, deprecated since 1.2.0, has other gripper
/// frames.)
struct ElectricGripper {
  enum class Finger { kStandardNarrow, kStandardWide, kExtendedNarrow, kExtendedWide };
  enum class Tip { kHard, kSoft, kPaddle, kHalfRound };

  Finger finger = Finger::kStandardNarrow;
  int slot = 3;  ///< 1..4, from the middle outwards; where the fingers are screwed on
  Tip tip = Tip::kHard;

  /// m
  double finger_length() const;
  /// From the frame gripper_base along z to the endpoint `right_gripper`, `left_gripper` (m).
  double endpoint_offset() const;
  /// Between the tips' inner faces (m), with the finger joints at their ends. Negative closed: the tips touch before.
  double opening_closed() const;
  double opening_open() const;
  /// The hand of one of Baxter's arms. @throws std::invalid_argument for a slot other than 1..4
  Hand hand(Side side) const;
};

/// Baxter with the same electric gripper on both arms, as URDF.
/// @throws std::invalid_argument for a slot other than 1..4
std::string baxter_urdf(const ElectricGripper& gripper = {});

// ---- Arms -----------------------------------------------------------------------------------------------------------

/// A joint that moves between base and tip.
struct Joint {
  std::string name;
  bool prismatic = false;  ///< moves in m instead of rad
  double lower = 0;        ///< rad, m
  double upper = 0;        ///< rad, m
  double velocity = 0;     ///< rad/s, m/s
};

/// A body to keep clear of. Fixed to its link.
struct Shape {
  enum class Kind {
    kCapsule,  ///< all points within `radius` of a segment of `length` on z about the origin
    kSphere,
    kBox,
  };
  Kind kind = Kind::kSphere;
  std::size_t link = 0;  ///< index into Arm::links()
  Pose T_link_shape;
  double radius = 0;         ///< m; of a capsule or sphere
  double length = 0;         ///< m; of a capsule's segment: of the cylinder, which the capsule contains
  Vector3 size = {0, 0, 0};  ///< m; edges of a box
};

struct IkOptions {
  JointVector reference;       ///< solutions near it are preferred; empty: Arm::rest()
  int restarts = 50;           ///< seeds drawn after the reference, for Levenberg-Marquardt
  int fallback_restarts = 10;  ///< the same for Newton-Raphson, where that found nothing: slower
  std::uint64_t seed = 0;      ///< of the draws: same seed, same solutions
  int candidates = 3;          ///< solutions of which inverse() takes the nearest, when none grows from the reference
  double min_distance = 0.2;   ///< rad (m); in some joint, between two solutions of inverse_all()
};

struct ArmModel;

/// An arm from its base link to its tip link, with everything else that its URDF holds: fixed bodies, fingers, a second
/// arm. Const functions may be called from several threads.
class Arm {
 public:
  /// @param urdf  text of the URDF
  /// @param base, tip  names of links; every joint between them has limits
  /// @param hand  what opens at the tip; the default has no fingers
  /// @param rest  where joints stand that nothing else moves, and where the arm's own joints are at ease; those not
  ///              named: 0, or the limit nearest to 0
  /// @throws std::invalid_argument with one line: a bad URDF, a link or joint that is not there, no chain from base to
  ///         tip, a joint on it without limits, a hand or posture that does not fit
  static Arm from_urdf(const std::string& urdf, const std::string& base, const std::string& tip, const Hand& hand = {},
                       const Posture& rest = {});

  /// One of Baxter's arms: from `base` to `right_gripper` or `left_gripper`, at rest in Rethink's neutral posture, the
  /// other arm, too. @throws std::invalid_argument for a slot other than 1..4
  static Arm baxter(Side side, const ElectricGripper& gripper = {});

  const std::string& base() const;
  const std::string& tip() const;
  /// Where the arm is fixed (m): the origin of the link that its first joint hangs on. Of Baxter: the arm mount.
  const Vector3& mount() const;
  /// From base to tip.
  const std::vector<Joint>& joints() const;
  const Hand& hand() const;
  const JointVector& rest() const;
  /// Whether there is one position for each joint, within its limits.
  bool within_limits(const JointVector& q) const;

  /// T_base_tip. @throws std::invalid_argument for a number of joints that is not the arm's, here and below
  Pose forward(const JointVector& q) const;

  /// Names of all links of the URDF, each after its parent.
  const std::vector<std::string>& links() const;
  /// @throws std::invalid_argument when there is no such link
  std::size_t link_index(const std::string& name) const;
  /// Of each link, how many of the arm's joints move it. All: it moves with the tip, as the hand and its fingers do.
  const std::vector<std::size_t>& link_joints() const;
  /// Of each joint: nothing that it moves is farther from its axis than this (m), wherever the other joints stand. How
  /// far a change of it can move the robot.
  const std::vector<double>& sweeps() const;
  /// T_base_link of every link, in the order of links().
  /// @param q  a position for each of joints()
  /// @param opening  of the hand (m), brought into its range; none: open
  std::vector<Pose> link_poses(const JointVector& q, std::optional<double> opening = std::nullopt) const;

  /// The collision shapes of all links. A cylinder is a capsule here.
  const std::vector<Shape>& shapes() const;
  /// Indices of links with a collision mesh; meshes are not read.
  const std::vector<std::size_t>& links_with_meshes() const;

  /// False when the pose is certainly too far from the first joint, whatever the others do; takes no iteration.
  bool may_reach(const Pose& T_base_tip) const;

  /// Joint positions within the limits that bring the tip to a pose, to 1e-5 m and 1e-4 rad; none when there are none
  /// or the restarts did not find them. The same arguments give the same positions. The solution that grows from the
  /// reference, or else the nearest of IkOptions::candidates.
  /// @throws std::invalid_argument for options that cannot be, or a pose that is none
  std::optional<JointVector> inverse(const Pose& T_base_tip, const IkOptions& options = {}) const;

  /// Appends up to `count` solutions that differ, nearest to the reference first. An arm with more joints than six
  /// has no end of them: more restarts find more. Returns how many were appended. @throws as inverse()
  std::size_t inverse_all(const Pose& T_base_tip, std::size_t count, const IkOptions& options,
                          std::vector<JointVector>& solutions) const;

 private:
  explicit Arm(std::shared_ptr<const ArmModel> model);
  std::shared_ptr<const ArmModel> model_;  // never changes: copies share it
};

/// Any arm: its URDF with base, tip, hand and rest from a TOML file, see the keys there.
///
///   urdf = "arm.urdf"             # path, from the TOML file's folder
///   base = "base"                 # names of links
///   tip = "gripper"
///   [hand]
///   opening_min_m = 0.0
///   opening_max_m = 0.08
///   finger_joints = ["finger"]    # may be missing, as the next two: Hand says what then
///   finger_closed = 0.0
///   finger_open = 0.04
///   [rest]                        # may be missing
///   elbow = 0.75
///
/// @throws std::invalid_argument with one line: the file, the key, what is wrong
Arm read_arm(const std::string& path);

}  // namespace handhold::plan
