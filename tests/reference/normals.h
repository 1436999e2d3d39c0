// The axis without a quadric: from the points' normals (the alternative of section 3.1 of the paper), or from the
// points' spread alone.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <vector>

#include "reference/neighbours.h"

namespace handhold::reference {

/// Mean of (p - mean) (p - mean)^T.
inline Eigen::Matrix3d scatter(const Points& points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) C += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  return C;
}

/// Normal of the plane that fits the neighbours of `p` best; unit, sign arbitrary. Zero for fewer than three
/// neighbours.
inline Vector3d normal_at(const Points& points, const Vector3d& p, double radius) {
  const Points near = scaled_neighbourhood(points, p, radius);
  if (near.size() < 3) return Vector3d::Zero();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter(near)).eigenvectors().col(0);
}

/// The direction that is most nearly across all normals: least eigenvector of the sum of n n^T. Unit, sign arbitrary.
inline Vector3d axis_from_normals(const Points& normals) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Vector3d& n : normals) sum += n * n.transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors().col(0);
}

/// Direction of largest spread of the points. Unit, sign arbitrary.
inline Vector3d axis_from_spread(const Points& points) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter(points)).eigenvectors().col(2);
}

}  // namespace handhold::reference
