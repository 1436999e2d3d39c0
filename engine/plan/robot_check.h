// What the robot touches in a posture: obstacles, or itself.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "handhold/planner.h"

namespace handhold::plan {

struct Clearances {
  double hand = 0, self = 0, arm = 0;  ///< m
};

class RobotCheck {
 public:
  RobotCheck(const Arm& arm, const Clearances& clearances);
  /// The same with other clearances from obstacles (m).
  RobotCheck with(double hand, double arm) const;

  /// The hand's bodies (all that moves with the tip) at the tip's pose, against obstacles: what is hit.
  std::optional<std::string> hand(const Obstacles& obstacles, const Pose& T_base_tip, double opening) const;

  /// @param hand  whether the hand's bodies are held against obstacles; against the robot they are in any case
  std::optional<GraspPlanner::Hit> posture(const Obstacles& obstacles, const JointVector& q, double opening,
                                           bool hand) const;
  std::optional<GraspPlanner::Hit> path(const Obstacles& obstacles, const std::vector<JointVector>& path,
                                        double opening, bool hand) const;
  /// What the robot touches of itself: the name of a link.
  std::optional<std::string> itself(const std::vector<Pose>& T_base_link) const;

  /// Pairs of shapes that are held against each other, as indices into Arm::shapes().
  const std::vector<std::pair<std::size_t, std::size_t>>& pairs() const { return pairs_; }

 private:
  struct Clear {
    double distance;  ///< m; to the nearest obstacle, beyond what is required; at most a limit
    std::string what;
  };
  Clear clearance(const Obstacles& obstacles, const std::vector<Pose>& T_base_link, bool hand, double limit) const;
  double way(const JointVector& from, const JointVector& to) const;
  std::optional<GraspPlanner::Hit> between(const Obstacles& obstacles, const JointVector& from, double room_from,
                                           const JointVector& to, double room_to, double opening, bool hand) const;
  std::string name_of(const Obstacles& obstacles, const Obstacles::Nearest& nearest) const;
  bool is_hand(const Shape& shape) const { return arm_.link_joints()[shape.link] == arm_.joints().size(); }
  void keep(double hand, double arm);
  std::size_t joints_that_move(const Shape& shape) const;
  void choose_pairs();

  Arm arm_;
  Clearances clearances_;
  std::size_t tip_ = 0;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  std::vector<Shape> inscribed_;  ///< Arm::shapes() with capsules inside of their cylinders
};

}  // namespace handhold::plan
