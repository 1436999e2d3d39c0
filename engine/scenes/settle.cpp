#include "settle.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "convex_hull.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr double kTouching = 1e-6;  // m; a vertex this near the table stands on it

/// Point of a convex polygon (or segment, or point) that is nearest to p; p itself when it lies inside.
Point2 nearest_point(const std::vector<Point2>& polygon, const Point2& p) {
  Point2 best = polygon[0];
  double best2 = HUGE_VAL;
  bool inside = polygon.size() >= 3;
  const std::size_t edges = polygon.size() == 2 ? 1 : polygon.size();
  for (std::size_t i = 0; i < edges; ++i) {
    const Point2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double ex = b[0] - a[0], ey = b[1] - a[1], px = p[0] - a[0], py = p[1] - a[1];
    const double length2 = ex * ex + ey * ey;
    if (ex * py - ey * px < 0) inside = false;
    const double s = length2 > 0 ? std::clamp((ex * px + ey * py) / length2, 0.0, 1.0) : 0;
    const double dx = px - s * ex, dy = py - s * ey;
    if (dx * dx + dy * dy < best2) best2 = dx * dx + dy * dy, best = {a[0] + s * ex, a[1] + s * ey};
  }
  return inside ? p : best;
}

}  // namespace

Vector3 center_of_mass(const Mesh& mesh) {
  Vector3 sum = {0, 0, 0};
  double six = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double v = dot(a, cross(b, c));
    six += v;
    sum = sum + (v / 4) * (a + b + c);
  }
  if (!(six > 0)) throw std::invalid_argument("center_of_mass: the mesh encloses no volume");
  return (1 / six) * sum;
}

Rest settle(const Mesh& mesh, const Pose& start) {
  Pose T = start;
  const Vector3 center = center_of_mass(mesh);
  std::vector<Vector3> p(mesh.vertices.size());
  Rest rest;
  // Each turn lowers the centre of mass; a round thing rolls over its facets, a few degrees a turn.
  constexpr int kMostTurns = 500;
  for (int turn = 0; turn <= kMostTurns; ++turn) {
    double low = HUGE_VAL;
    for (std::size_t i = 0; i < p.size(); ++i) {
      p[i] = T.point(mesh.vertices[i]);
      low = std::min(low, p[i][2]);
    }
    const Vector3 c = T.point(center);
    std::vector<Point2> contacts;
    for (const Vector3& q : p) {
      if (q[2] - low <= kTouching) contacts.push_back({q[0] - c[0], q[1] - c[1]});
    }
    rest.contacts = convex_hull(contacts);
    const Point2 pivot = nearest_point(rest.contacts, {0, 0});
    const double distance = std::hypot(pivot[0], pivot[1]);
    rest.T_world_object = translation(-c[0], -c[1], -low) * T;
    if ((rest.contacts.size() >= 3 && distance < 1e-9) || turn == kMostTurns) break;
    // Tips from the pivot to where the centre of mass is; exactly balanced, to +x.
    const double dx = distance > 1e-9 ? -pivot[0] / distance : 1, dy = distance > 1e-9 ? -pivot[1] / distance : 0;
    double angle = HUGE_VAL;
    for (const Vector3& q : p) {
      const double ahead = (q[0] - c[0] - pivot[0]) * dx + (q[1] - c[1] - pivot[1]) * dy, high = q[2] - low;
      // What touches already lies on the pivot's line or behind it.
      if (high > kTouching) angle = std::min(angle, std::atan2(high, ahead));
    }
    const Vector3 at = {c[0] + pivot[0], c[1] + pivot[1], low};
    T = translation(at[0], at[1], at[2]) * rotation({-dy, dx, 0}, angle) * translation(-at[0], -at[1], -at[2]) * T;
  }
  return rest;
}

}  // namespace handhold::sensor
