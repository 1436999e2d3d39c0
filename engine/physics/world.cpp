#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "contacts.h"
#include "mjcf.h"
#include "vec.h"
#include "world_impl.h"

namespace handhold::physics {
namespace {

constexpr double kStillSpeed = 0.005, kStillSpin = 0.1;  // m/s, rad/s
constexpr double kStillTime = 0.5;                       // s
constexpr double kAskEvery = 0.01;                       // s

[[noreturn]] void fail(const std::string& message) {
  throw std::invalid_argument(message);
}

void check_range(const char* name, double value, double low, double high, bool above) {
  if (value <= high && (above ? value > low : value >= low)) return;
  fail(std::string("physics: ") + name + " is " + text_of(value) + "; must be " + (above ? "above " : "from ") +
       text_of(low) + " to " + text_of(high));
}

void check_pose(const std::string& what, const Pose& pose) {
  const auto& R = pose.R;
  const Vector3 x = {R[0], R[3], R[6]}, y = {R[1], R[4], R[7]}, z = {R[2], R[5], R[8]};
  const double error = std::abs(norm(x) - 1) + std::abs(norm(y) - 1) + std::abs(dot(x, y)) + norm(cross(x, y) - z);
  if (!(error < 1e-6) || !std::isfinite(norm(pose.t))) fail("physics: the pose of " + what + " is no rigid motion");
}

void check_things(const std::vector<Thing>& things) {
  std::set<std::string> names = {"table", "bin", "floor"};
  for (const Thing& thing : things) {
    if (!names.insert(thing.name).second) fail("physics: the name '" + thing.name + "' is taken; names are unique");
    if (!(thing.mass > 0 && thing.mass <= 1000)) {
      fail("physics: '" + thing.name + "' has a mass of " + text_of(thing.mass) + " kg; must be above 0 to 1000");
    }
    if (!(thing.friction >= 0 && thing.friction <= 10)) {
      fail("physics: '" + thing.name + "' has a friction of " + text_of(thing.friction) + "; must be 0 to 10");
    }
    check_pose("'" + thing.name + "'", thing.T_world_object);
  }
}

/// Before anything is made of them.
const WorldOptions& checked(const WorldOptions& options, const std::vector<Thing>& things) {
  options.validate();
  check_things(things);
  return options;
}

/// As mj_step1, with fewer contacts.
void first_half_of_step(const mjModel& m, mjData& d) {
  mj_checkPos(&m, &d);
  mj_checkVel(&m, &d);
  mj_kinematics(&m, &d);
  mj_comPos(&m, &d);
  mj_tendon(&m, &d);
  mj_crb(&m, &d);
  mj_factorM(&m, &d);
  mj_collision(&m, &d);
  keep_bounding_contacts(m, d);
  mj_makeConstraint(&m, &d);
  mj_transmission(&m, &d);
  mj_projectConstraint(&m, &d);
  mj_fwdVelocity(&m, &d);
}

/// Between two samples of a path at a time; and the speeds there.
struct Waypoint {
  plan::JointVector q, speeds;
};
Waypoint waypoint_at(const std::vector<plan::JointVector>& path, const std::vector<double>& times, double time) {
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  if (next == times.end()) return {path.back(), plan::JointVector(path.back().size())};
  const std::size_t b = static_cast<std::size_t>(next - times.begin()), a = b - 1;
  const double span = times[b] - times[a], share = (time - times[a]) / span;
  Waypoint point{path[a], path[a]};
  for (std::size_t i = 0; i < point.q.size(); ++i) {
    const double way = path[b][i] - path[a][i];
    point.q[i] += share * way;
    point.speeds[i] = way / span;
  }
  return point;
}

bool all_at_rest(const World& world) {
  for (std::size_t i = 0; i < world.things().size(); ++i) {
    if (!world.at_rest(i)) return false;
  }
  return true;
}

}  // namespace

void WorldOptions::validate() const {
  for (const double size : {table.size[0], table.size[1], table.size[2]}) {
    check_range("an edge of the table (m)", size, 0, 10, true);
  }
  for (const double size : {bin.inner[0], bin.inner[1], bin.inner[2]}) {
    check_range("an inner edge of the bin (m)", size, 0, 10, true);
  }
  check_range("the bin's wall (m)", bin.wall, 0, 1, true);
  check_range("floor (m)", floor, -10, 10, false);
  check_range("gravity (m/s^2)", gravity, 0, 100, false);
  check_range("timestep (s)", timestep, 0, 0.002, true);
  check_range("surface_friction", surface_friction, 0, 10, false);
  check_range("grip_force (N)", grip_force, 0, 1000, true);
  check_range("finger_speed (m/s)", finger_speed, 0, 10, true);
  check_pose("the table", table.T_world_table);
  check_pose("the bin", bin.T_world_bin);
}

// ---- Impl -----------------------------------------------------------------------------------------------------------

World::Impl::Impl(const WorldOptions& given, const std::vector<Thing>& given_things)
    : options(checked(given, given_things)),
      things(given_things),
      arm(plan::Arm::baxter(options.side, options.gripper)),
      simulation(world_mjcf(options, arm, things)) {
  const mjModel& m = *simulation.model;
  const auto driven = [&](const std::string& name) {
    const int joint = simulation.joint(name);
    return Driven{m.jnt_qposadr[joint], m.jnt_dofadr[joint], simulation.motor(name)};
  };
  for (const plan::Joint& joint : arm.joints()) joints.push_back(driven(joint.name));
  const FingerJoints names = finger_joints(options.side);
  fingers = {driven(names.moved), driven(names.mimic)};
  for (const auto& [name, bodies] : {std::pair(names.moved, &left_finger), std::pair(names.mimic, &right_finger)}) {
    const std::string link = name.substr(0, name.size() - std::string("_joint").size());
    *bodies = {simulation.body(link), simulation.body(link + "_tip")};
  }
  for (std::size_t i = 0; i < things.size(); ++i) {
    thing_bodies.push_back(simulation.body(thing_name(i)));
    objects.push_back(sensor::make_object(things[i].family, things[i].sizes));
    objects.back().name = things[i].name;
    objects.back().material = things[i].material;
  }

  target = options.start.empty() ? arm.rest() : options.start;
  check_joints(target, "start");
  finger = wanted_finger = finger_target(arm.hand().opening_max);
  mjData& d = *simulation.data;
  for (std::size_t i = 0; i < joints.size(); ++i) d.qpos[joints[i].position] = target[i];
  d.qpos[fingers[0].position] = finger;
  d.qpos[fingers[1].position] = -finger;
  first_half_of_step(m, d);  // poses and contacts at the start
}

void World::Impl::advance(const plan::JointVector& speeds) {
  const mjModel& m = *simulation.model;
  mjData& d = *simulation.data;
  const double most = options.finger_speed / 2 * options.timestep;  // of one finger
  finger += std::clamp(wanted_finger - finger, -most, most);
  first_half_of_step(m, d);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Driven& joint = joints[i];
    // The torque that carries the arm's own weight and turns its own mass.
    d.qfrc_applied[joint.velocity] = d.qfrc_bias[joint.velocity];
    // A motor's damper acts against velocity: a target ahead of the position makes it act against the error of it.
    const double spring = m.actuator_gainprm[mjNGAIN * joint.motor];
    const double damper = -m.actuator_biasprm[mjNBIAS * joint.motor + 2];
    d.ctrl[joint.motor] = target[i] + damper / spring * speeds[i];
  }
  d.ctrl[fingers[0].motor] = finger;
  d.ctrl[fingers[1].motor] = -finger;
  mj_step2(&m, &d);
}

