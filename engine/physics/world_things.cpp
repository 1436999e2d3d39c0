// Where things are, how they move, and what touches them.
#include <algorithm>
#include <cmath>
#include <set>

#include "vec.h"
#include "world_impl.h"

namespace handhold::physics {
namespace {

bool contains(const std::vector<int>& bodies, int body) {
  return std::find(bodies.begin(), bodies.end(), body) != bodies.end();
}

/// Calls with each contact of a body and the other body.
template <class Action>
void for_contacts(const Simulation& simulation, int body, Action action) {
  const mjModel& m = *simulation.model;
  const mjData& d = *simulation.data;
  for (int i = 0; i < d.ncon; ++i) {
    const mjContact& contact = d.contact[i];
    if (contact.dist > 0) continue;
    const int a = m.geom_bodyid[contact.geom1], b = m.geom_bodyid[contact.geom2];
    if (a == body) action(i, b);
    if (b == body) action(i, a);
  }
}

double normal_force(const Simulation& simulation, int contact) {
  mjtNum force[6];
  mj_contactForce(simulation.model.get(), simulation.data.get(), contact, force);
  return force[0];
}

/// Linear (world) and angular velocity of a body about its centre of mass.
struct Motion {
  Vector3 linear, angular;
};
Motion motion_of(const Simulation& simulation, int body) {
  const mjModel& m = *simulation.model;
  const mjData& d = *simulation.data;
  const mjtNum* v = d.qvel + m.body_dofadr[body];
  const sensor::Pose T = simulation.body_pose(body);
  const Vector3 spin = T.direction({v[3], v[4], v[5]});  // MuJoCo has it in the body's frame
  const Vector3 arm = T.direction({m.body_ipos[3 * body], m.body_ipos[3 * body + 1], m.body_ipos[3 * body + 2]});
  return {Vector3{v[0], v[1], v[2]} + cross(spin, arm), spin};
}

}  // namespace

std::array<double, 2> World::finger_forces() const {
  const Simulation& simulation = impl_->simulation;
  std::array<double, 2> forces = {0, 0};
  for (const int body : impl_->thing_bodies) {
    for_contacts(simulation, body, [&](int contact, int other) {
      if (contains(impl_->left_finger, other)) forces[0] += normal_force(simulation, contact);
      if (contains(impl_->right_finger, other)) forces[1] += normal_force(simulation, contact);
    });
  }
  return forces;
}

Pose World::pose(std::size_t thing) const {
  return impl_->simulation.body_pose(impl_->thing_bodies.at(thing));
}

Vector3 World::center_of_mass(std::size_t thing) const {
  const mjtNum* center = impl_->simulation.data->xipos + 3 * impl_->thing_bodies.at(thing);
  return {center[0], center[1], center[2]};
}

double World::speed(std::size_t thing) const {
  return norm(motion_of(impl_->simulation, impl_->thing_bodies.at(thing)).linear);
}

double World::spin(std::size_t thing) const {
  return norm(motion_of(impl_->simulation, impl_->thing_bodies.at(thing)).angular);
}

std::string World::Impl::name_of(int body) const {
  const auto place = std::find(thing_bodies.begin(), thing_bodies.end(), body);
  if (place == thing_bodies.end()) return simulation.body_name(body);
  return things[static_cast<std::size_t>(place - thing_bodies.begin())].name;
}

std::vector<std::string> World::touching(std::size_t thing) const {
  std::set<std::string> names;
  for_contacts(impl_->simulation, impl_->thing_bodies.at(thing),
               [&](int, int other) { names.insert(impl_->name_of(other)); });
  return {names.begin(), names.end()};
}

std::vector<std::pair<std::string, std::string>> World::robot_contacts() const {
  std::set<std::pair<std::string, std::string>> pairs;
  for (const std::string& link : impl_->arm.links()) {
    for_contacts(impl_->simulation, impl_->simulation.body(link),
                 [&](int, int other) { pairs.emplace(link, impl_->name_of(other)); });
  }
  return {pairs.begin(), pairs.end()};
}

double World::penetration(std::size_t thing) const {
  double deepest = 0;
  for_contacts(impl_->simulation, impl_->thing_bodies.at(thing),
               [&](int contact, int) { deepest = std::max(deepest, -impl_->simulation.data->contact[contact].dist); });
  return deepest;
}

bool World::held(std::size_t thing) const {
  bool left = false, right = false;
  for_contacts(impl_->simulation, impl_->thing_bodies.at(thing), [&](int, int other) {
    left |= contains(impl_->left_finger, other);
    right |= contains(impl_->right_finger, other);
  });
  return left && right;
}

bool World::in_bin(std::size_t thing) const {
  const Bin& bin = impl_->options.bin;
  const Vector3 p = bin.T_world_bin.inverse().point(center_of_mass(thing));
  return std::abs(p[0]) < bin.inner[0] / 2 && std::abs(p[1]) < bin.inner[1] / 2 && p[2] > 0 && p[2] < bin.inner[2];
}

}  // namespace handhold::physics
