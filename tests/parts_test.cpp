// Are all parts listed? Round stretches with nothing attached are looked for on the meshes alone, and each must be a
// part.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "cross_section.h"
#include "handhold/families.h"
#include "matching.h"
#include "sensor_test_helpers.h"

namespace handhold::sensor {
namespace {

using Eigen::Vector3d;

struct Stretch {
  Vector3d center, axis;
  double radius = 0;
};

/// Moves a point to the centroid of the outline about it; none where there is no outline that a hand could go around.
std::optional<Vector3d> centered(const Mesh& mesh, Vector3d at, const Vector3d& axis) {
  for (int step = 0; step < 2; ++step) {
    const Outline outline = outline_about(mesh, at, axis);
    if (!outline.closed) return std::nullopt;
    double area = 0;
    Eigen::Vector2d moment(0, 0);
    std::size_t wide = 0;
    for (std::size_t i = 0; i < Outline::kRays; ++i) {
      wide += outline.distances[i] > 0.085;
      const Eigen::Vector2d a = outline.point(i), b = outline.point((i + 1) % Outline::kRays);
      const double twice = a[0] * b[1] - a[1] * b[0];
      area += twice / 2;
      moment += twice / 6 * (a + b);
    }
    if (wide > 0 || !(area > 0)) return std::nullopt;
    at += moment[0] / area * outline.x + moment[1] / area * outline.y;
  }
  return at;
}

/// Radius of the outline at a place; none when it is not round by the rule of families.h.
std::optional<double> round_radius(const Mesh& mesh, const Vector3d& at, const Vector3d& axis) {
  const Outline outline = outline_about(mesh, at, axis);
  if (!outline.closed) return std::nullopt;
  const Roundness r = roundness(outline, 0.042);
  if (r.attached > 0 || r.half_width > 0.041 || r.off_center > 0.0005 + 0.05 * r.half_width) return std::nullopt;
  if (r.aspect > 6) return std::nullopt;
  if (r.convexity < 0.99 || r.corner < 0.6) return std::nullopt;
  return r.half_width;
}

/// The round stretch of 20 mm about a point within a solid, along about `direction`.
std::optional<Stretch> round_stretch(const Mesh& mesh, const Vector3d& within, const Vector3d& direction) {
  constexpr double kHalf = 0.010;
  const auto middle = centered(mesh, within, direction);
  if (!middle) return std::nullopt;
  const auto low = centered(mesh, *middle - 0.8 * kHalf * direction, direction);
  const auto high = centered(mesh, *middle + 0.8 * kHalf * direction, direction);
  if (!low || !high) return std::nullopt;
  Stretch stretch;
  stretch.axis = (*high - *low).normalized();
  if (stretch.axis.dot(direction) < 0.8) return std::nullopt;
  const auto center = centered(mesh, *middle, stretch.axis);
  if (!center) return std::nullopt;
  stretch.center = *center;
  std::vector<double> radii;
  for (int i = -2; i <= 2; ++i) {
    const auto radius = round_radius(mesh, *center + 0.5 * i * kHalf * stretch.axis, stretch.axis);
    if (!radius) return std::nullopt;
    radii.push_back(*radius);
    stretch.radius += *radius / 5;
  }
  for (const double r : radii) {
    if (std::abs(r - stretch.radius) > 0.4 * stretch.radius) return std::nullopt;
  }
  if (std::abs(radii.front() - radii.back()) > 0.75 * 2 * kHalf) return std::nullopt;
  return stretch;
}

/// Distances along a line at which it meets the mesh, sorted.
std::vector<double> meetings(const Mesh& mesh, const Vector3d& from, const Vector3d& direction) {
  std::vector<double> all;
  for (const auto& t : mesh.triangles) {
    const Vector3d a = eigen(mesh.vertices[t[0]]), e = eigen(mesh.vertices[t[1]]) - a,
                   f = eigen(mesh.vertices[t[2]]) - a;
    const Vector3d p = direction.cross(f);
    const double det = e.dot(p);
    if (std::abs(det) < 1e-15) continue;
    const Vector3d s = from - a, q = s.cross(e);
    const double u = s.dot(p) / det, v = direction.dot(q) / det;
    if (u >= 0 && v >= 0 && u + v <= 1) all.push_back(f.dot(q) / det);
  }
  std::sort(all.begin(), all.end());
  return all;
}

bool is(const Stretch& s, const evaluation::LabelledPart& part) {
  return evaluation::matches(
      evaluation::offset({s.center[0], s.center[1], s.center[2]}, {s.axis[0], s.axis[1], s.axis[2]}, s.radius, part),
      part);
}

/// Whether a point of the surface belongs to a listed part.
bool on_a_part(const Vector3d& p, const std::vector<evaluation::LabelledPart>& parts) {
  return std::any_of(parts.begin(), parts.end(), [&](const evaluation::LabelledPart& part) {
    const evaluation::Offset o = evaluation::offset({p[0], p[1], p[2]}, part.axis, 0, part);
    return o.along == 0 && o.across <= 1.1 * part.radius + 0.0005;
  });
}

/// Round stretches that no part covers.
std::vector<Stretch> unlisted(const Object& object, int samples) {
  const Mesh& mesh = object.mesh;
  std::vector<evaluation::LabelledPart> parts;
  for (const Part& part : object.parts) parts.push_back(evaluation::labelled(part));
  std::vector<double> areas;
  for (const auto& t : mesh.triangles) {
    const Vector3d a = eigen(mesh.vertices[t[0]]);
    areas.push_back((eigen(mesh.vertices[t[1]]) - a).cross(eigen(mesh.vertices[t[2]]) - a).norm());
  }
  std::mt19937 generator(5);
  std::discrete_distribution<std::size_t> triangle(areas.begin(), areas.end());
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Stretch> found;
  for (int i = 0; i < samples; ++i) {
    const auto& t = mesh.triangles[triangle(generator)];
    const Vector3d a = eigen(mesh.vertices[t[0]]), b = eigen(mesh.vertices[t[1]]), c = eigen(mesh.vertices[t[2]]);
    double u = uniform(generator), v = uniform(generator);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vector3d p = a + u * (b - a) + v * (c - a);
    if (on_a_part(p, parts)) continue;
    const Vector3d inward = -(b - a).cross(c - a).normalized();
    // The middle of the matter below, and of all that is not too wide to hold: the other side of a hollow thing.
    const std::vector<double> through = meetings(mesh, p, inward);
    double first = 0, last = 0;
    for (const double s : through) {
      if (s < 1e-5 || s > 0.085) continue;
      if (first == 0) first = s;
      last = s;
    }
    if (first == 0) continue;
    // Meshes are swept: their edges run along and across.
    for (const Vector3d& edge : {Vector3d(b - a), Vector3d(c - b), Vector3d(a - c)}) {
      for (const double depth : last > first ? std::vector<double>{first, last} : std::vector<double>{first}) {
        if (edge.norm() < 1e-9) continue;
        const auto stretch = round_stretch(mesh, p + 0.5 * depth * inward, edge.normalized());
        if (!stretch) continue;
        const bool listed = std::any_of(parts.begin(), parts.end(),
                                        [&](const evaluation::LabelledPart& part) { return is(*stretch, part); });
        if (!listed) found.push_back(*stretch);
      }
    }
  }
  return found;
}

std::string text_of(const Stretch& s) {
  const auto mm = [](double x) { return std::to_string(std::lround(1000 * x)); };
  return "at " + mm(s.center[0]) + " " + mm(s.center[1]) + " " + mm(s.center[2]) + " mm along " +
         std::to_string(s.axis[0]) + " " + std::to_string(s.axis[1]) + " " + std::to_string(s.axis[2]) + ", radius " +
         mm(s.radius) + " mm";
}

TEST(Parts, EveryRoundStretchIsListed) {
  for (const Family& f : families()) {
    Sizes low, high;
    for (const SizeRange& size : f.sizes) {
      low[size.name] = size.low;
      high[size.name] = size.high;
    }
    for (const Sizes& sizes : {Sizes{}, low, high}) {
      for (const Stretch& stretch : unlisted(make_object(f.name, sizes), 50)) {
        ADD_FAILURE() << f.name
                      << (sizes == low    ? " (smallest): "
                          : sizes == high ? " (largest): "
                                          : ": ")
                      << text_of(stretch);
      }
    }
  }
}

TEST(Parts, TheSearchFindsWhatIsNotListed) {
  for (const auto& [name, what] : {std::pair("hammer", "hammer face"), std::pair("drill", "drill body"),
                                   std::pair("kettle", "kettle spout"), std::pair("mallet", "mallet head, above"),
                                   std::pair("mug", "mug body"), std::pair("spatula", "spatula shank")}) {
    Object object = make_object(name);
    const auto part =
        std::find_if(object.parts.begin(), object.parts.end(), [&](const Part& p) { return p.what == what; });
    ASSERT_NE(part, object.parts.end()) << what;
    const evaluation::LabelledPart left_out = evaluation::labelled(*part);
    object.parts.erase(part);
    const std::vector<Stretch> found = unlisted(object, 200);
    EXPECT_FALSE(found.empty()) << what;
    for (const Stretch& s : found) EXPECT_TRUE(is(s, left_out)) << what << ": " << text_of(s);
  }
}

Mesh bar(const std::vector<Point2>& section) {
  return tube({{0, 0, 0}, {0, 0, 0.1}}, {0, 1, 0}, section);
}

TEST(CrossSection, OfShapesThatAreKnown) {
  const auto of = [](const Mesh& mesh, const Vector3d& at) {
    const Outline outline = outline_about(mesh, at, Vector3d(0, 0, 2));
    EXPECT_TRUE(outline.closed);
    return roundness(outline, 0.02);
  };
  const Vector3d middle(0, 0, 0.05);
  const Roundness round = of(cylinder(0.02, 0.1), middle);
  EXPECT_TRUE(round.circle);
  EXPECT_NEAR(round.half_width, 0.02, 2e-5);
  EXPECT_NEAR(round.aspect, 1, 0.001);
  EXPECT_NEAR(round.corner, 1, 0.01);
  EXPECT_NEAR(round.convexity, 1, 0.001);
  EXPECT_NEAR(of(cylinder(0.02, 0.1), middle + Vector3d(0.001, 0, 0)).off_center, 0.001, 1e-4);
  for (const double corner : {0.002, 0.006, 0.010}) {
    const Roundness strap = of(bar(rounded_rectangle(0.020, 0.010, corner)), middle);
    EXPECT_FALSE(strap.circle);
    EXPECT_NEAR(strap.half_width, 0.02, 1e-4);
    EXPECT_NEAR(strap.aspect, 2, 0.01);
    EXPECT_NEAR(strap.corner, corner / 0.010, 0.03) << corner;
  }
  EXPECT_LT(of(transformed(box(0.04, 0.008, 0.1), rotation({0, 0, 1}, 0.3)), Vector3d(0, 0, 0)).corner, 0.4);
  // Two rods side by side are not convex; a rod with a small box on it is a rod with something attached.
  const Mesh rod = cylinder(0.02, 0.1);
  EXPECT_LT(of(merged(cylinder(0.01, 0.1), transformed(cylinder(0.01, 0.1), translation(0.018, 0, 0))),
               Vector3d(0.009, 0, 0.05))
                .convexity,
            0.96);
  const Roundness attached = of(merged(rod, transformed(box(0.02, 0.01, 0.1), translation(0.028, 0, 0.05))), middle);
  EXPECT_NEAR(attached.attached, 2 * std::asin(0.25) / 6.283, 0.01);
  EXPECT_NEAR(attached.half_width, 0.02, 2e-5);
  // A tube counts by its outside; beside the solid there is no outline.
  const Mesh pipe = revolve({{0.018, 0}, {0.02, 0}, {0.02, 0.1}, {0.018, 0.1}});
  EXPECT_NEAR(of(pipe, middle).half_width, 0.02, 2e-5);
  EXPECT_FALSE(outline_about(pipe, middle, Vector3d(0, 0, 1)).solid);
  EXPECT_FALSE(outline_about(rod, middle + Vector3d(0.05, 0, 0), Vector3d(0, 0, 1)).closed);
}

}  // namespace
}  // namespace handhold::sensor
