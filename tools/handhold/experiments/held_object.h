// What a hand has taken hold of, as far as the camera saw it.
#pragma once

#include <cstddef>
#include <vector>

#include "handhold/planner.h"

namespace handhold::experiments {

/// Points of an object in the frame of the hand that holds it: those that were seen, and some behind them, as far as
/// things are usually thick: guesses.
class HeldObject {
 public:
  HeldObject() = default;
  /// The points of a cloud that hang together with a handle, above a table.
  /// @param table_top  m; z in base
  HeldObject(const CloudView& cloud, const plan::Pose& T_base_cloud, const Handle& handle, double table_top,
             const plan::Pose& T_base_tip);

  /// m; from the tip's frame to its farthest point: as low as it can hang
  double reach() const;
  /// Between two fingertips things turn when they are heavy, about the axis through the tips and, rolling, about that
  /// of a round part: the least turn after which the middle of what was seen hangs straight below, T_tip_turned. None
  /// where that is about the hand's approach, across both.
  plan::Pose hung(const plan::Pose& T_base_tip) const;
  /// The cloud without the object's points: what is left when it is taken away.
  const Cloud& rest() const { return rest_; }

  /// What it is kept away from, and how far.
  struct Care {
    double margin = 0;      ///< m; from obstacles
    double arm_margin = 0;  ///< m; from the arm's bodies
    bool guesses = false;   ///< whether they count
  };
  /// Where it is now it touches nothing: guesses that are nearer to something than `care` asks for were wrong, and are
  /// forgotten; points that were seen there may stay as near as they are.
  /// @param arm  bodies that the hand does not hold it with
  void leave_room(const plan::Pose& T_base_tip, const plan::Obstacles& obstacles, const std::vector<plan::Body>& arm,
                  const Care& care);
  /// m; how far it can move, whatever way, before it comes too near to something; at most 0 if it is nearer, with
  /// negative numbers for too near. Where it is near, 0 for anything that is clear.
  double room(const plan::Pose& T_base_tip, const plan::Obstacles& obstacles, const std::vector<plan::Body>& arm,
              const Care& care) const;

 private:
  struct Point {
    Vector3 p;  ///< m; tip's frame
    bool is_guess = false;
    /// m; to obstacles and to the arm, when it was where it touched nothing: nearer it may not come
    double apart = kFar, apart_arm = kFar;
  };
  static constexpr double kFar = 0.1;  // m; beyond any margin

  void bound();

  std::vector<Point> points_;
  Cloud rest_;
  Vector3 seen_middle_ = {0, 0, 0};  ///< m; tip's frame
  Vector3 middle_ = {0, 0, 0};
  double radius_ = 0;  ///< m; of a ball about the middle that holds all
};

}  // namespace handhold::experiments
