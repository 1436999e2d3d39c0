// The section of a mesh across a line, as tests look at it: what surrounds a point there, and how round that is.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "sensor_test_helpers.h"

namespace handhold::sensor {

/// The outline about a point, by rays in evenly spread directions of the plane: where the solid, or the union of
/// solids, first ends; the hollow within a wall counts as solid.
struct Outline {
  static constexpr std::size_t kRays = 72;
  bool closed = true;             ///< every ray meets an end
  bool solid = true;              ///< the point itself is within matter
  std::vector<double> distances;  ///< m; one a ray
  Eigen::Vector3d x, y;           ///< directions of the plane: ray i is at angle (i + 0.37) of kRays about them

  static double angle(std::size_t i) { return 6.283185307179586 * (static_cast<double>(i) + 0.37) / kRays; }
  Eigen::Vector2d point(std::size_t i) const {
    return distances[i] * Eigen::Vector2d(std::cos(angle(i)), std::sin(angle(i)));
  }
};

/// Section of `mesh` through `center` across `axis`.
inline Outline outline_about(const Mesh& mesh, const Eigen::Vector3d& center, const Eigen::Vector3d& axis) {
  Outline outline;
  outline.x = axis.unitOrthogonal();
  outline.y = axis.normalized().cross(outline.x);
  struct Segment {
    Eigen::Vector2d a, b;  // the solid lies to the left of a -> b
  };
  std::vector<Segment> segments;
  // Off the vertices, which meshes have at round numbers.
  const double level = axis.normalized().dot(center) + 1.234e-7;
  std::vector<double> heights;
  heights.reserve(mesh.vertices.size());
  const Eigen::Vector3d up = axis.normalized();
  for (const Vector3& v : mesh.vertices) heights.push_back(up.dot(eigen(v)) - level);
  for (const auto& t : mesh.triangles) {
    const bool above[3] = {heights[t[0]] > 0, heights[t[1]] > 0, heights[t[2]] > 0};
    if (above[0] == above[1] && above[1] == above[2]) continue;
    Segment segment;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      if (above[k] == above[next]) continue;
      const double s = heights[t[k]] / (heights[t[k]] - heights[t[next]]);
      const Eigen::Vector3d p =
          eigen(mesh.vertices[t[k]]) + s * (eigen(mesh.vertices[t[next]]) - eigen(mesh.vertices[t[k]])) - center;
      (above[k] ? segment.a : segment.b) = {p.dot(outline.x), p.dot(outline.y)};
    }
    segments.push_back(segment);
  }
  for (std::size_t i = 0; i < Outline::kRays; ++i) {
    const Eigen::Vector2d d(std::cos(Outline::angle(i)), std::sin(Outline::angle(i))), n(-d[1], d[0]);
    std::vector<std::pair<double, int>> ends;  // distance, change of the number of solids
    int solids = 0;
    for (const Segment& s : segments) {
      const double a = n.dot(s.a), b = n.dot(s.b);
      if ((a > 0) == (b > 0)) continue;
      const double along = d.dot(s.a) + a / (a - b) * d.dot(s.b - s.a);
      if (along <= 0) continue;
      ends.emplace_back(along, b > a ? -1 : 1);
      solids -= ends.back().second;
    }
    std::sort(ends.begin(), ends.end());
    outline.solid = outline.solid && solids > 0;
    double end = -1;
    for (const auto& [along, change] : ends) {
      solids += change;
      if (solids > 0 || change > 0) continue;
      end = along;
      break;
    }
    outline.closed = outline.closed && end > 0;
    outline.distances.push_back(end);
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
  double off_center = 0;  ///< m; from the point to the middle between opposite sides, at most
  double hollow = 0;      ///< m; how deep the outline is below its convex hull, at most
  /// Of a rounded rectangle the radius of its corners over its smaller half side: 1 of a circle, 0 of a rectangle. From
  /// the area that the corners leave of the rectangle about it.
  double corner = 0;
};

inline Roundness roundness(const Outline& outline, double expected_radius) {
  constexpr std::size_t n = Outline::kRays;
  Roundness result;
  std::vector<double> sorted = outline.distances;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[n / 2];
  std::size_t alike = 0, attached = 0;
  for (const double d : sorted) alike += std::abs(d - median) <= 0.015 * median;
  result.circle = 2 * alike >= n;
  const double reach = 1.08 * (result.circle ? median : expected_radius) + 0.0005;
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < n; ++i) {
    if (outline.distances[i] > reach) {
      ++attached;
    } else {
      points.push_back(outline.point(i));
    }
  }
  result.attached = static_cast<double>(attached) / n;
  if (points.size() < n / 2) return result;
  constexpr std::size_t kSteps = 180;  // of 2 degrees
  std::vector<double> supports(kSteps, -HUGE_VAL);
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double a = 6.283185307179586 * static_cast<double>(i) / kSteps, x = std::cos(a), y = std::sin(a);
    for (const Eigen::Vector2d& p : points) supports[i] = std::max(supports[i], p[0] * x + p[1] * y);
  }
  double rectangle = HUGE_VAL, smaller = 0;
  for (std::size_t i = 0; i < kSteps / 2; ++i) {
    const double half = (supports[i] + supports[i + kSteps / 2]) / 2;
    const double across = (supports[i + kSteps / 4] + supports[(i + 3 * kSteps / 4) % kSteps]) / 2;
    result.off_center = std::max(result.off_center, std::abs(supports[i] - supports[i + kSteps / 2]) / 2);
    if (4 * half * across >= rectangle) continue;
    rectangle = 4 * half * across;
    smaller = std::min(half, across);
    result.half_width = std::max(half, across);
  }
  if (result.circle) result.half_width = median;
  double area = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d &a = points[i], &b = points[(i + 1) % points.size()];
    area += (a[0] * b[1] - a[1] * b[0]) / 2;
    // Below the chord of the points on both sides, up to an eighth of a turn away.
    for (std::size_t step = 1; step <= n / 8; ++step) {
      const Eigen::Vector2d& before = points[(i + points.size() - step) % points.size()];
      const Eigen::Vector2d chord = points[(i + step) % points.size()] - before, from = a - before;
      if (chord.norm() < 1e-9) continue;
      result.hollow = std::max(result.hollow, (chord[0] * from[1] - chord[1] * from[0]) / chord.norm());
    }
  }
  constexpr double kCorner = 4 - 3.141592653589793;
  result.corner = std::sqrt(std::max(0.0, (rectangle - area) / kCorner)) / smaller;
  return result;
}

}  // namespace handhold::sensor
