#include "objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "projection.h"

namespace handhold::evaluation {
namespace {

/// Points on the half of a cylinder that faces the viewpoint: seven lines of three.
std::vector<Vector3> facing_side(const Vector3& center, const Vector3& axis, double radius, double length,
                                 const Vector3& viewpoint) {
  constexpr double kQuarterTurn = 1.5707963267948966;
  constexpr int kLines = 3;  // on either side of the one that is nearest to the viewpoint
  const Vector3 along = unit(axis), to_viewpoint = add(viewpoint, center, -1);
  Vector3 towards = add(to_viewpoint, along, -dot(to_viewpoint, along));
  // Seen from an end: any side.
  if (!(norm(towards) > 1e-9)) towards = cross(along, std::abs(along[0]) < 0.5 ? Vector3{1, 0, 0} : Vector3{0, 1, 0});
  towards = unit(towards);
  const Vector3 across = cross(along, towards);
  std::vector<Vector3> points;
  for (const double s : {-0.25, 0.0, 0.25}) {
    for (int i = -kLines; i <= kLines; ++i) {
      const double angle = kQuarterTurn * i / (kLines + 1);
      const Vector3 line = add(center, along, s * length);
      points.push_back(add(add(line, towards, radius * std::cos(angle)), across, radius * std::sin(angle)));
    }
  }
  return points;
}

/// The point of segment ab nearest to p.
Vector3 nearest_on_segment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 d = add(b, a, -1);
  const double square = dot(d, d);
  return add(a, d, square > 0 ? std::clamp(dot(add(p, a, -1), d) / square, 0.0, 1.0) : 0);
}

double distance_to_triangle(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 n = cross(add(b, a, -1), add(c, a, -1));
  const double square = dot(n, n);
  if (square > 0) {
    // Above the triangle the plane is nearest.
    const Vector3 foot = add(p, n, -dot(add(p, a, -1), n) / square);
    const auto left_of = [&](const Vector3& from, const Vector3& to) {
      return dot(n, cross(add(to, from, -1), add(foot, from, -1))) >= 0;
    };
    if (left_of(a, b) && left_of(b, c) && left_of(c, a)) return norm(add(p, foot, -1));
  }
  double best = HUGE_VAL;
  for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
    best = std::min(best, norm(add(p, nearest_on_segment(p, from, to), -1)));
  }
  return best;
}

struct Bounds {
  Vector3 low = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  void include(const Vector3& p) {
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
  }
  double distance(const Vector3& p) const {
    Vector3 d;
    for (std::size_t k = 0; k < 3; ++k) d[k] = std::max({low[k] - p[k], p[k] - high[k], 0.0});
    return norm(d);
  }
};

/// Mean distance of points to a mesh, or something above `enough` as soon as it is above that.
double mean_distance(const std::vector<Vector3>& points, const sensor::Mesh& mesh, double enough) {
  double sum = 0;
  const double n = static_cast<double>(points.size());
  for (const Vector3& p : points) {
    double nearest = HUGE_VAL;
    for (const auto& t : mesh.triangles) {
      Bounds bounds;
      for (const std::uint32_t v : t) bounds.include(mesh.vertices[v]);
      if (bounds.distance(p) >= nearest) continue;
      nearest =
          std::min(nearest, distance_to_triangle(p, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
    }
    sum += nearest;
    if (sum / n > enough) break;
  }
  return sum / n;
}

}  // namespace

void find_objects(Scene& scene, const sensor::Scene& geometry, const std::vector<std::string>& families,
                  const sensor::Pose& T_world_camera) {
  if (families.size() != geometry.objects.size()) {
    throw std::invalid_argument("find_objects: " + std::to_string(families.size()) + " families for " +
                                std::to_string(geometry.objects.size()) + " objects; there must be one for each");
  }
  SceneScore& score = scene.score;
  score.objects.clear();
  std::vector<Bounds> bounds(families.size());
  for (std::size_t k = 0; k < families.size(); ++k) {
    score.objects.push_back({geometry.objects[k].name, families[k]});
    for (const Vector3& v : geometry.objects[k].mesh.vertices) bounds[k].include(v);
  }
  for (std::size_t i = 0; i < score.handles.size(); ++i) {
    score.handles[i].object = -1;
    if (score.handles[i].verdict == Verdict::kLeftOut) continue;
    const Handle& h = scene.result.handles[i];
    const std::vector<Vector3> side = facing_side(T_world_camera.point(h.center), T_world_camera.direction(h.axis),
                                                  h.radius, h.length, T_world_camera.t);
    // The boxes about objects tell which need not be looked at.
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      double sum = 0;
      for (const Vector3& p : side) sum += bounds[k].distance(p);
      order.emplace_back(sum / static_cast<double>(side.size()), k);
    }
    std::sort(order.begin(), order.end());
    double best = HUGE_VAL;
    for (const auto& [at_least, k] : order) {
      if (at_least >= best) break;
      const double distance = mean_distance(side, geometry.objects[k].mesh, best);
      if (distance >= best) continue;
      best = distance;
      score.handles[i].object = static_cast<int>(k);
    }
  }
}

}  // namespace handhold::evaluation
