#include "picking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "text.h"

namespace handhold::experiments {
namespace {

using evaluation::format;

constexpr double kPi = 3.141592653589793;
constexpr double kDrop = 0.002;        // m; things start so far above the table
constexpr double kBesidePart = 0.003;  // m; of the fingers, on each side
constexpr double kSamePlace = 0.1;     // m; of handles so near, the longer one first
constexpr double kLift = 0.2;          // m; what is heavy turns in the hand, and hangs below it
constexpr double kSettle = 4;          // s; at most
constexpr double kClosing = 0.8;       // s; the fingers need for their stroke, and to press
constexpr double kCarrySpeed = 0.2;    // share of the joints' limits, with something in the hand
constexpr int kShakes = 6;
constexpr double kShake = 0.7, kShakeSpeed = 0.6;  // rad; share of the wrist's limit
constexpr double kAboveBox = 0.06;                 // m; over the rim, of what hangs from the hand
constexpr double kHangs = 0.25;                    // m; so far it may hang at least: not all of it was seen
constexpr double kTableHeight = 0.04;              // m; thickness of the board

double distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

plan::Body box_at(const Vector3& size, const plan::Pose& T) {
  plan::Body body;
  body.kind = plan::Shape::Kind::kBox;
  body.size = size;
  body.T_base_body = T;
  return body;
}

/// Table and box are known: a robot is told where they stand.
std::vector<std::pair<std::string, plan::Body>> known_bodies(const physics::WorldOptions& world) {
  std::vector<std::pair<std::string, plan::Body>> bodies;
  bodies.emplace_back("table", box_at(world.table.size, world.table.T_world_table));
  const physics::Bin& bin = world.bin;
  const double x = bin.inner[0], y = bin.inner[1], z = bin.inner[2], w = bin.wall;
  const plan::Pose& T = bin.T_world_bin;
  bodies.emplace_back("box", box_at({x + 2 * w, y + 2 * w, w}, T * sensor::translation(0, 0, -w / 2)));
  for (const int side : {-1, 1}) {
    bodies.emplace_back("box", box_at({w, y + 2 * w, z}, T * sensor::translation(side * (x + w) / 2, 0, z / 2)));
    bodies.emplace_back("box", box_at({x + 2 * w, w, z}, T * sensor::translation(0, side * (y + w) / 2, z / 2)));
  }
  return bodies;
}

/// The far sides of things were not seen.
plan::PlannerOptions carrier_options() {
  plan::PlannerOptions options;
  options.hand_clearance = options.arm_clearance = 0.03;
  return options;
}

plan::PlannerOptions planner_options() {
  plan::PlannerOptions options;
  options.max_grasps = 1;
  options.finger_clearance = kBesidePart;
  options.lift = kLift;
  options.nearest_tolerance = kSamePlace;
  return options;
}

std::string joined(const std::vector<plan::Rejection>& rejected) {
  std::string text;
  for (const plan::Rejection& rejection : rejected) {
    text += (text.empty() ? "" : ", ") + std::string(plan::to_string(rejection.reason));
    if (!rejection.what.empty()) text += " (" + rejection.what + ")";
  }
  return text;
}

}  // namespace

const char* to_string(Ending ending) {
  switch (ending) {
    case Ending::kGrasped:
      return "grasped";
    case Ending::kNotLocalized:
      return "not localized";
    case Ending::kNoPlan:
      return "no plan";
    case Ending::kMissed:
      return "missed";
    case Ending::kSlipped:
      return "slipped";
    case Ending::kBesideBox:
      return "beside the box";
  }
  return "";
}

Workplace workplace(const plan::ElectricGripper& gripper) {
  Workplace place;
  place.world.gripper = gripper;
  place.world.table.size = {0.7, 1.2, kTableHeight};
  place.world.table.T_world_table = sensor::translation(0.85, 0, -0.15 - kTableHeight / 2);
  place.world.bin.inner = {0.6, 0.6, 0.3};
  place.world.bin.wall = 0.03;
  place.world.bin.T_world_bin = sensor::translation(0.35, -0.97, -0.45);
  // Scenes are seen from their -y; the robot looks along +x. The table's top is z = -0.15.
  place.T_base_scene = sensor::translation(0.72, -0.1, -0.15) * sensor::rotation({0, 0, 1}, -kPi / 2);
  place.T_base_camera = sensor::look_at({0.15, 0, 0.38}, {0.72, -0.1, -0.08});
  place.camera = sensor::CameraOptions::xtion();
  return place;
}

bool can_hold(const plan::ElectricGripper& gripper, double diameter, double clearance) {
  return diameter > std::max(0.0, gripper.opening_closed()) + 0.001 &&
         diameter + 2 * clearance <= gripper.opening_open();
}

plan::ElectricGripper gripper_for(const std::vector<std::string>& families) {
  plan::ElectricGripper best;
  std::size_t most = 0;
  using Tip = plan::ElectricGripper::Tip;
  // Hard tips first: flat ones hold better. The middle of the range first.
  for (const Tip tip : {Tip::kHard, Tip::kHalfRound}) {
    for (const int slot : {2, 1, 3, 4}) {
      plan::ElectricGripper gripper;
      gripper.slot = slot;
      gripper.tip = tip;
      std::size_t held = 0;
      for (const std::string& family : families) {
        const sensor::Object object = sensor::make_object(family);
        held += std::any_of(object.parts.begin(), object.parts.end(), [&](const sensor::Part& part) {
          return part.confidence >= 0.5 && can_hold(gripper, 2 * part.radius, kBesidePart);
        });
      }
      if (held > most) most = held, best = gripper;
    }
  }
  return best;
}

std::vector<physics::Thing> things_of(const sensor::SceneFile& file, const plan::Pose& T_base_scene) {
  std::vector<physics::Thing> things;
  for (const sensor::SceneObject& object : file.objects) {
    if (object.family == "board") continue;
    physics::Thing thing;
    thing.name = object.name;
    thing.family = object.family;
    thing.sizes = object.sizes;
    thing.material = object.material;
    thing.T_world_object = sensor::translation(0, 0, kDrop) * T_base_scene * object.T_world_object;
    for (const physics::ObjectFacts& facts : physics::paper_objects()) {
      if (facts.family == object.family) thing.mass = facts.mass, thing.friction = facts.friction;
    }
    things.push_back(thing);
  }
  return things;
}

Picker::Picker(const Workplace& place, const std::vector<physics::Thing>& things, const Options& localizer)
    : place_(place),
      world_(place.world, things),
      options_(localizer),
      planner_(world_.arm(), planner_options()),
      carrier_(world_.arm(), carrier_options()),
      at_(world_.arm().rest()) {
  for (const auto& [name, body] : known_bodies(place_.world)) {
    planner_.obstacles().add(name, body);
    carrier_.obstacles().add(name, body);
    known_.push_back(body);
  }
}

bool Picker::settle() {
  return world_.settle(kSettle);
}

std::vector<std::size_t> Picker::left() const {
  const physics::Table& table = place_.world.table;
  std::vector<std::size_t> things;
  for (std::size_t i = 0; i < world_.things().size(); ++i) {
    if (!world_.in_bin(i) && world_.center_of_mass(i)[2] > table.T_world_table.t[2]) things.push_back(i);
  }
  return things;
}

void Picker::see(std::uint64_t seed) {
  sensor::CameraOptions camera = place_.camera;
  camera.seed = seed;
  const sensor::Frame frame = sensor::DepthCamera(camera).capture(world_.scene(), place_.T_base_camera);
  Options options = options_;
  options.seed = seed;
  look_ = {};
  look_.cloud = frame.cloud;
  look_.T_base_camera = place_.T_base_camera;
  Localizer localizer(options);
  look_.result = localizer.localize(look_.cloud.view());
  plan::CloudObstacleOptions seen;
  seen.own = plan::bodies_of(world_.arm(), at_);
  planner_.obstacles().set_cloud(look_.cloud.view(), place_.T_base_camera, seen);
  look_.plan = planner_.plan(look_.result.handles, place_.T_base_camera);
}

std::optional<std::size_t> Picker::held() const {
  for (std::size_t i = 0; i < world_.things().size(); ++i) {
    if (world_.held(i)) return i;
  }
  return std::nullopt;
}

std::size_t Picker::nearest_to(const Vector3& p) const {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < world_.things().size(); ++i) {
    const double far = distance(world_.center_of_mass(i), p);
    if (far < least) least = far, best = i;
  }
  return best;
}

