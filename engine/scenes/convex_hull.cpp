#include "convex_hull.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "random.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

struct Face {
  std::array<std::uint32_t, 3> v;
  Vector3 normal;
  double offset;
};

Face make_face(const std::vector<Vector3>& p, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const Vector3 n = unit(cross(p[b] - p[a], p[c] - p[a]));
  return {{a, b, c}, n, dot(n, p[a])};
}

double height(const Face& face, const Vector3& p) {
  return dot(face.normal, p) - face.offset;
}

/// Four points that span a volume, the last on the negative side of the first three.
std::array<std::uint32_t, 4> first_simplex(const std::vector<Vector3>& p) {
  const auto farthest = [&](const auto& distance) {
    std::uint32_t best = 0;
    for (std::uint32_t i = 1; i < p.size(); ++i) {
      if (distance(p[i]) > distance(p[best])) best = i;
    }
    return best;
  };
  const std::uint32_t a = farthest([](const Vector3& q) { return q[0]; });
  const std::uint32_t b = farthest([&](const Vector3& q) { return norm(q - p[a]); });
  const std::uint32_t c = farthest([&](const Vector3& q) { return norm(cross(q - p[a], p[b] - p[a])); });
  const Vector3 n = cross(p[b] - p[a], p[c] - p[a]);
  const std::uint32_t d = farthest([&](const Vector3& q) { return std::abs(dot(n, q - p[a])); });
  if (!(std::abs(dot(n, p[d] - p[a])) > 1e-6 * norm(n))) {
    throw std::invalid_argument("convex_hull: the points lie in a plane; they must span a volume");
  }
  if (dot(n, p[d] - p[a]) > 0) return {a, c, b, d};
  return {a, b, c, d};
}

/// Within +-0.1 micrometre, a function of the index.
Vector3 nudge(std::uint32_t index) {
  const auto bits = philox({index, 0, 0, 0}, 0x68756C6C);
  return {2e-7 * (to_uniform(bits[0]) - 0.5), 2e-7 * (to_uniform(bits[1]) - 0.5), 2e-7 * (to_uniform(bits[2]) - 0.5)};
}

}  // namespace

Mesh convex_hull(const std::vector<Vector3>& points) {
  if (points.size() < 4) throw std::invalid_argument("convex_hull: a solid needs at least 4 points");
  std::vector<Vector3> p = points;
  for (std::uint32_t i = 0; i < p.size(); ++i) p[i] = p[i] + nudge(i);
  const auto [a, b, c, d] = first_simplex(p);
  std::vector<Face> faces = {make_face(p, a, b, c), make_face(p, a, c, d), make_face(p, c, b, d),
                             make_face(p, b, a, d)};
  for (std::uint32_t i = 0; i < p.size(); ++i) {
    if (i == a || i == b || i == c || i == d) continue;
    // The faces that see the point go; those of their edges that nothing seen lies beyond form the horizon.
    std::map<std::pair<std::uint32_t, std::uint32_t>, bool> edges;
    std::vector<Face> kept;
    for (const Face& face : faces) {
      if (height(face, p[i]) <= 0) {
        kept.push_back(face);
        continue;
      }
      for (int k = 0; k < 3; ++k) edges[{face.v[k], face.v[(k + 1) % 3]}] = true;
    }
    if (kept.size() == faces.size()) continue;
    for (const auto& entry : edges) {
      const auto [from, to] = entry.first;
      if (!edges.count({to, from})) kept.push_back(make_face(p, from, to, i));
    }
    faces = std::move(kept);
  }
  Mesh mesh;
  std::map<std::uint32_t, std::uint32_t> index;
  for (const Face& face : faces) {
    std::array<std::uint32_t, 3> t;
    for (int k = 0; k < 3; ++k) {
      const auto [entry, is_new] = index.try_emplace(face.v[k], static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back(p[face.v[k]]);
      t[k] = entry->second;
    }
    mesh.triangles.push_back(t);
  }
  return mesh;
}

std::vector<Point2> convex_hull(std::vector<Point2> points) {
  // Andrew's monotone chain.
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  const auto turn = [](const Point2& o, const Point2& a, const Point2& b) {
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  };
  std::vector<Point2> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const Point2& p : points) {
      while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  // Rounding leaves corners that are the same in truth; an edge between them would have any direction.
  constexpr double kSame = 1e-6;
  std::vector<Point2> corners;
  const auto same = [](const Point2& a, const Point2& b) { return std::hypot(a[0] - b[0], a[1] - b[1]) < kSame; };
  for (const Point2& p : hull) {
    if (corners.empty() || !same(corners.back(), p)) corners.push_back(p);
  }
  while (corners.size() > 1 && same(corners.front(), corners.back())) corners.pop_back();
  return corners;
}

}  // namespace handhold::sensor
