// A quick look at the depth image that tells where a sample is worth its work.
#pragma once

#include "depth_image.h"
#include "vec3.h"

namespace handhold {

/// False: the surface seen at `place` (m) is flat or hollow there, so that nothing narrower than 2 * `reach` (m) can be
/// held by it. True when it bulges towards the sensor in some direction, when it ends nearby, or when what is seen
/// there is not the place itself.
bool bends(const DepthImage& image, const Vector3& place, double reach);

}  // namespace handhold
