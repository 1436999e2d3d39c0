// Closed triangle meshes. Everything round is either a revolved profile or a swept section, so orientation and closure
// are settled in two places.
#include <algorithm>
#include <stdexcept>
#include <string>

#include "handhold/sensor.h"
#include "rings.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr double kTwoPi = 6.283185307179586;

/// Negated comparisons, so that NaN is refused, too.
void require_positive(double value, const char* where) {
  if (!(value > 0 && value < 1e6)) {
    throw std::invalid_argument(std::string(where) + ": a size is " + std::to_string(value) + " m; it must be above 0");
  }
}

void require_segments(int segments, const char* where) {
  if (segments < 3 || segments > 100000) {
    throw std::invalid_argument(std::string(where) + ": " + std::to_string(segments) +
                                " segments; there must be 3 to 100000");
  }
}

double polygon_area(const std::vector<Point2>& p) {
  double twice = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Point2 &a = p[i], &b = p[(i + 1) % p.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return twice / 2;
}

void require_counter_clockwise(const std::vector<Point2>& p, const char* where) {
  if (p.size() < 3 || !(polygon_area(p) > 0)) {
    throw std::invalid_argument(std::string(where) + ": the outline of " + std::to_string(p.size()) +
                                " points must be a counter-clockwise polygon of at least 3");
  }
}

}  // namespace

Mesh box(double x, double y, double z) {
  for (double size : {x, y, z}) require_positive(size, "box");
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back({(i & 1 ? 0.5 : -0.5) * x, (i & 2 ? 0.5 : -0.5) * y, (i & 4 ? 0.5 : -0.5) * z});
  }
  const std::uint32_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : faces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

Mesh frustum(double bottom, double top, double height, int segments) {
  require_positive(height, "frustum");
  require_positive(std::max(bottom, top), "frustum");
  if (!(bottom >= 0 && top >= 0)) throw std::invalid_argument("frustum: a radius is negative; it must be 0 or more");
  std::vector<Point2> profile = {{0, 0}};
  if (bottom > 0) profile.push_back({bottom, 0});
  if (top > 0) profile.push_back({top, height});
  profile.push_back({0, height});
  return revolve(profile, segments);
}

Mesh cylinder(double radius, double height, int segments) {
  require_positive(radius, "cylinder");
  return frustum(radius, radius, height, segments);
}

Mesh torus(double major_radius, double minor_radius, int segments, int section_segments) {
  require_positive(minor_radius, "torus");
  require_segments(section_segments, "torus");
  if (!(major_radius > minor_radius)) {
    throw std::invalid_argument("torus: major radius " + std::to_string(major_radius) +
                                " m must be larger than minor radius " + std::to_string(minor_radius) + " m");
  }
  std::vector<Point2> profile;
  for (int i = 0; i < section_segments; ++i) {
    const double a = kTwoPi * i / section_segments;
    profile.push_back({major_radius + minor_radius * std::cos(a), minor_radius * std::sin(a)});
  }
  return revolve(profile, segments);
}

