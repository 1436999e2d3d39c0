#include "shape.h"

#include <algorithm>
#include <cmath>

#include "rings.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr double kHalfTurn = 3.141592653589793;
constexpr int kSegments = 64;       // of meshes: a radius of 40 mm is off by 0.05 mm at most
constexpr int kPieceSegments = 32;  // of convex pieces
constexpr int kSectors = 24;        // into which a vessel's wall is cut
// What is a part, see families.h.
constexpr double kLeastPart = 0.020, kWidestPart = 0.041;  // m
constexpr double kRounding = 1e-9;                         // m; of sizes that are sums
constexpr double kIncidental = 0.3;                        // confidence

std::vector<Vector3> ring(double radius, double z, int segments, double from = 0, double to = 2 * kHalfTurn) {
  std::vector<Vector3> points;
  const bool closed = to - from >= 2 * kHalfTurn - 1e-9;
  for (int i = 0; i < segments + (closed ? 0 : 1); ++i) {
    const double a = from + (to - from) * i / segments;
    points.push_back({radius * std::cos(a), radius * std::sin(a), z});
  }
  return points;
}

void append(std::vector<Vector3>& to, const std::vector<Vector3>& points) {
  to.insert(to.end(), points.begin(), points.end());
}

/// How far the outline between i and j stays inside its hull, along the radius.
double hollow(const std::vector<Point2>& outline, std::size_t i, std::size_t j) {
  double deepest = 0;
  for (std::size_t a = i; a < j; ++a) {
    for (std::size_t b = a + 2; b <= j; ++b) {
      const double dz = outline[b][1] - outline[a][1];
      for (std::size_t k = a + 1; k < b; ++k) {
        const double s = dz > 0 ? (outline[k][1] - outline[a][1]) / dz : 0.5;
        deepest = std::max(deepest, outline[a][0] + s * (outline[b][0] - outline[a][0]) - outline[k][0]);
      }
    }
  }
  return deepest;
}

/// Closed surface through rings of equally many points; the end rings must be convex polygons.
Mesh loft(const std::vector<std::vector<Vector3>>& rings) {
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(rings[0].size());
  for (const auto& points : rings) append(mesh.vertices, points);
  close_rings(mesh, static_cast<std::uint32_t>(rings.size()), n);
  return mesh;
}

double angle_between(const Vector3& a, const Vector3& b) {
  return std::acos(std::clamp(dot(unit(a), unit(b)), -1.0, 1.0));
}

double path_length(const std::vector<Vector3>& path) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) length += norm(path[i + 1] - path[i]);
  return length;
}

/// Point and index of the segment at an arc length.
std::pair<Vector3, std::size_t> at_length(const std::vector<Vector3>& path, double s) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const double d = norm(path[i + 1] - path[i]);
    if (s <= d || i + 2 == path.size()) return {path[i] + (s / d) * (path[i + 1] - path[i]), i};
    s -= d;
  }
  return {path.back(), path.size() - 2};
}

/// Radius of an outline, whose points go upwards, at a height within it.
double radius_at(const std::vector<Point2>& outline, double z) {
  std::size_t i = 0;
  while (i + 2 < outline.size() && z > outline[i + 1][1]) ++i;
  const Point2 &low = outline[i], &high = outline[i + 1];
  const double s = high[1] > low[1] ? std::clamp((z - low[1]) / (high[1] - low[1]), 0.0, 1.0) : 1;
  return low[0] + s * (high[0] - low[0]);
}

Part path_part(const std::string& what, const std::vector<Vector3>& path, double radius, double confidence) {
  const double length = path_length(path);
  const auto [center, segment] = at_length(path, length / 2);
  Part part;
  part.what = what;
  part.center = center;
  part.axis = unit(path[segment + 1] - path[segment]);
  part.radius = radius;
  part.length = length;
  part.confidence = confidence;
  part.centre_line = path;
  return part;
}

}  // namespace

void Shape::add(const Mesh& solid, const Pose& T) {
  mesh = merged(mesh, transformed(solid, T));
}

void Shape::add_piece(const std::vector<Vector3>& points, const Pose& T) {
  std::vector<Vector3>& piece = pieces.emplace_back();
  for (const Vector3& p : points) piece.push_back(T.point(p));
}

