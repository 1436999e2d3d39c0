#include "held_object.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "handhold/collision.h"

namespace handhold::experiments {
namespace {

constexpr double kCell = 0.012;     // m; points in neighbouring cells hang together
constexpr double kAbove = 0.01;     // m; lower, points are the table's
constexpr double kBeside = 0.01;    // m; points so far from a handle's surface are its own
constexpr double kThick = 0.06;     // m; so far behind a surface there may be more of it
constexpr int kFewest = 4;          // points of a cell that is not a speck
constexpr double kFarthest = 0.45;  // m; from the handle: what is farther is another thing

using Cell = std::array<int, 3>;

Cell cell_of(const Vector3& p) {
  Cell cell;
  for (std::size_t k = 0; k < 3; ++k) cell[k] = static_cast<int>(std::floor(p[k] / kCell));
  return cell;
}
double distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// From the segment of the handle's axis.
double from_axis(const Handle& handle, const Vector3& center, const Vector3& axis, const Vector3& p) {
  Vector3 d{};
  double along = 0;
  for (std::size_t k = 0; k < 3; ++k) d[k] = p[k] - center[k], along += d[k] * axis[k];
  along = std::clamp(along, -handle.length / 2, handle.length / 2);
  return std::hypot(d[0] - along * axis[0], d[1] - along * axis[1], d[2] - along * axis[2]);
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

}  // namespace

HeldObject::HeldObject(const CloudView& cloud, const plan::Pose& T_base_cloud, const Handle& handle, double table_top,
                       const plan::Pose& T_base_tip) {
  const Vector3 center = T_base_cloud.point(handle.center), axis = T_base_cloud.direction(handle.axis);
  const auto is_of_handle = [&](const Vector3& p) {
    return from_axis(handle, center, axis, p) < handle.radius + kBeside;
  };
  std::map<Cell, Vector3> cells;  // that may be the object's; one point each is enough
  std::map<Cell, int> counts;
  std::set<Cell> front;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float* xyz = cloud.point(i);
    const Vector3 p = T_base_cloud.point({xyz[0], xyz[1], xyz[2]});
    if (!std::isfinite(p[0] + p[1] + p[2]) || p[2] < table_top + kAbove) continue;
    const Cell cell = cell_of(p);
    ++counts[cell];
    if (distance(p, center) > kFarthest) continue;
    if (cells.emplace(cell, p).second && is_of_handle(p)) front.insert(cell);
  }
  const std::set<Cell> taken = grown(front, cells);

  const plan::Pose T_tip_base = T_base_tip.inverse();
  for (const Cell& cell : taken) {
    const Vector3& seen = cells.at(cell);
    points_.push_back(T_tip_base.point(seen));
    // Of the handle it is known how thick it is.
    const double thick = is_of_handle(seen) ? 2 * handle.radius : kThick, far = distance(seen, T_base_cloud.t);
    for (const double behind : {thick / 2, thick}) {
      Vector3 hidden = seen;
      for (std::size_t k = 0; k < 3; ++k) hidden[k] += behind * (seen[k] - T_base_cloud.t[k]) / far;
      if (hidden[2] > table_top + kAbove) points_.push_back(T_tip_base.point(hidden));
    }
  }
  for (const auto& [cell, count] : counts) {
    if (count >= kFewest && !taken.count(cell)) others_.insert(cell);
  }
  bound();
  leave_rest(cloud, T_base_cloud, table_top, taken);
}

/// A ball about the points.
void HeldObject::bound() {
  if (points_.empty()) return;
  for (const Vector3& p : points_) {
    for (std::size_t k = 0; k < 3; ++k) middle_[k] += p[k] / static_cast<double>(points_.size());
  }
  for (const Vector3& p : points_) radius_ = std::max(radius_, distance(p, middle_));
}

void HeldObject::leave_rest(const CloudView& cloud, const plan::Pose& T_base_cloud, double table_top,
                            const std::set<Cell>& taken) {
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

double HeldObject::reach() const {
  double farthest = 0;
  for (const Vector3& p : points_) farthest = std::max(farthest, distance(p, {0, 0, 0}));
  return farthest;
}

bool HeldObject::near(const plan::Pose& T_base_tip, const plan::Body& body, double margin) const {
  if (points_.empty() || plan::distance(body, T_base_tip.point(middle_)) > radius_ + margin) return false;
  return std::any_of(points_.begin(), points_.end(),
                     [&](const Vector3& p) { return plan::distance(body, T_base_tip.point(p)) < margin; });
}

bool HeldObject::is_near_others(const Vector3& p) const {
  const Cell cell = cell_of(p);
  for (int n = 0; n < 27; ++n) {
    if (others_.count(neighbour(cell, n))) return true;
  }
  return false;
}

bool HeldObject::near_others(const plan::Pose& T_base_tip) const {
  return !others_.empty() && std::any_of(points_.begin(), points_.end(),
                                         [&](const Vector3& p) { return is_near_others(T_base_tip.point(p)); });
}

void HeldObject::correct(const plan::Pose& T_base_tip) {
  const auto is_wrong = [&](const Vector3& p) { return is_near_others(T_base_tip.point(p)); };
  points_.erase(std::remove_if(points_.begin(), points_.end(), is_wrong), points_.end());
}

}  // namespace handhold::experiments
