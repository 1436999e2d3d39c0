// From handles to grasps that an arm can carry out (paper, sections 4.1 and 4.2). Part of handhold::plan.
//
//   plan::GraspPlanner planner(plan::Arm::baxter(plan::Side::kRight));
//   planner.obstacles().set_cloud(cloud.view(), T_base_camera);
//   plan::Plan plan = planner.plan(result.handles, T_base_camera);
//   for (const plan::Grasp& grasp : plan.grasps) execute(grasp.path, grasp.times);
//
// Metres, radians, seconds; the frame `base` is the arm's base link, the frame of the hand its tip link.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "handhold/arm.h"
#include "handhold/collision.h"
#include "handhold/result.h"

namespace handhold::plan {

/// Which handle is tried first.
enum class Order {
  kNearest,     ///< to the arm's mount, as in the paper (section 4.1)
  kConfidence,  ///< the most confident one
  kHighest,     ///< the one highest above the base: what lies on others first
};

struct PlannerOptions {
  JointVector start;  ///< where the arm stands, within its limits; empty: Arm::rest()
  Order order = Order::kNearest;
  /// m, >= 0; with Order::kNearest: a handle that is farther by no more than this, but longer, comes first. A long part
  /// is held in its middle, nearer to what it carries. 0: the paper's order.
  double nearest_tolerance = 0;
  std::size_t max_grasps = 1;  ///< how many grasps are wanted, one a handle; 0: one for every handle that has one
  bool all = false;            ///< look at every candidate of every handle, and list all in Plan::candidates

  // The frame of the hand, the arm's tip link: z points out of it, y is the direction in which it closes.
  double pregrasp_distance = 0.1;  ///< m, 0.001 .. 10; the hand comes straight from there
  double lift = 0.15;              ///< m, 0 .. 10; upwards (+z of base) after it has closed
  /// m, -1 .. 1; how far the hand's frame goes beyond the part's axis, in this order of preference. 0 is the paper's.
  std::vector<double> depths = {0.012, 0.006, 0};
  /// Places along a handle, as shares of half of its length from its centre, in this order of preference.
  std::vector<double> places = {0, 0.35, -0.35, 0.7, -0.7};
  double angle_step = 0.2617993877991494;  ///< rad, >= 0.01; of the approach about the part's axis
  double max_angle = 1.5707963267948966;   ///< rad, 0 .. pi; from Handle::approach: beyond it the hand goes unseen ways

  /// rad; of the approach from across the axis towards the handle's ends, in this order of preference. The paper's is
  /// 0.
  std::vector<double> tilts = {0, 0.3, -0.3};

  double finger_clearance = 0.004;  ///< m, >= 0; beside the part, on each side, when the hand comes
  double hand_clearance = 0.001;    ///< m, >= 0; of hand and fingers from obstacles
  double self_clearance = 0.01;     ///< m, >= 0; between links of the robot
  double arm_clearance = 0.015;     ///< m, >= 0; of everything else from obstacles
  /// m, >= 0; of arm and hand on the way from the start to the pre-grasp, where it is more than theirs: what is behind
  /// something was not seen, and an arm is not quite where it is sent.
  double path_clearance = 0;

  /// rad (m for a prismatic joint), >= 0.001; between two samples of a path no joint moves more
  double step = 0.05;
  double speed = 0.3;              ///< 0 < speed <= 1; share of the joints' velocity limits
  double approach_speed = 0.1;     ///< the same from the pre-grasp on
  double acceleration_time = 0.3;  ///< s, >= 0; from rest to full speed
  int solutions = 4;               ///< of inverse kinematics that are tried for one pose of the hand, >= 1
  int approach_pieces = 4;  ///< straight pieces in joint space that make up the way from pre-grasp to grasp, >= 1
  IkOptions inverse = {{}, 12, 0, 0, 1, 0.2};  ///< its reference is not used

