#include "held_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "handhold/collision.h"
#include "vec3.h"

namespace handhold::experiments {
namespace {

constexpr double kCell = 0.012;     // m; points in neighbouring cells hang together
constexpr double kAbove = 0.01;     // m; lower, points are the table's
constexpr double kBeside = 0.01;    // m; points so far from a handle's surface are its own
constexpr double kThick = 0.06;     // m; so far behind a surface there may be more of it
constexpr double kFarthest = 0.45;  // m; from the handle: what is farther is another thing

using Cell = std::array<int, 3>;

Cell cell_of(const Vector3& p) {
  Cell cell;
  for (std::size_t k = 0; k < 3; ++k) cell[k] = static_cast<int>(std::floor(p[k] / kCell));
  return cell;
}

/// From the segment of the handle's axis.
double from_axis(const Handle& handle, const Vector3& center, const Vector3& axis, const Vector3& p) {
  const Vector3 d = p - center;
  const double along = std::clamp(dot(d, axis), -handle.length / 2, handle.length / 2);
  return norm(d - along * axis);
}

/// One of the 27 cells about a cell, itself included.
Cell neighbour(const Cell& cell, int n) {
  return {cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1};
}

/// The cells that hang together with those of `front`.
std::set<Cell> grown(const std::set<Cell>& front, const std::map<Cell, Vector3>& cells) {
  std::set<Cell> taken = front;
  std::vector<Cell> edge(front.begin(), front.end());
  while (!edge.empty()) {
    const Cell cell = edge.back();
    edge.pop_back();
    for (int n = 0; n < 27; ++n) {
      const Cell next = neighbour(cell, n);
      if (cells.count(next) && taken.insert(next).second) edge.push_back(next);
    }
  }
  return taken;
}

plan::Body ball(const Vector3& middle, double radius) {
  plan::Body body;
  body.kind = plan::Shape::Kind::kSphere;
  body.radius = radius;
  body.T_base_body.t = middle;
  return body;
}

/// m; from a ball to the nearest of some bodies
double nearest(const std::vector<plan::Body>& bodies, const plan::Body& of) {
  double least = std::numeric_limits<double>::infinity();
  for (const plan::Body& body : bodies) {
    least = std::min(least, plan::distance(body, of.T_base_body.t) - of.radius);
  }
  return least;
}

}  // namespace

HeldObject::HeldObject(const CloudView& cloud, const plan::Pose& T_base_cloud, const Handle& handle, double table_top,
                       const plan::Pose& T_base_tip) {
  const Vector3 center = T_base_cloud.point(handle.center), axis = T_base_cloud.direction(handle.axis);
  const auto is_of_handle = [&](const Vector3& p) {
    return from_axis(handle, center, axis, p) < handle.radius + kBeside;
  };
  std::map<Cell, Vector3> cells;  // that may be the object's; one point each is enough
  std::set<Cell> front;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float* xyz = cloud.point(i);
    const Vector3 p = T_base_cloud.point({xyz[0], xyz[1], xyz[2]});
    if (!std::isfinite(p[0] + p[1] + p[2]) || p[2] < table_top + kAbove || norm(p - center) > kFarthest) continue;
    const Cell cell = cell_of(p);
    if (cells.emplace(cell, p).second && is_of_handle(p)) front.insert(cell);
  }
  const std::set<Cell> taken = grown(front, cells);

  const plan::Pose T_tip_base = T_base_tip.inverse();
  for (const Cell& cell : taken) {
    const Vector3& seen = cells.at(cell);
    points_.push_back({T_tip_base.point(seen)});
    // Of the handle it is known how thick it is.
    const double thick = is_of_handle(seen) ? 2 * handle.radius : kThick;
    const Vector3 away = normalized(seen - T_base_cloud.t);
    for (const double behind : {thick / 2, thick}) {
      const Vector3 hidden = seen + behind * away;
      if (hidden[2] > table_top + kAbove) points_.push_back({T_tip_base.point(hidden), true});
    }
  }
  bound();
  for (const Point& point : points_) {
    if (!point.is_guess) seen_middle_ = seen_middle_ + (1.0 / static_cast<double>(taken.size())) * point.p;
  }

