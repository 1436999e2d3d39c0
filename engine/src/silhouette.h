// Where a part ends to its left and right as the sensor sees it: a rod stands out against what is behind it on both
// sides, the rim of a bowl or the edge of a box goes on as a surface on one of them.
#pragma once

#include <array>
#include <cstddef>

#include "depth_image.h"
#include "vec3.h"

namespace handhold {

/// Beyond a step one looks one pixel, and so far (m): behind a bar lies what is behind it, at once; the face of a wall
/// that is seen at a grazing angle falls away by and by.
constexpr std::size_t kLooksBeyond = 3;
constexpr std::array<double, kLooksBeyond - 1> kBeyondStep = {0.004, 0.012};

/// What the depth image shows on one side of a place.
struct SilhouetteSide {
  enum Kind {
    kStep,     ///< the depth jumps away: the part ends at `at`
    kSurface,  ///< nothing ends within `at`
    kHidden    ///< something in front, or nothing measured, from `at` on
  };
  Kind kind = kHidden;
  double at = 0;  ///< m; distance from the place, across the line of sight
  /// m; of a step: how far behind its edge lies what is seen at each look beyond it; where nothing is known, as before
  std::array<double, kLooksBeyond> fall{};
};

/// How far from its middle one looks for the end of a part of that radius (m).
inline double silhouette_reach(double radius) {
  return 1.8 * radius + 0.008;
}

/// Follows the surface that is seen from `place` (m, on the side of a part towards the sensor) in direction `side`
/// (unit, across the part's axis), up to `reach` (m). `ahead`: unit, across both, towards the sensor. `sigma`: standard
/// deviation of depth there (m).
SilhouetteSide silhouette_side(const DepthImage& image, const Vector3& place, const Vector3& side, const Vector3& ahead,
                               double reach, double sigma);

}  // namespace handhold
