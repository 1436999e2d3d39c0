#include "carrier.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "vec3.h"

namespace handhold::experiments {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kAboveBox = 0.06;  // m; over the rim, of what hangs from the hand
constexpr double kHangs = 0.25;     // m; so far it may hang at least: not all of it was seen
constexpr double kMostTilt = 0.35;  // rad; what hangs from the hand stays between the fingertips
constexpr double kOverBox = 0.15;   // m; about the middle of the box
constexpr double kFine = 0.008;     // m; what is held moves no farther between two places where it is looked at

plan::PlannerOptions clearances(double hand, double arm) {
  plan::PlannerOptions options;
  options.hand_clearance = hand;
  options.arm_clearance = arm;
  return options;
}

HeldObject::Care of_held(Care care) {
  return care == Care::kNarrow ? HeldObject::Care{0.005, 0.005, false} : HeldObject::Care{0.02, 0.01, true};
}

double largest_difference(const plan::JointVector& a, const plan::JointVector& b) {
  double largest = 0;
  for (std::size_t j = 0; j < a.size(); ++j) largest = std::max(largest, std::fabs(a[j] - b[j]));
  return largest;
}

}  // namespace

const char* to_string(Care care) {
  switch (care) {
    case Care::kAmple:
      return "ample room";
    case Care::kAsTaken:
      return "as taken";
    case Care::kNarrow:
      return "narrow";
    case Care::kArmOnly:
      return "with the arm clear only";
  }
  return "";
}

Carrier::Carrier(const plan::Arm& arm, const physics::Bin& bin,
                 const std::vector<std::pair<std::string, plan::Body>>& known)
    : arm_(arm), bin_(bin), ample_(arm, clearances(0.03, 0.03)), narrow_(arm, clearances(0.005, 0.015)) {
  for (const auto& [name, body] : known) {
    ample_.obstacles().add(name, body);
    narrow_.obstacles().add(name, body);
  }
  const std::vector<plan::Pose> open = arm.link_poses(arm.rest(), arm.hand().opening_max);
  const std::vector<plan::Pose> closed = arm.link_poses(arm.rest(), arm.hand().opening_min);
  for (std::size_t link = 0; link < open.size(); ++link) is_finger_.push_back(open[link].t != closed[link].t);
}

void Carrier::hold(const HeldObject& object, const plan::Pose& T_base_cloud, const std::vector<plan::Body>& own) {
  held_ = object;
  plan::CloudObstacleOptions options;
  options.own = own;
  ample_.obstacles().set_cloud(held_.rest().view(), T_base_cloud, options);
  narrow_.obstacles().set_cloud(held_.rest().view(), T_base_cloud, options);
}

/// Bodies of the arm that do not touch what the hand holds: all but the fingers. A handle that turns into the palm is
/// pried out of them.
std::vector<plan::Body> Carrier::arm_bodies(const plan::JointVector& q) const {
  const std::vector<plan::Pose> links = arm_.link_poses(q);
  std::vector<plan::Body> bodies;
  for (const plan::Shape& shape : arm_.shapes()) {
    if (!is_finger_[shape.link]) bodies.push_back(plan::placed(shape, links[shape.link]));
  }
  return bodies;
}

/// What is held is looked at wherever it could have come too near since the place before, or every kFine. As it hangs
/// it may be near to something at first, but not again once it was clear.
bool Carrier::held_hits(const plan::JointVector& from, const plan::JointVector& to, Care care) const {
  double whole = 0;  // m; nothing moves farther
  const double reach = held_.reach();
  for (std::size_t j = 0; j < from.size(); ++j) whole += (arm_.sweeps()[j] + reach) * std::fabs(to[j] - from[j]);
  const plan::Obstacles& obstacles = planner(care).obstacles();
  bool hung_clear = care != Care::kAmple;
  for (double way = 0;;) {
    const double share = whole > 0 ? std::min(1.0, way / whole) : 1;
    plan::JointVector q = from;
    for (std::size_t j = 0; j < q.size(); ++j) q[j] += share * (to[j] - from[j]);
    const std::vector<plan::Body> bodies = arm_bodies(q);
    const plan::Pose tip = arm_.forward(q);
    double room = held_.room(tip, obstacles, bodies, of_held(care));
    if (room < 0) return true;
    if (care == Care::kAmple) {
      const double hung_room = held_.room(tip * held_.hung(tip), obstacles, bodies, of_held(care));
      if (hung_room < 0 && hung_clear) return true;
      hung_clear = hung_clear || hung_room >= 0;
      room = std::min(room, hung_room);
    }
    if (share >= 1) return !hung_clear;
    way += std::max(room, kFine);
  }
}

