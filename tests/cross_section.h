// The section of a mesh across a line, as tests look at it: what surrounds a point there, and how round that is.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "convex_hull.h"
#include "sensor_test_helpers.h"

namespace handhold::sensor {

/// The outline about a point, by rays in evenly spread directions of the plane: where the solid, or the union of
/// solids, first ends; the hollow within a wall counts as solid.
struct Outline {
  static constexpr std::size_t kRays = 360;
  bool closed = true;             ///< every ray meets an end
  bool solid = true;              ///< the point itself is within matter
  std::vector<double> distances;  ///< m; one a ray
  Eigen::Vector3d x, y;           ///< of the plane

  static constexpr double kOffset = 0.37;  // no ray along an axis, where meshes have vertices
  static Eigen::Vector2d direction(std::size_t i) {
    const double angle = 6.283185307179586 * (static_cast<double>(i) + kOffset) / kRays;
    return {std::cos(angle), std::sin(angle)};
  }
  Eigen::Vector2d point(std::size_t i) const { return distances[i] * direction(i); }
};

/// Section of `mesh` through `center` across `axis`, which need not be a unit vector.
inline Outline outline_about(const Mesh& mesh, const Eigen::Vector3d& center, const Eigen::Vector3d& axis) {
  Outline outline;
  const Eigen::Vector3d up = axis.normalized();
  outline.x = up.unitOrthogonal();
  outline.y = up.cross(outline.x);
  struct End {
    double along;
    int change;  // of the number of solids
    bool operator<(const End& other) const { return along < other.along; }
  };
  std::vector<std::vector<End>> rays(Outline::kRays);
  // a -> b, the solid to the left of it.
  const auto add_segment = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    constexpr double kTurn = 6.283185307179586, kStep = kTurn / Outline::kRays;
    constexpr long n = Outline::kRays;
    const bool leaves = a[0] * b[1] - a[1] * b[0] > 0;
    const Eigen::Vector2d &right = leaves ? a : b, &left = leaves ? b : a;
    // Only the rays between its two ends, the short way around.
    const double from = std::atan2(right[1], right[0]);
    double to = std::atan2(left[1], left[0]);
    if (to < from) to += kTurn;
    for (auto k = static_cast<long>(std::ceil(from / kStep - Outline::kOffset));
         (static_cast<double>(k) + Outline::kOffset) * kStep < to; ++k) {
      const auto i = static_cast<std::size_t>((k % n + n) % n);
      const Eigen::Vector2d d = Outline::direction(i);
      const double from_a = d[0] * a[1] - d[1] * a[0], from_b = d[0] * b[1] - d[1] * b[0];
      rays[i].push_back({d.dot(a + from_a / (from_a - from_b) * (b - a)), leaves ? -1 : 1});
    }
  };
  // A little off the vertices, which meshes have at round numbers.
  const double level = up.dot(center) + 1.234e-7;
  std::vector<double> heights;
  heights.reserve(mesh.vertices.size());
  for (const Vector3& v : mesh.vertices) heights.push_back(up.dot(eigen(v)) - level);
  for (const auto& t : mesh.triangles) {
    if ((heights[t[0]] > 0) == (heights[t[1]] > 0) && (heights[t[1]] > 0) == (heights[t[2]] > 0)) continue;
    Eigen::Vector2d a, b;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = t[k], to = t[(k + 1) % 3];
      if ((heights[from] > 0) == (heights[to] > 0)) continue;
      const double s = heights[from] / (heights[from] - heights[to]);
      const Eigen::Vector3d p = (1 - s) * eigen(mesh.vertices[from]) + s * eigen(mesh.vertices[to]) - center;
      (heights[from] > 0 ? a : b) = {p.dot(outline.x), p.dot(outline.y)};
    }
    add_segment(a, b);
  }
  for (std::vector<End>& ends : rays) {
    int solids = 0;
    for (const End& end : ends) solids -= end.change;
    std::sort(ends.begin(), ends.end());
    outline.solid = outline.solid && solids > 0;
    outline.distances.push_back(-1);
    for (const End& end : ends) {
      solids += end.change;
      if (solids > 0 || end.change > 0) continue;
      outline.distances.back() = end.along;
      break;
    }
    outline.closed = outline.closed && outline.distances.back() > 0;
  }
  return outline;
}

/// How a closed outline looks.
struct Roundness {
  /// Share of the rays that run on into something that is attached: clearly beyond the circle that at least half of the
  /// rays end on or, without one, beyond the expected radius. All else is said of the other rays.
  double attached = 0;
  bool circle = false;    ///< at least half of the rays are equally long to 1.5 %
  double half_width = 0;  ///< m; radius of the circle, or the larger half side of the smallest rectangle about it
  double aspect = 1;      ///< larger over smaller side of that rectangle
  double off_center = 0;  ///< m; from the point to the middle of that rectangle, along its sides
  double convexity = 1;   ///< area over the area of the convex hull
  /// Of a rounded rectangle the radius of its corners over its smaller half side: 1 of a circle, 0 of a rectangle. From
  /// the area that the corners leave of that rectangle.
  double corner = 0;
};

inline Roundness roundness(const Outline& outline, double expected_radius) {
  constexpr std::size_t n = Outline::kRays;
  Roundness result;
  std::vector<double> sorted = outline.distances;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[n / 2];
  std::size_t alike = 0;
  for (const double d : sorted) alike += std::abs(d - median) <= 0.015 * median;
  result.circle = 2 * alike >= n;
  const double reach = 1.08 * (result.circle ? median : expected_radius) + 0.0005;
  std::vector<Point2> points;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d p = outline.point(i);
    if (outline.distances[i] <= reach) points.push_back({p[0], p[1]});
  }
  result.attached = 1 - static_cast<double>(points.size()) / n;
  if (points.size() < n / 2) return result;
  const auto area = [](const std::vector<Point2>& polygon) {
    double twice = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      twice += a[0] * b[1] - a[1] * b[0];
    }
    return twice / 2;
  };
  // The smallest rectangle has a side along an edge of the hull.
  const std::vector<Point2> hull = convex_hull(points);
  double rectangle = HUGE_VAL, smaller = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point2 &a = hull[i], &b = hull[(i + 1) % hull.size()];
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]), x = (b[0] - a[0]) / length, y = (b[1] - a[1]) / length;
    Point2 low = {HUGE_VAL, HUGE_VAL}, high = {-HUGE_VAL, -HUGE_VAL};
    for (const Point2& p : hull) {
      const Point2 q = {x * p[0] + y * p[1], x * p[1] - y * p[0]};
      for (std::size_t k = 0; k < 2; ++k) low[k] = std::min(low[k], q[k]), high[k] = std::max(high[k], q[k]);
    }
    const double half_x = (high[0] - low[0]) / 2, half_y = (high[1] - low[1]) / 2;
    if (4 * half_x * half_y >= rectangle) continue;
    rectangle = 4 * half_x * half_y;
    smaller = std::min(half_x, half_y);
    result.half_width = std::max(half_x, half_y);
    result.off_center = std::max(std::abs(high[0] + low[0]), std::abs(high[1] + low[1])) / 2;
  }
  result.aspect = result.half_width / smaller;
  constexpr double kCorner = 4 - 3.141592653589793;
  result.corner = std::sqrt(std::max(0.0, (rectangle - area(points)) / kCorner)) / smaller;
  result.convexity = area(points) / area(hull);
  if (result.circle) result.half_width = median;
  return result;
}

}  // namespace handhold::sensor