void Shape::add_box(double x, double y, double z, const Pose& T) {
  const Mesh solid = box(x, y, z);
  add(solid, T);
  add_piece(solid.vertices, T);
}

void Shape::add_turned(const std::vector<Point2>& outline, const Pose& T) {
  std::vector<Point2> profile;
  if (outline.front()[0] > 0) profile.push_back({0, outline.front()[1]});
  profile.insert(profile.end(), outline.begin(), outline.end());
  if (outline.back()[0] > 0) profile.push_back({0, outline.back()[1]});
  add(revolve(profile, kSegments), T);
  // Runs of the outline that bulge outwards are convex solids; up to 0.4 mm of hollow counts as none.
  for (std::size_t i = 0; i + 1 < outline.size();) {
    std::size_t j = i + 1;
    while (j + 1 < outline.size() && hollow(outline, i, j + 1) < 0.0004) ++j;
    std::vector<Vector3> points;
    for (std::size_t k = i; k <= j; ++k) {
      append(points, outline[k][0] > 0 ? ring(outline[k][0], outline[k][1], kPieceSegments)
                                       : std::vector<Vector3>{{0, 0, outline[k][1]}});
    }
    // A step without height has no volume.
    if (outline[j][1] > outline[i][1]) add_piece(points, T);
    i = j;
  }
}

void Shape::add_sphere(double radius, const Pose& T) {
  std::vector<Point2> outline;
  constexpr int kRings = kSegments / 2;
  for (int i = 0; i <= kRings; ++i) {
    const double a = kHalfTurn * i / kRings;
    outline.push_back({i == 0 || i == kRings ? 0 : radius * std::sin(a), -radius * std::cos(a)});
  }
  add_turned(outline, T);
}

void Shape::add_vessel(const std::vector<WallRing>& wall, double floor, const Pose& T) {
  std::vector<Point2> profile = {{0, wall.front().z}};
  for (const WallRing& w : wall) profile.push_back({w.outer, w.z});
  const double floor_z = wall.front().z + floor;
  for (auto w = wall.rbegin(); w != wall.rend(); ++w) {
    if (w->z > floor_z) profile.push_back({w->inner, w->z});
  }
  // Where the wall's inside meets the floor.
  const WallRing *below = &wall[0], *above = &wall[1];
  for (std::size_t i = 1; i < wall.size() && wall[i - 1].z <= floor_z; ++i) below = &wall[i - 1], above = &wall[i];
  const double s = (floor_z - below->z) / (above->z - below->z);
  const WallRing at_floor = {floor_z, below->outer + s * (above->outer - below->outer),
                             below->inner + s * (above->inner - below->inner)};
  profile.push_back({at_floor.inner, floor_z});
  profile.push_back({0, floor_z});
  add(revolve(profile, kSegments), T);

  // The floor's piece is as high as the floor; only above it the wall is cut, so that the vessel stands on one piece.
  std::vector<Vector3> bottom = ring(at_floor.outer, floor_z, kPieceSegments);
  std::vector<WallRing> upper = {at_floor};
  for (const WallRing& w : wall) {
    if (w.z < floor_z) append(bottom, ring(w.outer, w.z, kPieceSegments));
    if (w.z > floor_z) upper.push_back(w);
  }
  add_piece(bottom, T);
  // The pieces' inner faces are chords: moved outwards by half of what they cut off, they keep the volume.
  const double chord = 2 / (1 + std::cos(kHalfTurn / kSectors));
  for (std::size_t i = 0; i + 1 < upper.size(); ++i) {
    for (int sector = 0; sector < kSectors; ++sector) {
      const double from = 2 * kHalfTurn * sector / kSectors, to = 2 * kHalfTurn * (sector + 1) / kSectors;
      std::vector<Vector3> points;
      for (const WallRing* w : {&upper[i], &upper[i + 1]}) {
        append(points, ring(w->outer, w->z, 4, from, to));
        append(points, ring(chord * w->inner, w->z, 1, from, to));
      }
      add_piece(points, T);
    }
  }
}

