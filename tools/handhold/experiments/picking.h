// The paper's grasping experiment (section 4.1) in physics: Baxter looks, localizes, plans, grasps, and carries what it
// holds to a box.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "carrier.h"
#include "handhold/localizer.h"
#include "handhold/physics.h"
#include "handhold/planner.h"
#include "handhold/scene_file.h"

namespace handhold::experiments {

/// How an attempt to grasp ended.
enum class Ending {
  kGrasped,       ///< the object is in the box
  kNotLocalized,  ///< no handle was found
  kNoPlan,        ///< no handle had a grasp that the arm could carry out
  kMissed,        ///< the fingers closed on nothing
  kSlipped,       ///< it was between the fingers, and lost on the way
  kNoWay,         ///< it was lifted, but there was no way to the box: it was put down again
  kBesideBox,     ///< it was carried, but does not lie in the box
  kBrokeDown,     ///< the simulation did
};
/// "grasped", "not localized", "no plan", "missed", "slipped", "no way", "beside the box", "broke down"
const char* to_string(Ending ending);
inline constexpr int kEndings = 8;

/// What the robot knew when it tried, for pictures of what went wrong.
struct Look {
  Cloud cloud;
  Result result;
  plan::Plan plan;
  plan::Pose T_base_camera;
  std::vector<plan::Body> own;  ///< the robot's bodies
};

struct Attempt {
  Ending ending = Ending::kNotLocalized;
  std::string why;                   ///< in words: what was rejected, what was held
  std::optional<std::size_t> thing;  ///< index into World::things() of what was grasped, or was nearest to the hand
  double pushed = 0;                 ///< m; how far the farthest moved thing that does not lie in the box was moved
  double seconds = 0;                ///< simulated
};

/// Where things stand: the table before the robot, the camera at its chest, the box on the right.
struct Workplace {
  physics::WorldOptions world;
  plan::Pose T_base_scene;  ///< scene files: z = 0 on the table, the camera at -y
  plan::Pose T_base_camera;
  sensor::CameraOptions camera;
};
Workplace workplace(const plan::ElectricGripper& gripper);

/// The gripper that can hold the main parts of as many of these families as possible, of those with standard narrow
/// fingers and hard or half round tips.
plan::ElectricGripper gripper_for(const std::vector<std::string>& families);

/// Whether a gripper can hold a part of this diameter (m), with `clearance` (m) on each side when it comes.
bool can_hold(const plan::ElectricGripper& gripper, double diameter, double clearance);

/// Things of the paper's families on the table, as the file has them (but not its table), a little above it.
std::vector<physics::Thing> things_of(const sensor::SceneFile& file, const plan::Pose& T_base_scene);

/// Of the world it knows what its camera sees, where table and box stand, and what it feels: how far the fingers have
/// closed, whether something is between them, or still hangs on the hand.
class Picker {
 public:
  Picker(const Workplace& place, const std::vector<physics::Thing>& things, const Options& localizer);

  /// Lets everything come to rest. Whether it did: not when the simulation broke down, either.
  bool settle();
  /// One attempt: look, localize, plan, grasp, carry, let go, go back. @param seed  of the camera's noise and the
  /// search
  Attempt attempt(std::uint64_t seed);
  /// Things that are not in the box and not below the table's top.
  std::vector<std::size_t> left() const;

  const physics::World& world() const { return world_; }
  const Look& look() const { return look_; }

 private:
  void see(std::uint64_t seed);
  std::pair<Ending, std::string> act(std::optional<std::size_t>& thing);
  std::pair<Ending, std::string> deliver(std::size_t thing, const plan::Grasp& grasp);
  void follow(const std::vector<plan::JointVector>& path, const std::vector<double>& times, double opening);
  void go(const plan::JointVector& to, double opening);
  void go_back(std::size_t ways, double opening);
  void go_home(const plan::JointVector& home);
  void open(double opening);
  void shake_off(std::size_t thing);
  bool touches_hand(std::size_t thing) const;
  std::optional<std::size_t> held() const;
  std::size_t nearest_to(const Vector3& p) const;

  Workplace place_;
  physics::World world_;
  Options options_;
  std::vector<plan::GraspPlanner> planners_;  ///< the more careful one first
  Carrier carrier_;
  plan::JointVector at_;                              ///< rad; where the arm was last sent to
  std::vector<std::vector<plan::JointVector>> ways_;  ///< that it has gone in this attempt
  Look look_;
};

}  // namespace handhold::experiments
