// Other ways to the axis of a neighbourhood, to compare the quadric's with.
#pragma once

#include <vector>

#include "handhold/cloud.h"
#include "handhold/options.h"
#include "index.h"
#include "kernels.h"
#include "tiles.h"

namespace handhold {

/// Direction of largest spread of the points, from their moments (as the published code does). In the frame of the
/// moments; unit.
Vector3 axis_from_spread(const kernels::Moments& moments);

/// Unit normals of all points of a cloud, each from the plane of least squares through the points within `radius`. They
/// stand as the points do: [tile][3][16]. A point with fewer than three neighbours has normal 0.
void estimate_normals(const TileStore& tiles, const NeighbourIndex& index, float radius, AlignedArray<float>& normals);

/// Eigenvector of the least eigenvalue of sum n n^T over the points in a ball (paper, section 3.1, the alternative).
/// centre, radius in m; in the cloud's frame; unit.
Vector3 axis_from_normals(const TileStore& tiles, const kernels::Candidates& near, const float* normals,
                          const float* centre, float radius);

}  // namespace handhold
