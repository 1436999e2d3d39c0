// A physics world to try grasps in: Baxter with an electric gripper before a table, household objects with mass and
// friction, a box to carry them to. Everything moves by forces alone: the arm by its joints' motors, objects by gravity
// and by what touches them. In a target of its own (handhold::physics), the only one that knows MuJoCo.
//
//   physics::World world(options, {{"plunger", "plunger", {}, T_world_object, 0.35, 0.85}});
//   world.settle(2);
//   Cloud cloud = camera.capture(world.scene(), T_world_camera).cloud;
//   world.follow(grasp.path, grasp.times, grasp.opening);
//   world.command(grasp.path.back(), 0);  // the fingers close
//   world.step(1);
//
// Metres, kilograms, seconds, newtons, radians. The world's frame is the robot's frame `base`, z up.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "handhold/arm.h"
#include "handhold/families.h"
#include "handhold/sensor.h"

namespace handhold::physics {

using sensor::Pose;

// ---- What there is --------------------------------------------------------------------------------------------------

/// An object of one of the families: a rigid body of uniform density.
struct Thing {
  std::string name;    ///< unique; not "table", "bin" or "floor"
  std::string family;  ///< see families.h
  sensor::Sizes sizes = {};
  Pose T_world_object = {};  ///< where it starts
  double mass = 0.2;         ///< kg, > 0
  double friction = 0.85;    ///< >= 0; sliding coefficient against fingertips; between two things the larger one counts
  sensor::Material material = {};
};

struct Table {
  Vector3 size = {0.7, 1.2, 0.04};                                       ///< m; edges
  Pose T_world_table = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.85, 0, -0.17}};  ///< of the middle of the box
};

/// An open box that objects are carried to.
struct Bin {
  Vector3 inner = {0.4, 0.4, 0.25};                                        ///< m; edges of what is within
  double wall = 0.01;                                                      ///< m; thickness of walls and floor
  Pose T_world_bin = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.45, -0.85, -0.35}};  ///< of the middle of the floor's upper side
};

struct WorldOptions {
  plan::ElectricGripper gripper;
  plan::Side side = plan::Side::kRight;  ///< the arm that moves; the other one stands at its rest
  plan::JointVector start;               ///< where the arm starts, hand open; empty: Arm::rest()
  Table table;
  Bin bin;
  double floor = -0.93;           ///< m; height of the floor, which is without end: below what Baxter stands on
  double gravity = 9.81;          ///< m/s^2, >= 0
  double timestep = 0.001;        ///< s, > 0, at most 0.002: contacts are springs of 4 ms
  double surface_friction = 0.5;  ///< >= 0; sliding coefficient of table, bin, floor and links against everything
  double grip_force = 20;         ///< N, > 0; of each finger; published effort
  double finger_speed = 0.1;      ///< m/s, > 0; at which the opening changes

  /// @throws std::invalid_argument naming the first option that is out of range
  void validate() const;
};

/// What an object of the paper's Table 1 weighs in a household, and how well rubber tips hold it.
struct ObjectFacts {
  std::string family;
  double mass = 0;      ///< kg
  double friction = 0;  ///< as Thing::friction
  std::string reason;   ///< why this mass and friction: assumptions, not measurements
};
/// The twelve objects of Table 1, in its order.
const std::vector<ObjectFacts>& paper_objects();

// ---- The world ------------------------------------------------------------------------------------------------------

/// Nothing here sets a position after the start. The same options, things and calls give the same numbers. One thread
/// at a time; worlds are independent of each other.
///
/// The arm's motors hold their positions by springs and dampers (Baxter's published efforts at most) on top of the
/// torque that carries the arm's own weight, as Baxter's controller has it. Links of the robot do not touch each other.
class World {
 public:
  /// @throws std::invalid_argument with one line for options, things or poses that cannot be
  World(const WorldOptions& options, const std::vector<Thing>& things);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  const WorldOptions& options() const;
  const std::vector<Thing>& things() const;
  const plan::Arm& arm() const;
  /// s; since the start
  double time() const;

  // -- Acting. These throw std::runtime_error when the simulation breaks down (numbers that are no longer finite).

  /// Sets where the arm's joints (rad) and the fingers shall be. The opening (m) changes at finger_speed; at the
  /// hand's smallest opening or below, the fingers close with grip_force on whatever is between them.
  /// @throws std::invalid_argument for joints beyond the limits or an opening that is not finite
  void command(const plan::JointVector& q, double opening);
  /// Lets time pass, to the nearest whole time step. @throws std::invalid_argument for a negative time
  void step(double seconds);

  /// How a path went.
  struct Tracking {
    double error = 0;       ///< rad; largest distance of a joint from where it should have been
    bool finished = false;  ///< false: `proceed` stopped it
  };
  /// Moves along a path, linear between its samples. It should start where the arm was last commanded to; afterwards
  /// its end stays commanded.
  /// @param path     samples: positions of the arm's joints (rad), base first
  /// @param times    s, of each sample, increasing from 0
  /// @param opening  m, as in command
  /// @param proceed  is asked every 10 ms whether to go on; otherwise the arm holds where it should be then
  /// @throws std::invalid_argument for a path that is empty or beyond the limits, or times that do not fit
  Tracking follow(const std::vector<plan::JointVector>& path, const std::vector<double>& times, double opening,
                  const std::function<bool()>& proceed = {});
  /// Lets time pass until everything has been at rest for 0.5 s, holding what was commanded. Returns whether that
  /// happened within `max_seconds`.
  bool settle(double max_seconds);

  // -- The robot

  plan::JointVector joints() const;      ///< rad
  plan::JointVector velocities() const;  ///< rad/s
  double opening() const;                ///< m; between the fingertips; closed below 0 in slots where they would meet
  Pose tip() const;                      ///< T_world_tip, of the link Arm::tip()
  /// N; with which each finger presses on things, left and right one.
  std::array<double, 2> finger_forces() const;
  /// What links of the robot touch, sorted: a link, and as in touching() what it touches.
  std::vector<std::pair<std::string, std::string>> robot_contacts() const;

  // -- Things, by their index. @throws std::out_of_range

  Pose pose(std::size_t thing) const;
  Vector3 center_of_mass(std::size_t thing) const;  ///< m
  double speed(std::size_t thing) const;            ///< m/s; of its centre of mass
  double spin(std::size_t thing) const;             ///< rad/s
  /// Below 5 mm/s and 0.1 rad/s.
  bool at_rest(std::size_t thing) const;
  /// What touches it, sorted: "table", "bin", "floor", names of things and of links.
  std::vector<std::string> touching(std::size_t thing) const;
  /// m; how deep it is in what it touches, at the deepest contact. Contacts are stiff springs, not perfectly rigid.
  double penetration(std::size_t thing) const;
  /// Whether both fingers touch it.
  bool held(std::size_t thing) const;
  /// Whether its centre of mass is between the bin's walls, above the floor and below the rim.
  bool in_bin(std::size_t thing) const;

  // -- Seeing

  struct SceneParts {
    bool surroundings = true;  ///< table, bin, and the floor as far as 4 m from the robot
    bool arms = true;          ///< collision shapes of both arms and hands
  };
  /// What a camera would see now: the things, in their order and with their parts; then, as asked, "table", "bin",
  /// "floor" and one object for every link of the arms, of its name.
  sensor::Scene scene(const SceneParts& parts) const;
  sensor::Scene scene() const { return scene({}); }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handhold::physics