Mesh revolve(const std::vector<Point2>& profile, int segments) {
  require_segments(segments, "revolve");
  require_counter_clockwise(profile, "revolve");
  for (const Point2& p : profile) {
    if (!(p[0] >= 0)) throw std::invalid_argument("revolve: a profile point lies at a negative distance from the axis");
  }
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(segments);
  std::vector<std::uint32_t> first;  // first vertex of each profile point's ring
  for (const Point2& p : profile) {
    first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    if (p[0] == 0) {
      mesh.vertices.push_back({0, 0, p[1]});
      continue;
    }
    for (std::uint32_t j = 0; j < n; ++j) {
      const double a = kTwoPi * j / n;
      mesh.vertices.push_back({p[0] * std::cos(a), p[0] * std::sin(a), p[1]});
    }
  }
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const std::size_t k = (i + 1) % profile.size();
    const bool pole_i = profile[i][0] == 0, pole_k = profile[k][0] == 0;
    if (pole_i && pole_k) continue;
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t next = (j + 1) % n;
      const std::uint32_t a = first[i] + (pole_i ? 0 : j), b = first[i] + (pole_i ? 0 : next);
      const std::uint32_t c = first[k] + (pole_k ? 0 : next), d = first[k] + (pole_k ? 0 : j);
      if (!pole_i) mesh.triangles.push_back({a, b, c});
      if (!pole_k) mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

std::vector<Point2> rounded_rectangle(double half_x, double half_y, double corner, int corner_segments) {
  require_positive(std::min(half_x, half_y), "rounded_rectangle");
  require_positive(corner, "rounded_rectangle");
  if (corner_segments < 1 || !(corner <= std::min(half_x, half_y))) {
    throw std::invalid_argument("rounded_rectangle: corner " + std::to_string(corner) +
                                " m must not be larger than a half size, and have at least 1 segment");
  }
  std::vector<Point2> outline;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const double sx = quadrant == 0 || quadrant == 3 ? 1 : -1, sy = quadrant < 2 ? 1 : -1;
    for (int i = 0; i <= corner_segments; ++i) {
      const double a = kTwoPi / 4 * (quadrant + static_cast<double>(i) / corner_segments);
      const Point2 p = {sx * (half_x - corner) + corner * std::cos(a), sy * (half_y - corner) + corner * std::sin(a)};
      // A straight side of length zero would give the same point twice.
      if (!outline.empty() && std::hypot(p[0] - outline.back()[0], p[1] - outline.back()[1]) < 1e-9) continue;
      outline.push_back(p);
    }
  }
  if (std::hypot(outline.front()[0] - outline.back()[0], outline.front()[1] - outline.back()[1]) < 1e-9) {
    outline.pop_back();
  }
  return outline;
}

Mesh tube(const std::vector<Vector3>& path, const Vector3& binormal, const std::vector<Point2>& section) {
  require_counter_clockwise(section, "tube");
  if (path.size() < 2) throw std::invalid_argument("tube: a path needs at least 2 points");
  if (!(norm(binormal) > 0))
    throw std::invalid_argument("tube: the binormal is zero; give the normal of the path's plane");
  const Vector3 y = unit(binormal);
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(section.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vector3 tangent = path[std::min(i + 1, path.size() - 1)] - path[i == 0 ? 0 : i - 1];
    const Vector3 across = cross(y, tangent);
    if (!(norm(across) > 0)) throw std::invalid_argument("tube: the path repeats a point or runs along the binormal");
    const Vector3 x = unit(across);
    for (const Point2& p : section) mesh.vertices.push_back(path[i] + p[0] * x + p[1] * y);
  }
  close_rings(mesh, static_cast<std::uint32_t>(path.size()), n);
  return mesh;
}

Mesh transformed(const Mesh& mesh, const Pose& T) {
  Mesh result = mesh;
  for (Vector3& v : result.vertices) v = T.point(v);
  return result;
}

Mesh merged(const Mesh& a, const Mesh& b) {
  Mesh result = a;
  const auto offset = static_cast<std::uint32_t>(a.vertices.size());
  result.vertices.insert(result.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) result.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return result;
}

double volume(const Mesh& mesh) {
  double six = 0;
  for (const auto& t : mesh.triangles) {
    six += dot(mesh.vertices[t[0]], cross(mesh.vertices[t[1]], mesh.vertices[t[2]]));
  }
  return six / 6;
}

std::size_t open_edges(const Mesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> forward, backward;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      forward.emplace_back(t[k], t[(k + 1) % 3]);
      backward.emplace_back(t[(k + 1) % 3], t[k]);
    }
  }
  std::sort(forward.begin(), forward.end());
  std::sort(backward.begin(), backward.end());
  std::size_t open = 0;
  for (const auto& edge : forward) {
    const auto uses = std::equal_range(forward.begin(), forward.end(), edge);
    const auto opposites = std::equal_range(backward.begin(), backward.end(), edge);
    if (uses.second - uses.first != 1 || opposites.second - opposites.first != 1) ++open;
  }
  return open;
}

}  // namespace handhold::sensor
