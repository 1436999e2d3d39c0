// What is behind physics::World.
#pragma once

#include <string>
#include <vector>

#include "handhold/physics.h"
#include "simulation.h"

namespace handhold::physics {

/// Where something that a motor moves is in MuJoCo's arrays.
struct Driven {
  int position, velocity, motor;
};

struct World::Impl {
  Impl(const WorldOptions& given, const std::vector<Thing>& given_things);

  /// One time step. @param speeds  that the arm shall have, of each joint (rad/s)
  void advance(const plan::JointVector& speeds);
  /// Brings what follows from the positions up to date.
  void refresh() { mj_kinematics(simulation.model.get(), simulation.data.get()); }

  void check_joints(const plan::JointVector& q, const std::string& what) const;
  /// Where a finger's motor has to go for an opening (m): beyond the end for one that closes.
  double finger_target(double opening) const;
  /// Of a thing, or of a link or something else that MuJoCo has by its own name.
  std::string name_of(int body) const;

  WorldOptions options;
  std::vector<Thing> things;
  plan::Arm arm;
  Simulation simulation;
  std::vector<Driven> joints;   // of the arm
  std::vector<Driven> fingers;  // the one that moves to positive positions, and its mirror image
  std::vector<int> thing_bodies;
  std::vector<int> left_finger, right_finger;  // bodies
  std::vector<sensor::Object> objects;         // of the things, in their own frames

  plan::JointVector target;
  double wanted_finger = 0;  // m; of the moved finger
  double finger = 0;         // m; where its motor is set at present
};

}  // namespace handhold::physics