void World::Impl::check_joints(const plan::JointVector& q, const std::string& what) const {
  if (!arm.within_limits(q)) {
    fail("physics: " + what + ": must be " + std::to_string(joints.size()) + " joint positions within the limits");
  }
}

double World::Impl::finger_target(double opening) const {
  if (!std::isfinite(opening)) fail("physics: the opening is not finite");
  const plan::Hand& hand = arm.hand();
  if (opening <= hand.opening_min) return *hand.finger_closed - full_force_travel(options);
  return (std::min(opening, hand.opening_max) - options.gripper.opening_closed()) / 2;
}

// ---- World ----------------------------------------------------------------------------------------------------------

World::World(const WorldOptions& options, const std::vector<Thing>& things)
    : impl_(std::make_unique<Impl>(options, things)) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

const WorldOptions& World::options() const {
  return impl_->options;
}
const std::vector<Thing>& World::things() const {
  return impl_->things;
}
const plan::Arm& World::arm() const {
  return impl_->arm;
}
double World::time() const {
  return impl_->simulation.data->time;
}

void World::command(const plan::JointVector& q, double opening) {
  impl_->check_joints(q, "command");
  impl_->wanted_finger = impl_->finger_target(opening);
  impl_->target = q;
}

void World::step(double seconds) {
  if (!(seconds >= 0 && seconds <= 1e6)) fail("physics: cannot let " + text_of(seconds) + " s pass");
  const plan::JointVector still(impl_->joints.size());
  const long steps = std::lround(seconds / impl_->options.timestep);
  for (long i = 0; i < steps; ++i) impl_->advance(still);
  impl_->simulation.check();
  impl_->refresh();
}

