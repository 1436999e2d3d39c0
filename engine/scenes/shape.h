// A shape under construction: every solid that is added becomes part of the mesh and, from the same numbers, one or
// several sets of points whose convex hulls cover it.
#pragma once

#include <string>
#include <vector>

#include "handhold/families.h"

namespace handhold::sensor {

/// Height and radii of a vessel's wall (m); inner < outer.
struct WallRing {
  double z, outer, inner;
};

/// Height and half sizes of a horizontal section, a rounded rectangle about (x, y) (m).
struct Section {
  double z, half_x, half_y, corner;
  double x = 0, y = 0;
};

/// Parts of the thing: members of Object, and the pieces. Solids may overlap; each is closed.
struct Shape {
  Mesh mesh;
  std::vector<Part> parts;
  std::vector<std::vector<Vector3>> pieces;  ///< the hull of each is a convex piece

  /// Edges of these lengths about the origin of T.
  void add_box(double x, double y, double z, const Pose& T);
  /// Solid of revolution about z. Points (radius, z) upwards; the ends are closed by flat caps.
  void add_turned(const std::vector<Point2>& outline, const Pose& T = {});
  void add_cylinder(double radius, double height, const Pose& T = {}) {
    add_turned({{radius, 0}, {radius, height}}, T);
  }
  void add_sphere(double radius, const Pose& T);
  /// Open vessel about z: rings of the wall upwards, closed at the bottom by a floor up to the first ring's `z` plus
  /// `floor`.
  void add_vessel(const std::vector<WallRing>& wall, double floor, const Pose& T = {});
  /// Open box: outer sizes, standing on z = 0 of T.
  void add_open_box(double x, double y, double z, double wall, const Pose& T = {});
  /// Sections upwards, joined by flat sides.
  void add_lofted(const std::vector<Section>& sections, const Pose& T = {});
  /// A section swept along a path in a plane with that normal; see `tube`.
  void add_bar(const std::vector<Vector3>& path, const Vector3& binormal, const std::vector<Point2>& section,
               const Pose& T = {});
  /// The same with a round section.
  void add_rod(const std::vector<Vector3>& path, const Vector3& binormal, double radius, const Pose& T = {});

  /// A straight part between two points of its axis (in T's frame).
  void grip(const std::string& what, const Vector3& from, const Vector3& to, double radius, double confidence = 1,
            const Pose& T = {});
  /// A part that one would not hold the thing by: right if it is found, but not asked for. Nothing when it is no part
  /// by the rule of families.h: shorter than 20 mm or more than 41 mm in radius.
  void incidental(const std::string& what, const std::vector<Vector3>& path, double radius, const Pose& T = {});
  /// The same of a solid of revolution about z between two heights of its outline, which may taper: the longest stretch
  /// there that is a part, with its mean radius.
  void incidental_turned(const std::string& what, const std::vector<Point2>& outline, double from, double to,
                         const Pose& T = {});
  /// A curved part: the stretch about the path's middle whose direction is within 40 degrees of the middle's is asked
  /// for; what is left at the two ends, if it is 10 mm or more, is right if it is found, but not asked for.
  void loop(const std::string& what, const std::vector<Vector3>& path, double radius, const Pose& T = {});

 private:
  void add(const Mesh& solid, const Pose& T);
  void add_piece(const std::vector<Vector3>& points, const Pose& T);
};

/// A polyline whose corners are rounded to circular arcs of radius `bend` (m), or less where a side is too short.
std::vector<Vector3> rounded_path(const std::vector<Vector3>& corners, double bend);
/// What of a polyline is on the side of the plane through `point` to which `inward` shows; that must be in one piece.
std::vector<Vector3> clipped_path(const std::vector<Vector3>& path, const Vector3& point, const Vector3& inward);
/// Arc of a circle in the plane of the unit vectors x and y about `center`, from angle `from` to `to` (rad).
std::vector<Vector3> arc_path(const Vector3& center, const Vector3& x, const Vector3& y, double radius, double from,
                              double to);
/// Points of a profile between two (radius, z) with a smooth step (half a cosine wave); both ends included.
std::vector<Point2> shoulder(const Point2& from, const Point2& to);

}  // namespace handhold::sensor
