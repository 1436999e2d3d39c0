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
constexpr double kFarthest = 0.45;  // m; from the handle: what is farther is another thing

std::array<int, 3> cell_of(const Vector3& p) {
  std::array<int, 3> cell;
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
std::array<int, 3> neighbour(const std::array<int, 3>& cell, int n) {
  return {cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1};
}

}  // namespace

HeldObject::HeldObject(const CloudView& cloud, const plan::Pose& T_base_cloud, const Handle& handle, double table_top,
                       const plan::Pose& T_base_tip) {
  const Vector3 center = T_base_cloud.point(handle.center), axis = T_base_cloud.direction(handle.axis);
  const auto in_base = [&](std::size_t i) {
    const float* xyz = cloud.point(i);
    return T_base_cloud.point({xyz[0], xyz[1], xyz[2]});
  };
  std::map<Cell, Vector3> cells;  // one point each is enough
  std::vector<Cell> front;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3 p = in_base(i);
    if (!std::isfinite(p[0] + p[1] + p[2]) || p[2] < table_top + kAbove) continue;
    const Cell cell = cell_of(p);
    if (distance(p, center) > kFarthest) {
      others_.insert(cell);
    } else if (cells.emplace(cell, p).second && from_axis(handle, center, axis, p) < handle.radius + kBeside) {
      front.push_back(cell);
    }
  }
  std::set<Cell> taken(front.begin(), front.end());
  while (!front.empty()) {
    const Cell cell = front.back();
    front.pop_back();
    for (int n = 0; n < 27; ++n) {
      const Cell next = neighbour(cell, n);
      if (cells.count(next) && taken.insert(next).second) front.push_back(next);
    }
  }
  const plan::Pose T_tip_base = T_base_tip.inverse();
  for (const auto& [cell, point] : cells) {
    if (!taken.count(cell)) others_.insert(cell);
    if (taken.count(cell)) points_.push_back(T_tip_base.point(point));
  }
  rest_.width = cloud.width;
  rest_.height = cloud.height;
  rest_.xyz.reserve(3 * cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3 p = in_base(i);
    const bool is_own =
        std::isfinite(p[0] + p[1] + p[2]) && distance(p, center) <= kFarthest && taken.count(cell_of(p));
    const float* xyz = cloud.point(i);
    for (std::size_t k = 0; k < 3; ++k) rest_.xyz.push_back(is_own ? std::nanf("") : xyz[k]);
  }
  if (points_.empty()) return;
  for (const Vector3& p : points_) {
    for (std::size_t k = 0; k < 3; ++k) middle_[k] += p[k] / static_cast<double>(points_.size());
  }
  for (const Vector3& p : points_) radius_ = std::max(radius_, distance(p, middle_));
}

double HeldObject::below(const plan::Pose& T_base_tip) const {
  double lowest = 0;
  for (const Vector3& p : points_) lowest = std::min(lowest, T_base_tip.direction(p)[2]);
  return -lowest;
}

bool HeldObject::near(const plan::Pose& T_base_tip, const plan::Body& body, double margin) const {
  if (points_.empty() || plan::distance(body, T_base_tip.point(middle_)) > radius_ + margin) return false;
  return std::any_of(points_.begin(), points_.end(),
                     [&](const Vector3& p) { return plan::distance(body, T_base_tip.point(p)) < margin; });
}

bool HeldObject::near_others(const plan::Pose& T_base_tip) const {
  if (others_.empty()) return false;
  return std::any_of(points_.begin(), points_.end(), [&](const Vector3& p) {
    const Cell cell = cell_of(T_base_tip.point(p));
    for (int n = 0; n < 27; ++n) {
      if (others_.count(neighbour(cell, n))) return true;
    }
    return false;
  });
}

}  // namespace handhold::experiments