void Picker::go(const plan::JointVector& to, double opening) {
  if (to == at_) return;
  const std::vector<plan::JointVector> path = planner_.straight(at_, to);
  world_.follow(path, planner_.times(path, kCarrySpeed), opening);
  at_ = to;
}

/// Whether the arm without its hand would touch something on a way; or, `careful`, the hand or what it holds would.
bool Picker::is_blocked(const std::vector<plan::JointVector>& path, bool careful) const {
  constexpr double kMargin = 0.02, kOwnMargin = 0.01;  // m; of what is held: its far side was not seen
  if (!careful) return planner_.hit(path, 0, false).has_value();
  if (carrier_.hit(path, 0, true)) return true;
  const plan::Arm& arm = world_.arm();
  for (const plan::JointVector& q : path) {
    const plan::Pose tip = arm.forward(q);
    const auto is_near = [&](const plan::Body& body) { return held_object_.near(tip, body, kMargin); };
    if (std::any_of(known_.begin(), known_.end(), is_near) || held_object_.near_others(tip)) return true;
    const std::vector<plan::Pose> links = arm.link_poses(q);
    for (const plan::Shape& shape : arm.shapes()) {
      // The hand touches it.
      if (arm.link_joints()[shape.link] + 1 >= arm.joints().size()) continue;
      if (held_object_.near(tip, plan::placed(shape, links[shape.link]), kOwnMargin)) return true;
    }
  }
  return false;
}

