// Where a part ends to its left and right as the sensor sees it: a rod stands out against what is behind it on both
// sides, the rim of a bowl or the edge of a box goes on as a surface on one of them.
#pragma once

#include "depth_image.h"
#include "vec3.h"

namespace handhold {

/// What the depth image shows on one side of a place.
struct SilhouetteSide {
  enum Kind {
    kStep,     ///< the depth jumps away: the part ends at `at`
    kSurface,  ///< nothing ends within `at`
    kHidden    ///< something in front, or nothing measured, from `at` on
  };
  Kind kind = kHidden;
  double at = 0;  ///< m; distance from the place, across the line of sight
};

/// Follows the surface that is seen from `place` (m, on the side of a part towards the sensor) in direction `side`
/// (unit, across the part's axis), up to `reach` (m). `ahead`: unit, across both, towards the sensor. `sigma`: standard
/// deviation of depth there (m).
SilhouetteSide silhouette_side(const DepthImage& image, const Vector3& place, const Vector3& side, const Vector3& ahead,
                               double reach, double sigma);

}  // namespace handhold