bool Carrier::is_blocked(const plan::JointVector& from, const plan::JointVector& to, Care care) const {
  if (from == to) return false;
  if (care == Care::kAmple && tilt(from, to) > kMostTilt) return true;
  const plan::GraspPlanner& planner = this->planner(care);
  const bool careful = care != Care::kArmOnly;
  return planner.hit(planner.straight(from, to), 0, careful) || (careful && held_hits(from, to, care));
}

bool Carrier::is_clear(const plan::JointVector& from, const plan::JointVector& to) const {
  const plan::GraspPlanner& planner = this->planner(Care::kNarrow);
  return !planner.hit(planner.straight(from, to), arm_.hand().opening_max);
}

/// Where the way to the box may lead through, best first: the hand raised, drawn back, turned about the arm's mount
/// towards the box, as it was; each with several postures of the arm.
std::vector<plan::JointVector> Carrier::via(const plan::JointVector& start, const plan::JointVector& before) const {
  constexpr std::size_t kPostures = 4;
  const plan::Pose lifted = arm_.forward(start);
  const Vector3 &mount = arm_.mount(), out = lifted.t - mount, to_box = bin_.T_world_bin.t - mount;
  const double far = std::hypot(out[0], out[1]);
  const double side = out[0] * to_box[1] - out[1] * to_box[0] > 0 ? 1 : -1;
  std::vector<plan::JointVector> postures;
  for (const double turn : {0.0, 0.4}) {
    const plan::Pose turned = sensor::translation(mount[0], mount[1], 0) * sensor::rotation({0, 0, 1}, side * turn) *
                              sensor::translation(-mount[0], -mount[1], 0);
    for (const double back : {0.0, 0.1, 0.2, 0.3}) {
      for (const double higher : {0.2, 0.1, 0.0}) {
        plan::Pose pose = lifted;
        pose.t = pose.t + Vector3{-back * out[0] / far, -back * out[1] / far, higher};
        pose = turned * pose;
        if (turn == 0 && back == 0 && higher == 0) postures.push_back(start);
        plan::IkOptions ik;
        ik.reference = start;
        ik.restarts = 12;
        ik.fallback_restarts = 0;
        arm_.inverse_all(pose, kPostures, ik, postures);
      }
    }
  }
  postures.push_back(before);
  return postures;
}

/// How far (rad) the hand tilts at most on a straight way, from where it is at its beginning.
double Carrier::tilt(const plan::JointVector& from, const plan::JointVector& to) const {
  const auto down = [&](const plan::JointVector& q) { return arm_.forward(q).inverse().direction({0, 0, -1}); };
  const Vector3 before = down(from);
  double least = 1;
  for (const plan::JointVector& q : ample_.straight(from, to)) least = std::min(least, dot(before, down(q)));
  return std::acos(std::clamp(least, -1.0, 1.0));
}

/// Joint positions for the hand above the middle of the box, with one of some orientations.
std::vector<plan::JointVector> Carrier::over_box(const std::vector<plan::Pose>& orientations,
                                                 const plan::JointVector& from) const {
  std::vector<plan::JointVector> solutions;
  for (plan::Pose pose : orientations) {
    pose.t = bin_.T_world_bin.t + Vector3{0, 0, bin_.inner[2] + kAboveBox + std::max(kHangs, held_.reach())};
    plan::IkOptions ik;
    ik.reference = from;
    ik.restarts = 6;
    ik.fallback_restarts = 0;
    if (const auto q = arm_.inverse(pose, ik)) solutions.push_back(*q);
  }
  return solutions;
}