/// Above the middle of the box. The hand points down, as far as the arm can: a closed handle slides off its fingers
/// then, and may hang on them otherwise. Or else as it was lifted, turned about the vertical.
std::optional<plan::JointVector> Picker::over_box(const plan::JointVector& from, bool careful) const {
  constexpr int kTurns = 12;
  const plan::Pose down = sensor::rotation({1, 0, 0}, kPi);
  plan::Pose as_lifted = world_.arm().forward(from);
  as_lifted.t = {0, 0, 0};
  const auto turned = [](const Vector3& axis, int i) { return sensor::rotation(axis, 2 * kPi * i / kTurns); };
  std::vector<std::vector<plan::Pose>> choices(4);
  for (int i = 0; i < kTurns; ++i) {
    choices[0].push_back(turned({0, 0, 1}, i) * down);
    choices[3].push_back(turned({0, 0, 1}, i) * as_lifted);
    for (int k = 0; k < kTurns; k += 2) {
      choices[1].push_back(turned({0, 0, 1}, i) * sensor::rotation({1, 0, 0}, 0.4) * down * turned({0, 0, 1}, k));
      choices[2].push_back(turned({0, 0, 1}, i) * sensor::rotation({1, 0, 0}, 0.8) * down * turned({0, 0, 1}, k));
    }
  }
  for (const std::vector<plan::Pose>& orientations : choices) {
    if (const auto q = nearest_over_box(orientations, from, careful)) return q;
  }
  return std::nullopt;
}

std::optional<plan::JointVector> Picker::nearest_over_box(const std::vector<plan::Pose>& orientations,
                                                          const plan::JointVector& from, bool careful) const {
  const physics::Bin& bin = place_.world.bin;
  const Vector3& floor = bin.T_world_bin.t;
  std::vector<std::pair<double, plan::JointVector>> solutions;
  for (plan::Pose pose : orientations) {
    pose.t = {floor[0], floor[1], floor[2] + bin.inner[2] + kAboveBox + std::max(kHangs, held_object_.reach())};
    plan::IkOptions ik;
    ik.reference = from;
    ik.restarts = 6;
    ik.fallback_restarts = 0;
    const auto q = world_.arm().inverse(pose, ik);
    if (!q) continue;
    double way = 0;
    for (std::size_t j = 0; j < q->size(); ++j) way = std::max(way, std::fabs((*q)[j] - from[j]));
    solutions.emplace_back(way, *q);
  }
  std::sort(solutions.begin(), solutions.end());
  for (const auto& [way, q] : solutions) {
    if (!is_blocked(planner_.straight(from, q), careful)) return q;
  }
  return std::nullopt;
}

/// To the box by way of where the hand is raised, as far as it can be: what is heavy turns in the hand, and hangs lower
/// than it was seen. Otherwise straight, or by way of where the hand is drawn back, or of where the arm was before;
/// with what is held clear of everything, or, if there is no such way, at least the arm. False: there is none at all.
bool Picker::carry(const plan::JointVector& home) {
  std::vector<plan::JointVector> by_way_of;
  const plan::Arm& arm = world_.arm();
  const plan::Pose lifted = arm.forward(at_);
  held_object_.correct(lifted);
  const double far = std::hypot(lifted.t[0] - arm.mount()[0], lifted.t[1] - arm.mount()[1]);
  for (const double back : {0.0, 0.1, 0.2, 0.3}) {
    for (const double higher : {0.2, 0.1, 0.0}) {
      plan::Pose pose = lifted;
      for (std::size_t k = 0; k < 2; ++k) pose.t[k] -= back * (lifted.t[k] - arm.mount()[k]) / far;
      pose.t[2] += higher;
      plan::IkOptions ik;
      ik.reference = at_;
      const std::optional<plan::JointVector> q = back == 0 && higher == 0 ? at_ : arm.inverse(pose, ik);
      if (q) by_way_of.push_back(*q);
    }
  }
  by_way_of.push_back(home);
  for (const bool careful : {true, false}) {
    for (const plan::JointVector& via : by_way_of) {
      if (via != at_ && is_blocked(planner_.straight(at_, via), careful)) continue;
      const auto over = over_box(via, careful);
      if (!over) continue;
      if (via != at_) go(via, 0);
      go(*over, 0);
      return true;
    }
  }
  return false;
}