World::Tracking World::follow(const std::vector<plan::JointVector>& path, const std::vector<double>& times,
                              double opening, const std::function<bool()>& proceed) {
  if (path.empty() || path.size() != times.size()) fail("physics: a path has at least one sample, and a time for each");
  for (const plan::JointVector& q : path) impl_->check_joints(q, "path");
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!(i == 0 ? times[i] == 0 : times[i] > times[i - 1]) || !std::isfinite(times[i])) {
      fail("physics: times of a path must increase from 0");
    }
  }
  impl_->wanted_finger = impl_->finger_target(opening);

  Tracking tracking;
  const double timestep = impl_->options.timestep;
  const long steps = std::lround(std::ceil(times.back() / timestep));
  const long ask_every = std::max(1L, std::lround(kAskEvery / timestep));
  for (long i = 1; i <= steps; ++i) {
    const Waypoint point = waypoint_at(path, times, static_cast<double>(i) * timestep);
    impl_->target = point.q;
    impl_->advance(point.speeds);
    for (std::size_t k = 0; k < point.q.size(); ++k) {
      const double q = impl_->simulation.data->qpos[impl_->joints[k].position];
      tracking.error = std::max(tracking.error, std::abs(q - point.q[k]));
    }
    if (i % ask_every != 0 && i != steps) continue;
    impl_->simulation.check();
    impl_->refresh();
    if (proceed && !proceed()) return tracking;
  }
  impl_->target = path.back();
  tracking.finished = true;
  return tracking;
}

bool World::settle(double max_seconds) {
  const double timestep = impl_->options.timestep, end = time() + max_seconds;
  double still_since = time();
  while (time() < end - timestep / 2) {
    step(timestep);
    if (!all_at_rest(*this)) still_since = time();
    if (time() - still_since >= kStillTime) return true;
  }
  return false;
}

plan::JointVector World::joints() const {
  plan::JointVector q;
  for (const Driven& joint : impl_->joints) q.push_back(impl_->simulation.data->qpos[joint.position]);
  return q;
}

plan::JointVector World::velocities() const {
  plan::JointVector speeds;
  for (const Driven& joint : impl_->joints) speeds.push_back(impl_->simulation.data->qvel[joint.velocity]);
  return speeds;
}

double World::opening() const {
  const mjtNum* q = impl_->simulation.data->qpos;
  return impl_->options.gripper.opening_closed() + q[impl_->fingers[0].position] - q[impl_->fingers[1].position];
}

Pose World::tip() const {
  return impl_->simulation.body_pose(impl_->simulation.body(impl_->arm.tip()));
}

bool World::at_rest(std::size_t thing) const {
  return speed(thing) < kStillSpeed && spin(thing) < kStillSpin;
}

}  // namespace handhold::physics
