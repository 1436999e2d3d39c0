#include "picking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "text.h"
#include "vec3.h"

namespace handhold::experiments {
namespace {

using evaluation::format;

constexpr double kPi = 3.141592653589793;
constexpr double kDrop = 0.002;                  // m; things start so far above the table
constexpr double kBesidePart = 0.003;            // m; of the fingers, on each side
constexpr double kPathClearances[] = {0.03, 0};  // m; the first with a grasp: not all was seen
constexpr double kSamePlace = 0.1;               // m; of handles so near, the longer one first
constexpr double kLift = 0.2;                    // m; what is heavy turns in the hand, and hangs below it
constexpr double kSettle = 4;                    // s; at most
constexpr double kClosing = 0.8;                 // s; the fingers need for their stroke, and to press
constexpr double kCarrySpeed = 0.2;              // share of the joints' limits, with something in the hand
constexpr int kShakes = 6;
constexpr double kShake = 0.7, kShakeSpeed = 0.6;  // rad; share of the wrist's limit
constexpr int kLooks = 3, kMoreSamples = 4;        // where there is no grasp, more samples may find one
constexpr double kTableHeight = 0.04;              // m; thickness of the board

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

plan::PlannerOptions planner_options(double path_clearance) {
  plan::PlannerOptions options;
  options.path_clearance = path_clearance;
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
    case Ending::kNoWay:
      return "no way";
    case Ending::kBesideBox:
      return "beside the box";
    case Ending::kBrokeDown:
      return "broke down";
  }
  return "";
}

Workplace workplace(const plan::ElectricGripper& gripper) {
  Workplace place;
  place.world.gripper = gripper;
  place.world.table.size = {0.87, 1.2, kTableHeight};
  place.world.table.T_world_table = sensor::translation(0.865, 0, -0.15 - kTableHeight / 2);
  place.world.bin.inner = {0.6, 0.6, 0.3};
  place.world.bin.wall = 0.03;
  place.world.bin.T_world_bin = sensor::translation(0.35, -0.97, -0.45);
  // Scenes are seen from their -y; the robot looks along +x. The table's top is z = -0.15. Its near edge is before what
  // Baxter's pedestal takes up; nothing sticks out over it.
  place.T_base_scene = sensor::translation(0.78, -0.1, -0.15) * sensor::rotation({0, 0, 1}, -kPi / 2);
  place.T_base_camera = sensor::look_at({0.15, 0, 0.38}, {0.78, -0.1, -0.08});
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
      carrier_(world_.arm(), place_.world.bin, known_bodies(place_.world)),
      at_(world_.arm().rest()) {
  for (const double path_clearance : kPathClearances) {
    planners_.emplace_back(world_.arm(), planner_options(path_clearance));
    for (const auto& [name, body] : known_bodies(place_.world)) planners_.back().obstacles().add(name, body);
  }
}

bool Picker::settle() try { return world_.settle(kSettle); } catch (const std::runtime_error&) {
  return false;  // the next attempt says so
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
  look_.own = plan::bodies_of(world_.arm(), at_);
  plan::CloudObstacleOptions seen;
  seen.own = look_.own;
  for (plan::GraspPlanner& planner : planners_) {
    planner.obstacles().set_cloud(look_.cloud.view(), place_.T_base_camera, seen);
  }
  for (int i = 0; i < kLooks && look_.plan.grasps.empty(); ++i) {
    look_.result = Localizer(options).localize(look_.cloud.view());
    for (const plan::GraspPlanner& planner : planners_) {
      look_.plan = planner.plan(look_.result.handles, place_.T_base_camera);
      if (!look_.plan.grasps.empty()) break;
    }
    options.samples *= kMoreSamples;
  }
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
    const double far = norm(world_.center_of_mass(i) - p);
    if (far < least) least = far, best = i;
  }
  return best;
}

void Picker::follow(const std::vector<plan::JointVector>& path, const std::vector<double>& times, double opening) {
  world_.follow(path, times, opening);
  at_ = path.back();
  ways_.push_back(path);
}

void Picker::go(const plan::JointVector& to, double opening) {
  if (to == at_) return;
  const std::vector<plan::JointVector> path = planners_.front().straight(at_, to);
  follow(path, planners_.front().times(path, kCarrySpeed), opening);
}

/// Goes the last of its ways again, backwards, until only so many are left.
void Picker::go_back(std::size_t ways, double opening) {
  for (; ways_.size() > ways; ways_.pop_back()) {
    const std::vector<plan::JointVector> back(ways_.back().rbegin(), ways_.back().rend());
    world_.follow(back, planners_.front().times(back, kCarrySpeed), opening);
    at_ = back.back();
  }
}

/// With an empty hand: straight, if that way is clear, or else as it came, as far as it has to.
void Picker::go_home(const plan::JointVector& home) {
  while (!ways_.empty() && !carrier_.is_clear(at_, home)) {
    go_back(ways_.size() - 1, world_.arm().hand().opening_max);
  }
  go(home, world_.arm().hand().opening_max);
}

void Picker::open(double opening) {
  world_.command(at_, opening);
  world_.step(kClosing);
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
    const std::vector<plan::JointVector> path = planners_.front().straight(at_, turned);
    follow(path, planners_.front().times(path, kShakeSpeed), world_.arm().hand().opening_max);
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

/// Lifts what is between the fingers, carries it to the box, lets go and goes back. Where there is no way to the box,
/// puts it down again. What became of it, in words too.
std::pair<Ending, std::string> Picker::deliver(std::size_t thing, const plan::Grasp& grasp) {
  const physics::Table& table = place_.world.table;
  const HeldObject object(look_.cloud.view(), place_.T_base_camera, look_.result.handles[grasp.handle],
                          table.T_world_table.t[2] + table.size[2] / 2, grasp.grasp);
  carrier_.hold(object, place_.T_base_camera, look_.own);
  const std::string& name = world_.things()[thing].name;
  follow(grasp.lift_path, grasp.lift_times, 0);
  const bool lifted = world_.held(thing);
  std::optional<Carrier::Way> way;
  if (lifted) way = carrier_.to_box(at_, grasp.path.front());
  if (lifted && !way) {
    go_back(1, 0);
    open(grasp.opening);
    go_back(0, grasp.opening);
    settle();
    return {Ending::kNoWay, name + " was lifted, and put down again"};
  }
  if (way) {
    for (const plan::JointVector& stop : way->stops) go(stop, 0);
    // Whatever falls from here on falls into the box.
    if (const auto down = carrier_.turned_down(at_)) go(*down, 0);
  }
  const bool carried = way && world_.held(thing);
  const Vector3 let_go = world_.center_of_mass(thing);
  open(world_.arm().hand().opening_max);
  shake_off(thing);
  go_home(grasp.path.front());
  settle();
  const std::string by = way && way->care != Care::kAmple ? format(" (way: %s)", to_string(way->care)) : "";
  if (world_.in_bin(thing)) return {Ending::kGrasped, name + by};
  if (!lifted) return {Ending::kSlipped, name + " was lost while it was lifted"};
  if (!carried) return {Ending::kSlipped, name + " was lost on the way to the box" + by};
  const Vector3& box = place_.world.bin.T_world_bin.t;
  return {Ending::kBesideBox, format("%s was let go %.0f mm beside the middle of the box%s", name.c_str(),
                                     1000 * std::hypot(let_go[0] - box[0], let_go[1] - box[1]), by.c_str())};
}

std::pair<Ending, std::string> Picker::act(std::optional<std::size_t>& thing) {
  if (look_.result.handles.empty()) return {Ending::kNotLocalized, "no handle"};
  if (look_.plan.grasps.empty()) return {Ending::kNoPlan, joined(look_.plan.rejected)};
  const plan::Grasp& grasp = look_.plan.grasps.front();
  follow(grasp.path, grasp.times, grasp.opening);
  thing = nearest_to(grasp.grasp.t);
  open(0);
  if (const auto between = held()) {
    thing = between;
    return deliver(*between, grasp);
  }
  const double closed_to = world_.opening();
  open(grasp.opening);
  go_back(0, grasp.opening);
  settle();
  return {Ending::kMissed, format("closed to %.1f mm on a part of %.1f mm", 1000 * closed_to, 1000 * grasp.width)};
}

Attempt Picker::attempt(std::uint64_t seed) {
  Attempt attempt;
  const double begin = world_.time();
  std::vector<plan::Pose> before;
  for (std::size_t i = 0; i < world_.things().size(); ++i) before.push_back(world_.pose(i));
  ways_.clear();
  try {
    see(seed);
    std::tie(attempt.ending, attempt.why) = act(attempt.thing);
  } catch (const std::runtime_error& error) {
    attempt.ending = Ending::kBrokeDown;
    attempt.why = error.what();
  }
  attempt.seconds = world_.time() - begin;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!world_.in_bin(i)) attempt.pushed = std::max(attempt.pushed, norm(before[i].t - world_.pose(i).t));
  }
  return attempt;
}

}  // namespace handhold::experiments
