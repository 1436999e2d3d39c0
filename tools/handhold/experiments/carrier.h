// Ways for an arm that holds something, from where it lifted it to above a box, and back.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "handhold/physics.h"
#include "handhold/planner.h"
#include "held_object.h"

namespace handhold::experiments {

/// What is kept clear on a way; the first that has one is taken.
enum class Care {
  kAmple,    ///< 30 mm about arm and hand, 20 mm about what is held and what may be behind what was seen of it, as it
             ///< was taken and as it hangs when it turns between the fingers; the hand does not tilt
  kAsTaken,  ///< the same, as it was taken
  kNarrow,   ///< 15 mm about the arm, 5 mm about the hand and what was seen of what it holds
  kArmOnly,  ///< 15 mm about the arm alone
};
inline constexpr Care kCares[] = {Care::kAmple, Care::kAsTaken, Care::kNarrow, Care::kArmOnly};
/// "ample room", "as taken", "narrow", "with the arm clear only"
const char* to_string(Care care);

class Carrier {
 public:
  /// @param known  bodies that are where they are said to be, the box among them
  Carrier(const plan::Arm& arm, const physics::Bin& bin, const std::vector<std::pair<std::string, plan::Body>>& known);

  /// Takes what is in the hand, and what else a cloud shows.
  /// @param own  the robot's bodies when the cloud was taken
  void hold(const HeldObject& object, const plan::Pose& T_base_cloud, const std::vector<plan::Body>& own);

  /// Postures to go through, straight from one to the next.
  struct Way {
    std::vector<plan::JointVector> stops;  ///< without the start
    Care care = Care::kAmple;
  };
  /// To above the middle of the box, by way of where the hand is raised, as far as it can be: what is heavy turns in
  /// the hand, and hangs lower than it was seen. Otherwise straight, or by way of where the hand is drawn back, or of
  /// where the arm was before. What is held touches nothing at the start.
  std::optional<Way> to_box(const plan::JointVector& start, const plan::JointVector& before);
  /// From above the box, at its end, to where the hand points down there, as far as the arm can: a closed handle slides
  /// off its fingers then, and may hang on them otherwise.
  std::optional<plan::JointVector> turned_down(const plan::JointVector& over) const;

  /// Whether the arm and its empty, open hand are clear of everything on the straight way.
  bool is_clear(const plan::JointVector& from, const plan::JointVector& to) const;

 private:
  std::vector<plan::JointVector> via(const plan::JointVector& start, const plan::JointVector& before) const;
  std::vector<plan::JointVector> ends(const plan::JointVector& from) const;
  std::vector<plan::JointVector> over_box(const std::vector<plan::Pose>& orientations,
                                          const plan::JointVector& from) const;
  bool stays_over_box(const plan::JointVector& from, const plan::JointVector& to) const;
  double tilt(const plan::JointVector& from, const plan::JointVector& to) const;
  bool is_blocked(const plan::JointVector& from, const plan::JointVector& to, Care care) const;
  bool held_hits(const plan::JointVector& from, const plan::JointVector& to, Care care) const;
  std::vector<plan::Body> arm_bodies(const plan::JointVector& q) const;
  const plan::GraspPlanner& planner(Care care) const {
    return care == Care::kAmple || care == Care::kAsTaken ? ample_ : narrow_;
  }

  plan::Arm arm_;
  physics::Bin bin_;
  plan::GraspPlanner ample_, narrow_;  ///< they differ in their clearances
  std::vector<bool> is_finger_;        ///< of each link
  HeldObject held_;
};

}  // namespace handhold::experiments
