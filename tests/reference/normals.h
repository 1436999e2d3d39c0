// The axis without a quadric: from the points' normals (the alternative of section 3.1 of the paper), or from the
// points' spread alone.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reference/neighbours.h"

namespace handhold::reference {

/// Mean of (p - mean) (p - mean)^T.
Eigen::Matrix3d scatter(const Points& points);

/// Normal of the plane that fits the neighbours of `p` best; unit, sign arbitrary. Zero for fewer than three
/// neighbours.
Vector3d normal_at(const Points& points, const Vector3d& p, double radius);

/// The direction that is most nearly across all normals: least eigenvector of the sum of n n^T. Unit, sign arbitrary.
Vector3d axis_from_normals(const Points& normals);

/// Direction of largest spread of the points. Unit, sign arbitrary.
Vector3d axis_from_spread(const Points& points);

}  // namespace handhold::reference
