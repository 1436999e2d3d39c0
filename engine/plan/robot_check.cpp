// What the robot touches in a posture.
#include "robot_check.h"

#include <algorithm>
#include <cmath>

#include "bodies.h"
#include "random.h"
#include "vec3.h"

namespace handhold::plan {
namespace {

constexpr double kNearby = 1e-4;  // m; beyond what is within a clearance, rounding included
/// Between two samples at most half of this (m) of a clearance is given up.
constexpr double kShortest = 0.002;
/// Nearer (m) is touching: bodies that overlap are 0 apart, so that a clearance of 0 alone would let them.
constexpr double kTouch = 1e-6;

/// A capsule within the cylinder that is meant: Shape's contains it, and sticks out at both ends by its radius.
Shape inscribed(const Shape& shape) {
  Shape inner = shape;
  if (shape.kind != Shape::Kind::kCapsule) return inner;
  inner.radius = std::min(shape.radius, shape.length / 2);
  inner.length = shape.length - 2 * inner.radius;
  return inner;
}

}  // namespace

RobotCheck::RobotCheck(const Arm& arm, const Clearances& clearances)
    : arm_(arm), clearances_(clearances), tip_(arm.link_index(arm.tip())) {
  keep(clearances.hand, clearances.arm);
  for (const Shape& shape : arm_.shapes()) inscribed_.push_back(inscribed(shape));
  choose_pairs();
}

void RobotCheck::keep(double hand, double arm) {
  clearances_.hand = std::max(hand, kTouch);
  clearances_.arm = std::max(arm, kTouch);
}

RobotCheck RobotCheck::with(double hand, double arm) const {
  RobotCheck other = *this;
  other.keep(hand, arm);
  return other;
}

/// How many of the arm's joints move a shape: a cylinder stays where it is when a joint turns about its own axis.
std::size_t RobotCheck::joints_that_move(const Shape& shape) const {
  constexpr double kStill = 1e-3;  // m, rad
  std::size_t joints = arm_.link_joints()[shape.link];
  const auto placed_at = [&](const JointVector& q) { return arm_.link_poses(q)[shape.link] * shape.T_link_shape; };
  const auto axis = [](const Pose& T) { return T.direction({0, 0, 1}); };
  const Pose before = placed_at(arm_.rest());
  for (; joints > 0 && shape.kind != Shape::Kind::kBox; --joints) {
    JointVector q = arm_.rest();
    q[joints - 1] += 1;
    const Pose after = placed_at(q);
    const bool turned = shape.kind == Shape::Kind::kCapsule && norm(cross(axis(before), axis(after))) > kStill;
    if (turned || norm(after.t - before.t) > kStill) break;
  }
  return joints;
}

/// Links that hang on each other touch there by design, and one joint between them keeps to limits that are made for
/// it. So it is where one joint alone moves the outer link's shape against another link of the arm: Baxter's upper arm,
/// a cylinder about its roll axis, runs into the rough shape of the shoulder where the arm itself still has a radian to
/// go. Left out are, too, those that touch at rest or nearly always.
void RobotCheck::choose_pairs() {
  const std::vector<Shape>& shapes = arm_.shapes();
  const std::vector<std::size_t>& joints = arm_.link_joints();
  std::vector<std::size_t> moved_by;
  for (const Shape& shape : shapes) moved_by.push_back(joints_that_move(shape));
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t a = 0; a < shapes.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const std::size_t of_a = joints[shapes[a].link], of_b = joints[shapes[b].link];
      const std::size_t inner = std::min(of_a, of_b), outer = std::max(of_a, of_b);
      const bool hang_together = outer <= inner + 1 || (inner > 0 && moved_by[of_a > of_b ? a : b] <= inner + 1);
      if (!hang_together) pairs.emplace_back(a, b);
    }
  }

  constexpr int kPostures = 200;
  constexpr std::uint64_t kStream = 0x5e1f;
  std::vector<int> touched(pairs.size(), 0);
  for (int i = 0; i <= kPostures; ++i) {
    JointVector q = arm_.rest();
    CounterRandom random(1, kStream, static_cast<std::uint64_t>(i));
    for (std::size_t j = 0; i > 0 && j < q.size(); ++j) {
      const Joint& joint = arm_.joints()[j];
      q[j] = joint.lower + random.uniform() * (joint.upper - joint.lower);
    }
    const std::vector<Pose> links = arm_.link_poses(q);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const Shape &a = inscribed_[pairs[k].first], &b = inscribed_[pairs[k].second];
      const bool touch = distance(placed(a, links[a.link]), placed(b, links[b.link])) <= clearances_.self;
      if (touch) touched[k] += i == 0 ? kPostures : 1;
    }
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (touched[k] < 0.95 * kPostures) pairs_.push_back(pairs[k]);
  }
}

std::string RobotCheck::name_of(const Obstacles& obstacles, const Obstacles::Nearest& nearest) const {
  return nearest.is_point ? "cloud" : obstacles.name(nearest.body);
}

