// What a hand has taken hold of, as far as the camera saw it.
#pragma once

#include <array>
#include <set>
#include <vector>

#include "handhold/planner.h"

namespace handhold::experiments {

/// Points of an object in the frame of the hand that holds it: those that were seen, and some behind them, as far as
/// things are usually thick.
class HeldObject {
 public:
  HeldObject() = default;
  /// The points of a cloud that hang together with a handle, above a table.
  /// @param table_top  m; z in base
  HeldObject(const CloudView& cloud, const plan::Pose& T_base_cloud, const Handle& handle, double table_top,
             const plan::Pose& T_base_tip);

  /// m; from the tip's frame to its farthest point: as low as it can hang
  double reach() const;
  /// Whether a point comes nearer than `margin` (m) to a body.
  bool near(const plan::Pose& T_base_tip, const plan::Body& body, double margin) const;
  /// The cloud without the object's points: what is left when it is taken away.
  const Cloud& rest() const { return rest_; }
  /// Whether a point comes as near to the rest of the cloud, but for the table, as points that hang together are.
  bool near_others(const plan::Pose& T_base_tip) const;
  /// Forgets points that are as near to the rest where the hand is now: guesses that were wrong.
  void correct(const plan::Pose& T_base_tip);

 private:
  void bound();
  void leave_rest(const CloudView& cloud, const plan::Pose& T_base_cloud, double table_top,
                  const std::set<std::array<int, 3>>& taken);
  bool is_near_others(const Vector3& p) const;

  using Cell = std::array<int, 3>;

  std::vector<Vector3> points_;  ///< m; tip's frame
  Cloud rest_;
  std::set<Cell> others_;  ///< cells (base frame) with points that do not belong to it
  Vector3 middle_ = {0, 0, 0};
  double radius_ = 0;  ///< m; of a ball about the middle that holds all
};

}  // namespace handhold::experiments