  /// @throws std::invalid_argument naming the first option that is out of range
  void validate() const;
};

/// Why a candidate is no grasp, in the order in which they are found out; those further down came further.
enum class Reason {
  kTooWide,        ///< the part and the clearance beside it do not fit between the open fingers
  kTooThin,        ///< the closed fingers would not touch the part
  kOutOfReach,     ///< too far from the arm, whatever its joints do
  kHandHits,       ///< hand or fingers would touch the cloud or a known body, at the grasp or on the way to it
  kJointLimits,    ///< no joint positions within the limits were found
  kArmHitsItself,  ///< the arm would touch the robot
  kArmHits,        ///< the arm would touch the cloud or a known body at the grasp or on the way to it
  kPathHits,       ///< the same on the straight way in joint space from the start to the pre-grasp
  kLiftHits,       ///< no way up after the hand has closed
};
/// "too wide", "too thin", "out of reach", "hand hits", "joint limits", "arm hits itself", "arm hits", "path hits",
/// "lift hits"
std::string_view to_string(Reason);
inline constexpr std::size_t kReasons = static_cast<std::size_t>(Reason::kLiftHits) + 1;

struct Grasp {
  std::size_t handle = 0;        ///< index into the handles given
  Pose pregrasp, grasp, lifted;  ///< T_base_tip
  double opening = 0;            ///< m; of the hand on its way to the part
  double width = 0;              ///< m; of the part: where the fingers meet it
  Vector3 approach = {0, 0, 0};  ///< unit; base frame; direction in which the hand moves
  double angle = 0;              ///< rad; about the part's axis, from the paper's approach
  double tilt = 0;               ///< rad; towards the axis
  bool flipped = false;          ///< the hand is turned by half a turn about its approach
  /// Joint positions from the start by way of the pre-grasp to the grasp, and from there to the end of the lift.
  std::vector<JointVector> path, lift_path;
  std::vector<double> times, lift_times;  ///< s, of each; from 0 on; at rest at the start, pre-grasp and end
  std::size_t pregrasp_index = 0;         ///< of the pre-grasp in `path`
};

/// One way to hold a handle that was looked at.
struct Candidate {
  std::size_t handle = 0;
  double place = 0;  ///< m; along the handle, from its centre
  double angle = 0;  ///< rad; as Grasp::angle
  double tilt = 0;   ///< rad; as Grasp::tilt
  bool flipped = false;
  std::optional<Reason> reason;  ///< none: it is a grasp
  std::string what;              ///< what is hit: "cloud", the name of a known body or of a link; may be empty
};

struct Rejection {
  std::size_t handle = 0;
  Reason reason = Reason::kTooWide;            ///< of the candidate that came furthest
  std::string what;                            ///< as Candidate::what
  std::array<std::size_t, kReasons> counts{};  ///< of its candidates by their reasons
};

struct Plan {
  std::vector<Grasp> grasps;          ///< in the order asked for
  std::vector<Rejection> rejected;    ///< handles that were looked at and have no grasp, in the same order
  std::vector<Candidate> candidates;  ///< with PlannerOptions::all
};

/// Plans for one arm. Const functions may be called from several threads, as far as obstacles() are left alone.
class GraspPlanner {
 public:
  /// @throws std::invalid_argument for an option that is out of range, a start that is not within the arm's limits, or
  ///         an arm without a hand or with a joint without velocity
  explicit GraspPlanner(const Arm& arm, const PlannerOptions& options = {});
  ~GraspPlanner();
  GraspPlanner(GraspPlanner&&) noexcept;
  GraspPlanner& operator=(GraspPlanner&&) noexcept;

  const Arm& arm() const;
  const PlannerOptions& options() const;

  /// What the arm keeps clear of.
  Obstacles& obstacles();
  const Obstacles& obstacles() const;

  /// Grasps for handles in a camera's frame. Candidates are looked at one by one, cheap tests first, until there are
  /// as many grasps as wanted; with PlannerOptions::all every one, in parallel in the caller's TBB arena. The same
  /// arguments and obstacles give the same plan.
  /// @throws std::invalid_argument for a pose that is none, or a handle that cannot be one, by its index: with an axis
  ///         or approach that is no direction, or numbers that are not finite
  Plan plan(const std::vector<Handle>& handles, const Pose& T_base_camera) const;

  /// The straight way in joint space from one posture to another, sampled at PlannerOptions::step, both ends included.
  /// @throws std::invalid_argument for joints beyond the limits
  std::vector<JointVector> straight(const JointVector& from, const JointVector& to) const;
  /// Times (s) along a path that is at rest at both ends, from 0 on: it speeds up for
  /// PlannerOptions::acceleration_time, slows down for as long, and in between one joint moves at this share of its
  /// velocity limit. @throws std::invalid_argument for a sample with another number of joints, or a speed out of range
  std::vector<double> times(const std::vector<JointVector>& path, double speed) const;
  /// What the robot touches in a posture, with its clearances: none, or the reason and what is hit.
  /// @param opening  of the hand (m)
  /// @param hand  false: hand and fingers are not looked at, they hold something
  struct Hit {
    Reason reason = Reason::kArmHits;
    std::string what;
  };
  std::optional<Hit> hit(const JointVector& q, double opening, bool hand = true) const;
  /// The same along a path, with the clearances at its samples, and but for 1 mm of them everywhere between (from the
  /// distances at the samples and Arm::sweeps()). The robot's own links are looked at in the samples.
  std::optional<Hit> hit(const std::vector<JointVector>& path, double opening, bool hand = true) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handhold::plan
