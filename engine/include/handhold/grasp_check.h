// Would a two-fingered hand really hold something there? Asked of the complete geometry of a scene, also where no
// camera saw it, so that the answer needs no labels.
//
//   sensor::GraspCheck check(scene);
//   sensor::GraspVerdict verdict = check.check(handle.center, handle.axis, handle.radius, hand);
//
// Metres and radians; everything is in the scene's frame.
#pragma once

#include <cstdint>
#include <memory>

#include "handhold/sensor.h"

namespace handhold::sensor {

/// A parallel hand: two boxes that close towards each other.
struct Hand {
  double aperture = 0.08;          ///< m, > 0; largest distance between the fingers
  double minimum = 0;              ///< m, 0 .. aperture; smallest distance
  double finger_thickness = 0.01;  ///< m, > 0; along the closing direction
  double finger_width = 0.02;      ///< m, > 0; along the part's axis
  double finger_depth = 0.04;      ///< m, > 0; along the approach

  /// @throws std::invalid_argument naming the first size that cannot be, its value and what would be valid
  void validate() const;
};

struct GraspVerdict {
  bool fits = false;
  Vector3 approach = {0, 0, 0};  ///< unit; direction in which the hand moves towards the part; zero when nothing fits
  double opening = 0;            ///< m; distance between the fingers; 0 when nothing fits
  /// Why nothing fits, of the direction that came closest: "no room for the fingers", "too wide for the hand", "no room
  /// for the palm" or "nothing between the fingers"; empty when it fits. A literal.
  const char* reason = "";
  /// Index into Scene::objects of what most often stands in the way of fingers or palm; -1 when there is room for them.
  std::int32_t blocked_by = -1;
};

/// Complete geometry of a scene, held as a copy. Calls may overlap.
class GraspCheck {
 public:
  /// @throws std::invalid_argument for a mesh that cannot be
  explicit GraspCheck(const Scene& scene);
  ~GraspCheck();
  GraspCheck(const GraspCheck&) = delete;
  GraspCheck& operator=(const GraspCheck&) = delete;

  /// Whether a point (m) is within any solid. Solids may overlap.
  bool inside(const Vector3& p) const;

  /// Whether the hand can close about a part: its axis passes through `center` (m) along `axis` (need not be a unit
  /// vector), its radius is `radius` (m, >= 0).
  ///
  /// The approach is tried in steps of 15 degrees all around the axis. With u = axis x approach, the fingers are boxes
  /// on both sides along u: finger_width along the axis about `center`, finger_depth along the approach up to the
  /// fingertips, which stand max(3 mm, 0.3 radius) beyond the axis, so that the part lies between the pads. Each finger
  /// keeps its own distance of at least 0.7 radius to the axis; their sum, the opening, is between minimum and
  /// aperture. Neither may touch a surface or stand within a solid (exact, against every triangle), and on the line
  /// along u through `center` there must be matter between them. The first such approach with its smallest opening is
  /// returned.
  ///
  /// Only the two fingers are looked at: neither the palm nor the way there.
  /// @throws std::invalid_argument for a center or radius that is not finite, a negative radius, an axis of length zero
  GraspVerdict check(const Vector3& center, const Vector3& axis, double radius, const Hand& hand = {}) const;

  /// GraspVerdict::fits of the same, several times faster where something fits.
  bool fits(const Vector3& center, const Vector3& axis, double radius, const Hand& hand = {}) const;

 private:
  GraspVerdict search(const Vector3& center, const Vector3& axis, double radius, const Hand& hand, bool any) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handhold::sensor