void Shape::add_open_box(double x, double y, double z, double wall, const Pose& T) {
  add_box(x, y, wall, T * translation(0, 0, wall / 2));
  for (const double side : {-0.5, 0.5}) {
    add_box(wall, y, z, T * translation(side * (x - wall), 0, z / 2));
    add_box(x, wall, z, T * translation(0, side * (y - wall), z / 2));
  }
}

void Shape::add_lofted(const std::vector<Section>& sections, const Pose& T) {
  std::vector<std::vector<Vector3>> rings;
  for (const Section& section : sections) {
    std::vector<Vector3>& points = rings.emplace_back();
    // A corner a little smaller than the half sizes keeps the number of points the same for every section.
    const double corner = std::min(section.corner, 0.98 * std::min(section.half_x, section.half_y));
    for (const Point2& p : rounded_rectangle(section.half_x, section.half_y, corner)) {
      points.push_back({section.x + p[0], section.y + p[1], section.z});
    }
  }
  add(loft(rings), T);
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
    std::vector<Vector3> points = rings[i];
    append(points, rings[i + 1]);
    add_piece(points, T);
  }
}

void Shape::add_bar(const std::vector<Vector3>& path, const Vector3& binormal, const std::vector<Point2>& section,
                    const Pose& T) {
  const Mesh solid = tube(path, binormal, section);
  add(solid, T);
  // Stretches that turn by less than 12 degrees count as convex.
  const std::size_t n = section.size();
  for (std::size_t i = 0; i + 1 < path.size();) {
    std::size_t j = i + 1;
    const Vector3 start = path[i + 1] - path[i];
    while (j + 1 < path.size() && angle_between(start, path[j + 1] - path[j]) < 12 * kHalfTurn / 180) ++j;
    add_piece({solid.vertices.begin() + static_cast<std::ptrdiff_t>(i * n),
               solid.vertices.begin() + static_cast<std::ptrdiff_t>((j + 1) * n)},
              T);
    i = j;
  }
}

void Shape::add_rod(const std::vector<Vector3>& path, const Vector3& binormal, double radius, const Pose& T) {
  add_bar(path, binormal, rounded_rectangle(radius, radius, radius), T);
}

void Shape::grip(const std::string& what, const Vector3& from, const Vector3& to, double radius, double confidence,
                 const Pose& T) {
  parts.push_back(transformed(path_part(what, {from, to}, radius, confidence), T));
}

void Shape::incidental(const std::string& what, const std::vector<Vector3>& path, double radius, const Pose& T) {
  if (path_length(path) < kLeastPart - kRounding || radius > kWidestPart + kRounding) return;
  parts.push_back(transformed(path_part(what, path, radius, kIncidental), T));
}

void Shape::incidental_turned(const std::string& what, const std::vector<Point2>& outline, double from, double to,
                              const Pose& T) {
  constexpr double kStep = 0.00025, kSpread = 0.4, kSteepest = 0.75;
  std::vector<Point2> places;  // radius and height
  const int steps = static_cast<int>(std::ceil((to - from) / kStep));
  for (int i = 0; i <= steps; ++i) {
    const double z = from + (to - from) * i / steps;
    places.push_back({radius_at(outline, z), z});
  }
  const auto longest = [&places](double low, double high) {
    std::size_t first = 0, count = 0;
    for (std::size_t i = 0, run = 0; i < places.size(); ++i) {
      run = places[i][0] >= low && places[i][0] <= high ? run + 1 : 0;
      if (run > count) count = run, first = i + 1 - run;
    }
    places = std::vector<Point2>(places.begin() + static_cast<std::ptrdiff_t>(first),
                                 places.begin() + static_cast<std::ptrdiff_t>(first + count));
  };
  longest(0, kWidestPart + kRounding);
  // What is left out at the ends changes the mean: until nothing more is.
  double mean = 0;
  for (std::size_t before = 0; before != places.size() && !places.empty();) {
    before = places.size();
    mean = 0;
    for (const Point2& place : places) mean += place[0] / static_cast<double>(before);
    longest((1 - kSpread) * mean, (1 + kSpread) * mean);
  }
  if (places.size() < 2) return;
  const Point2 &low = places.front(), &high = places.back();
  if (std::abs(high[0] - low[0]) > kSteepest * (high[1] - low[1])) return;
  incidental(what, {{0, 0, low[1]}, {0, 0, high[1]}}, mean, T);
}

