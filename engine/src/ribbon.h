// Thin parts by their outline. The strap of a mug's handle is a few pixels wide and, in the noise, as often flat or
// hollow as round: no fit tells it from anything. In the depth image it is a strip that ends at a step on either side.
#pragma once

#include "cylinder.h"
#include "depth_image.h"

namespace handhold {

/// Looks for a strip about `sample` (m), up to 30 mm wide and at least 20 mm long: its axis, and half its width as the
/// radius. False: there is none.
bool find_ribbon(const DepthImage& image, const Vector3& sample, Cylinder& ribbon);

}  // namespace handhold