std::optional<std::string> RobotCheck::hand(const Obstacles& obstacles, const Pose& T_base_tip, double opening) const {
  const std::vector<Pose> links = arm_.link_poses(arm_.rest(), opening);
  const Pose T_base_base = T_base_tip * links[tip_].inverse();
  for (const Shape& shape : arm_.shapes()) {
    if (!is_hand(shape)) continue;
    const Body body = placed(shape, T_base_base * links[shape.link]);
    if (!obstacles.within(body, clearances_.hand)) continue;
    return name_of(obstacles, obstacles.nearest(body, clearances_.hand + kNearby));
  }
  return std::nullopt;
}

std::optional<std::string> RobotCheck::itself(const std::vector<Pose>& T_base_link) const {
  std::vector<Core> cores;
  std::vector<double> reaches;  // m
  cores.reserve(inscribed_.size());
  reaches.reserve(inscribed_.size());
  for (const Shape& shape : inscribed_) {
    cores.push_back(core_of(placed(shape, T_base_link[shape.link])));
    reaches.push_back(reach(cores.back()));
  }
  for (const auto& [a, b] : pairs_) {
    // Balls about them first: most are far from each other.
    const Vector3 way = cores[a].T_base_core.t - cores[b].T_base_core.t;
    const double near = reaches[a] + reaches[b] + clearances_.self;
    if (dot(way, way) > near * near || distance(cores[a], cores[b]) > clearances_.self) continue;
    // The one that moves less is what the arm runs into.
    const std::size_t link_a = inscribed_[a].link, link_b = inscribed_[b].link;
    return arm_.links()[arm_.link_joints()[link_a] < arm_.link_joints()[link_b] ? link_a : link_b];
  }
  return std::nullopt;
}

RobotCheck::Clear RobotCheck::clearance(const Obstacles& obstacles, const std::vector<Pose>& T_base_link, bool hand,
                                        double limit) const {
  Clear clear{limit, {}};
  for (const Shape& shape : arm_.shapes()) {
    if (arm_.link_joints()[shape.link] == 0) continue;
    const bool of_hand = is_hand(shape);
    if (of_hand && !hand) continue;
    const double required = of_hand ? clearances_.hand : clearances_.arm;
    const Obstacles::Nearest nearest =
        obstacles.nearest(placed(shape, T_base_link[shape.link]), clear.distance + required);
    if (!(nearest.distance < clear.distance + required)) continue;
    clear.distance = nearest.distance - required;
    if (clear.distance >= 0) continue;
    clear.what = name_of(obstacles, nearest);
    return clear;
  }
  return clear;
}

std::optional<GraspPlanner::Hit> RobotCheck::posture(const Obstacles& obstacles, const JointVector& q, double opening,
                                                     bool hand) const {
  const std::vector<Pose> links = arm_.link_poses(q, opening);
  const Clear clear = clearance(obstacles, links, hand, 0);
  if (clear.distance < 0) return GraspPlanner::Hit{Reason::kArmHits, clear.what};
  if (const auto link = itself(links)) return GraspPlanner::Hit{Reason::kArmHitsItself, *link};
  return std::nullopt;
}

/// How far (m) anything moves at most from one posture to another.
double RobotCheck::way(const JointVector& from, const JointVector& to) const {
  double way = 0;
  for (std::size_t j = 0; j < from.size(); ++j) way += arm_.sweeps()[j] * std::fabs(to[j] - from[j]);
  return way;
}

/// A sample needs no more room than the longer way to its neighbours: farther obstacles are not looked for.
std::optional<GraspPlanner::Hit> RobotCheck::path(const Obstacles& obstacles, const std::vector<JointVector>& path,
                                                  double opening, bool hand) const {
  std::vector<double> room;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::vector<Pose> links = arm_.link_poses(path[i], opening);
    const double before = i > 0 ? way(path[i - 1], path[i]) : 0;
    const double after = i + 1 < path.size() ? way(path[i], path[i + 1]) : 0;
    const Clear clear = clearance(obstacles, links, hand, std::max(before, after));
    if (clear.distance < 0) return GraspPlanner::Hit{Reason::kArmHits, clear.what};
    if (const auto link = itself(links)) return GraspPlanner::Hit{Reason::kArmHitsItself, *link};
    room.push_back(clear.distance);
  }
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (const auto hit = between(obstacles, path[i - 1], room[i - 1], path[i], room[i], opening, hand)) return hit;
  }
  return std::nullopt;
}

/// On the way nothing moves farther than the sum of the joints' sweeps, and of that at most half from the nearer end.
/// Where the clearances at both ends leave less room, the way is cut in two.
std::optional<GraspPlanner::Hit> RobotCheck::between(const Obstacles& obstacles, const JointVector& from,
                                                     double room_from, const JointVector& to, double room_to,
                                                     double opening, bool hand) const {
  const double whole = way(from, to);
  // The room is what is left beyond the required clearance.
  if (whole <= room_from + room_to + kShortest) return std::nullopt;
  JointVector middle(from.size());
  for (std::size_t j = 0; j < from.size(); ++j) middle[j] = (from[j] + to[j]) / 2;
  const Clear clear = clearance(obstacles, arm_.link_poses(middle, opening), hand, whole / 2);
  if (clear.distance < 0) return GraspPlanner::Hit{Reason::kArmHits, clear.what};
  const auto first = between(obstacles, from, room_from, middle, clear.distance, opening, hand);
  return first ? first : between(obstacles, middle, clear.distance, to, room_to, opening, hand);
}

}  // namespace handhold::plan