void Shape::loop(const std::string& what, const std::vector<Vector3>& path, double radius, const Pose& T) {
  constexpr double kStraight = 40 * kHalfTurn / 180, kLeastEnd = 0.010;
  const double length = path_length(path);
  const std::size_t middle = at_length(path, length / 2).second;
  const Vector3 axis = path[middle + 1] - path[middle];
  std::size_t first = middle, last = middle + 1;  // vertices of the stretch
  while (first > 0 && angle_between(axis, path[first] - path[first - 1]) < kStraight) --first;
  while (last + 1 < path.size() && angle_between(axis, path[last + 1] - path[last]) < kStraight) ++last;
  const auto stretch = [&](std::size_t from, std::size_t to) {
    return std::vector<Vector3>(path.begin() + static_cast<std::ptrdiff_t>(from),
                                path.begin() + static_cast<std::ptrdiff_t>(to) + 1);
  };
  parts.push_back(transformed(path_part(what, stretch(first, last), radius, 1), T));
  for (const auto& [from, to] : {std::pair(std::size_t{0}, first), std::pair(last, path.size() - 1)}) {
    const std::vector<Vector3> end = stretch(from, to);
    if (end.size() < 2 || path_length(end) < kLeastEnd) continue;
    parts.push_back(transformed(path_part(what + ", end", end, radius, kIncidental), T));
  }
}

std::vector<Vector3> rounded_path(const std::vector<Vector3>& corners, double bend) {
  constexpr int kBendSegments = 12;
  std::vector<Vector3> path = {corners.front()};
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Vector3 in = unit(corners[i] - corners[i - 1]), out = unit(corners[i + 1] - corners[i]);
    const double turn = angle_between(in, out);
    if (turn < 1e-6) continue;
    const double room = 0.49 * std::min(norm(corners[i] - corners[i - 1]), norm(corners[i + 1] - corners[i]));
    const double cut = std::min(bend * std::tan(turn / 2), room);
    const double radius = cut / std::tan(turn / 2);
    const Vector3 to_center = unit(out - in);
    const Vector3 center = corners[i] + (radius / std::cos(turn / 2)) * to_center;
    // In the plane of the two sides: from the first tangent point, seen from the centre, towards `in`.
    const Vector3 x = unit(corners[i] - cut * in - center);
    for (int k = 0; k <= kBendSegments; ++k) {
      const double a = turn * k / kBendSegments;
      path.push_back(center + (radius * std::cos(a)) * x + (radius * std::sin(a)) * in);
    }
  }
  path.push_back(corners.back());
  return path;
}

std::vector<Vector3> clipped_path(const std::vector<Vector3>& path, const Vector3& point, const Vector3& inward) {
  std::vector<Vector3> kept;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double here = dot(inward, path[i] - point);
    if (i > 0) {
      const double before = dot(inward, path[i - 1] - point);
      if (before * here < 0) kept.push_back(path[i - 1] + (before / (before - here)) * (path[i] - path[i - 1]));
    }
    if (here >= 0) kept.push_back(path[i]);
  }
  return kept;
}

std::vector<Vector3> arc_path(const Vector3& center, const Vector3& x, const Vector3& y, double radius, double from,
                              double to) {
  const int segments = std::max(4, static_cast<int>(std::ceil(std::abs(to - from) / (4 * kHalfTurn / 180))));
  std::vector<Vector3> path;
  for (int i = 0; i <= segments; ++i) {
    const double a = from + (to - from) * i / segments;
    path.push_back(center + (radius * std::cos(a)) * x + (radius * std::sin(a)) * y);
  }
  return path;
}

std::vector<Point2> shoulder(const Point2& from, const Point2& to) {
  constexpr int kSteps = 12;
  std::vector<Point2> points;
  for (int i = 0; i <= kSteps; ++i) {
    const double s = static_cast<double>(i) / kSteps;
    points.push_back(
        {to[0] + (from[0] - to[0]) * 0.5 * (1 + std::cos(kHalfTurn * s)), from[1] + (to[1] - from[1]) * s});
  }
  return points;
}

}  // namespace handhold::sensor