/// What hangs on an open hand - a closed handle may, with its edge wedged against a finger - falls when the wrist turns
/// to and fro.
void Picker::shake_off(std::size_t thing) {
  const plan::JointVector q = at_;
  const plan::Joint& wrist = world_.arm().joints().back();
  for (int i = 0; i < kShakes && touches_hand(thing); ++i) {
    plan::JointVector turned = q;
    turned.back() = std::clamp(q.back() + (i % 2 ? -kShake : kShake), wrist.lower, wrist.upper);
    if (turned == at_) continue;
    const std::vector<plan::JointVector> path = planner_.straight(at_, turned);
    world_.follow(path, planner_.times(path, kShakeSpeed), world_.arm().hand().opening_max);
    at_ = turned;
  }
  world_.step(kClosing);
}

bool Picker::touches_hand(std::size_t thing) const {
  const std::vector<std::string> others = world_.touching(thing);
  const plan::Arm& arm = world_.arm();
  for (std::size_t link = 0; link < arm.links().size(); ++link) {
    if (arm.link_joints()[link] != arm.joints().size()) continue;
    if (std::count(others.begin(), others.end(), arm.links()[link])) return true;
  }
  return false;
}

/// Back the way that it came, with an open hand.
void Picker::retreat(const plan::Grasp& grasp) {
  world_.command(at_, grasp.opening);
  world_.step(kClosing);
  const std::vector<plan::JointVector> back(grasp.path.rbegin(), grasp.path.rend());
  world_.follow(back, planner_.times(back, kCarrySpeed), grasp.opening);
  at_ = back.back();
}

/// Lifts what is between the fingers, carries it to the box, lets go and goes back. What became of it, in words too.
std::pair<Ending, std::string> Picker::deliver(std::size_t thing, const plan::Grasp& grasp) {
  const physics::Table& table = place_.world.table;
  held_object_ = HeldObject(look_.cloud.view(), place_.T_base_camera, look_.result.handles[grasp.handle],
                            table.T_world_table.t[2] + table.size[2] / 2, grasp.grasp);
  carrier_.obstacles().set_cloud(held_object_.rest().view(), place_.T_base_camera);
  const plan::JointVector& home = grasp.path.front();
  const double open = world_.arm().hand().opening_max;
  world_.follow(grasp.lift_path, grasp.lift_times, 0);
  at_ = grasp.lift_path.back();
  const bool lifted = world_.held(thing);
  const bool led = lifted && carry(home);
  const bool carried = led && world_.held(thing);
  const Vector3 let_go = world_.center_of_mass(thing);
  world_.command(at_, open);
  world_.step(kClosing);
  shake_off(thing);
  go(home, open);
  settle();
  const std::string& name = world_.things()[thing].name;
  if (world_.in_bin(thing)) return {Ending::kGrasped, name};
  if (!lifted) return {Ending::kSlipped, name + " was lost while it was lifted"};
  if (!led) return {Ending::kNoPlan, name + " was lifted, but there was no way to the box"};
  if (!carried) return {Ending::kSlipped, name + " was lost on the way to the box"};
  const Vector3& box = place_.world.bin.T_world_bin.t;
  return {Ending::kBesideBox, format("%s was let go %.0f mm beside the middle of the box", name.c_str(),
                                     1000 * std::hypot(let_go[0] - box[0], let_go[1] - box[1]))};
}

std::pair<Ending, std::string> Picker::act(std::optional<std::size_t>& thing) {
  if (look_.result.handles.empty()) return {Ending::kNotLocalized, "no handle"};
  if (look_.plan.grasps.empty()) return {Ending::kNoPlan, joined(look_.plan.rejected)};
  const plan::Grasp& grasp = look_.plan.grasps.front();
  world_.follow(grasp.path, grasp.times, grasp.opening);
  at_ = grasp.path.back();
  thing = nearest_to(grasp.grasp.t);
  world_.command(at_, 0);
  world_.step(kClosing);
  if (const auto between = held()) {
    thing = between;
    return deliver(*between, grasp);
  }
  const double closed_to = world_.opening();
  retreat(grasp);
  settle();
  return {Ending::kMissed, format("closed to %.1f mm on a part of %.1f mm", 1000 * closed_to, 1000 * grasp.width)};
}

Attempt Picker::attempt(std::uint64_t seed) {
  Attempt attempt;
  const double begin = world_.time();
  std::vector<plan::Pose> before;
  for (std::size_t i = 0; i < world_.things().size(); ++i) before.push_back(world_.pose(i));
  see(seed);
  std::tie(attempt.ending, attempt.why) = act(attempt.thing);
  attempt.seconds = world_.time() - begin;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!world_.in_bin(i)) attempt.pushed = std::max(attempt.pushed, distance(before[i].t, world_.pose(i).t));
  }
  return attempt;
}

}  // namespace handhold::experiments