  rest_.width = cloud.width;
  rest_.height = cloud.height;
  rest_.xyz.reserve(3 * cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float* xyz = cloud.point(i);
    const Vector3 p = T_base_cloud.point({xyz[0], xyz[1], xyz[2]});
    const bool is_own = std::isfinite(p[0] + p[1] + p[2]) && p[2] >= table_top + kAbove && taken.count(cell_of(p)) > 0;
    for (std::size_t k = 0; k < 3; ++k) rest_.xyz.push_back(is_own ? std::nanf("") : xyz[k]);
  }
}

/// A ball about the points.
void HeldObject::bound() {
  middle_ = {0, 0, 0};
  radius_ = 0;
  for (const Point& point : points_) middle_ = middle_ + (1.0 / static_cast<double>(points_.size())) * point.p;
  for (const Point& point : points_) radius_ = std::max(radius_, norm(point.p - middle_));
}

double HeldObject::reach() const {
  double farthest = 0;
  for (const Point& point : points_) farthest = std::max(farthest, norm(point.p));
  return farthest;
}

plan::Pose HeldObject::hung(const plan::Pose& T_base_tip) const {
  constexpr double kAcross = 0.8;  // of the turn's axis along the approach: the tips hold against that
  const Vector3 down = T_base_tip.inverse().direction({0, 0, -1});
  const Vector3 axis = cross(seen_middle_, down);
  if (!(norm(axis) > 0) || std::fabs(axis[2]) > kAcross * norm(axis)) return {};
  return sensor::rotation(normalized(axis), std::atan2(norm(axis), dot(seen_middle_, down)));
}

void HeldObject::leave_room(const plan::Pose& T_base_tip, const plan::Obstacles& obstacles,
                            const std::vector<plan::Body>& arm, const Care& care) {
  for (Point& point : points_) {
    const plan::Body here = ball(T_base_tip.point(point.p), 0);
    point.apart = obstacles.nearest(here, kFar).distance;
    point.apart_arm = std::min(kFar, nearest(arm, here));
  }
  const auto is_wrong = [&](const Point& point) {
    return point.is_guess && (point.apart < care.margin || point.apart_arm < care.arm_margin);
  };
  points_.erase(std::remove_if(points_.begin(), points_.end(), is_wrong), points_.end());
  bound();
}

double HeldObject::room(const plan::Pose& T_base_tip, const plan::Obstacles& obstacles,
                        const std::vector<plan::Body>& arm, const Care& care) const {
  if (points_.empty()) return kFar;
  const plan::Body all = ball(T_base_tip.point(middle_), radius_);
  const double from_all = obstacles.nearest(all, kFar).distance - care.margin;
  double arm_from_all = std::numeric_limits<double>::infinity();
  std::vector<plan::Body> near;  // of the arm's bodies
  for (const plan::Body& body : arm) {
    const double room = plan::distance(body, all.T_base_body.t) - all.radius - care.arm_margin;
    arm_from_all = std::min(arm_from_all, room);
    if (room <= 0) near.push_back(body);
  }
  if (from_all > 0 && arm_from_all > 0) return std::min(from_all, arm_from_all);
  constexpr double kSame = 1e-3;  // m; what is where it was may seem nearer by this
  for (const Point& point : points_) {
    if (point.is_guess && !care.guesses) continue;
    const plan::Body here = ball(T_base_tip.point(point.p), 0);
    if (from_all <= 0 && obstacles.within(here, std::min(care.margin, point.apart - kSame))) return -1;
    if (!near.empty() && nearest(near, here) < std::min(care.arm_margin, point.apart_arm - kSame)) return -1;
  }
  return 0;
}

}  // namespace handhold::experiments