/// Postures above the box to carry to, best first. The hand stays as it is, turned about the vertical: what hangs from
/// it would roll between the fingertips and out of them when it tilted. Where it cannot, it points down.
std::vector<plan::JointVector> Carrier::ends(const plan::JointVector& from) const {
  constexpr int kTurns = 24;
  constexpr double kTilt = 0.2;  // rad; ways that tilt the hand no more than that are equally good
  const plan::Pose as_it_is = arm_.forward(from), down = sensor::rotation({1, 0, 0}, kPi);
  std::vector<plan::JointVector> all;
  for (const plan::Pose& pose : {as_it_is, down}) {
    std::vector<plan::Pose> orientations;
    for (int i = 0; i < kTurns; ++i) orientations.push_back(sensor::rotation({0, 0, 1}, 2 * kPi * i / kTurns) * pose);
    std::vector<std::tuple<double, double, plan::JointVector>> keyed;
    for (plan::JointVector& q : over_box(orientations, from)) {
      keyed.emplace_back(std::floor(tilt(from, q) / kTilt), largest_difference(from, q), std::move(q));
    }
    std::sort(keyed.begin(), keyed.end());
    for (auto& [tilt, way, q] : keyed) all.push_back(std::move(q));
  }
  return all;
}

bool Carrier::stays_over_box(const plan::JointVector& from, const plan::JointVector& to) const {
  const std::vector<plan::JointVector> path = ample_.straight(from, to);
  return std::all_of(path.begin(), path.end(), [&](const plan::JointVector& q) {
    const Vector3 d = arm_.forward(q).t - bin_.T_world_bin.t;
    return std::hypot(d[0], d[1]) < kOverBox;
  });
}

std::optional<plan::JointVector> Carrier::turned_down(const plan::JointVector& over) const {
  constexpr int kTurns = 12;
  const plan::Pose down = sensor::rotation({1, 0, 0}, kPi);
  for (const double tilt : {0.0, 0.4, 0.8}) {
    std::vector<plan::Pose> orientations;
    for (int i = 0; i < kTurns; ++i) {
      for (int k = 0; k < (tilt > 0 ? kTurns : 1); ++k) {
        const auto turned = [](int n) { return sensor::rotation({0, 0, 1}, 2 * kPi * n / kTurns); };
        orientations.push_back(turned(i) * sensor::rotation({1, 0, 0}, tilt) * down * turned(k));
      }
    }
    std::vector<std::pair<double, plan::JointVector>> keyed;
    for (plan::JointVector& q : over_box(orientations, over)) {
      keyed.emplace_back(largest_difference(over, q), std::move(q));
    }
    std::sort(keyed.begin(), keyed.end());
    for (auto& [way, q] : keyed) {
      if (stays_over_box(over, q) && !is_blocked(over, q, Care::kArmOnly)) return std::move(q);
    }
  }
  return std::nullopt;
}

std::optional<Carrier::Way> Carrier::to_box(const plan::JointVector& start, const plan::JointVector& before) {
  held_.leave_room(arm_.forward(start), planner(Care::kAmple).obstacles(), arm_bodies(start), of_held(Care::kAmple));
  const std::vector<plan::JointVector> vias = via(start, before);
  std::vector<std::vector<plan::JointVector>> ends(vias.size());
  for (const Care care : kCares) {
    for (std::size_t i = 0; i < vias.size(); ++i) {
      if (is_blocked(start, vias[i], care)) continue;
      if (ends[i].empty()) ends[i] = this->ends(vias[i]);
      for (const plan::JointVector& end : ends[i]) {
        if (is_blocked(vias[i], end, care)) continue;
        Way way{{vias[i], end}, care};
        if (vias[i] == start) way.stops.erase(way.stops.begin());
        return way;
      }
    }
  }
  return std::nullopt;
}

}  // namespace handhold::experiments
