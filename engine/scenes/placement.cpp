#include "placement.h"

#include <algorithm>
#include <cmath>

#include "convex_hull.h"
#include "settle.h"

namespace handhold::sensor {
namespace {

std::vector<Point2> turned(const std::vector<Point2>& polygon, double x, double y, double yaw) {
  std::vector<Point2> result;
  const double c = std::cos(yaw), s = std::sin(yaw);
  for (const Point2& p : polygon) result.push_back({x + c * p[0] - s * p[1], y + s * p[0] + c * p[1]});
  return result;
}

/// Distance of p behind the edge that starts at corner i; negative in front of it (outside).
double behind_edge(const std::vector<Point2>& polygon, std::size_t i, const Point2& p) {
  const Point2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
  const double ex = b[0] - a[0], ey = b[1] - a[1];
  return (ex * (p[1] - a[1]) - ey * (p[0] - a[0])) / std::hypot(ex, ey);
}

bool separated_by_edge_of(const std::vector<Point2>& a, const std::vector<Point2>& b, double gap) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    double nearest = -HUGE_VAL;
    for (const Point2& p : b) nearest = std::max(nearest, behind_edge(a, i, p));
    if (nearest <= -gap) return true;
  }
  return false;
}

}  // namespace

bool is_block(const std::string& family) {
  // The others' highest points bound a rim, or belong to a handle.
  return family == "carton" || family == "brick" || family == "book";
}

Resting at_rest(const std::string& name, const std::string& family, const Sizes& sizes, const Pose& start) {
  const Mesh mesh = make_object(family, sizes).mesh;
  const Rest rest = settle(mesh, start);
  Resting thing;
  thing.object.name = name;
  thing.object.family = family;
  thing.object.sizes = sizes;
  thing.object.T_world_object = rest.T_world_object;
  thing.contacts = rest.contacts;
  std::vector<Vector3> points;
  std::vector<Point2> shadow;
  for (const Vector3& v : mesh.vertices) {
    points.push_back(rest.T_world_object.point(v));
    shadow.push_back({points.back()[0], points.back()[1]});
    thing.height = std::max(thing.height, points.back()[2]);
  }
  thing.footprint = convex_hull(std::move(shadow));
  if (is_block(family)) {
    std::vector<Point2> top;
    for (const Vector3& p : points) {
      if (p[2] > thing.height - 1e-6) top.push_back({p[0], p[1]});
    }
    thing.top = convex_hull(std::move(top));
    if (thing.top.size() < 3) thing.top.clear();
  }
  return thing;
}

Resting moved(const Resting& thing, double x, double y, double z, double yaw) {
  Resting result = thing;
  result.object.T_world_object = translation(x, y, z) * rotation({0, 0, 1}, yaw) * thing.object.T_world_object;
  result.footprint = turned(thing.footprint, x, y, yaw);
  result.contacts = turned(thing.contacts, x, y, yaw);
  result.top = turned(thing.top, x, y, yaw);
  result.height = thing.height + z;
  return result;
}

bool apart(const std::vector<Point2>& a, const std::vector<Point2>& b, double gap) {
  return separated_by_edge_of(a, b, gap) || separated_by_edge_of(b, a, gap);
}

bool within(const std::vector<Point2>& polygon, const Point2& p, double margin) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    if (behind_edge(polygon, i, p) < margin) return false;
  }
  return polygon.size() >= 3;
}

}  // namespace handhold::sensor
