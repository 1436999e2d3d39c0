// What takes long to compile, compiled once.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "reference/reference.h"

namespace handhold::reference {

HANDHOLD_TAUBIN_INSTANCES(, double)
HANDHOLD_TAUBIN_INSTANCES(, long double)
HANDHOLD_CURVATURE_INSTANCES(, double)
HANDHOLD_CURVATURE_INSTANCES(, long double)

Eigen::Matrix3d scatter(const Points& points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) C += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  return C;
}

Vector3d normal_at(const Points& points, const Vector3d& p, double radius) {
  const Points near = scaled_neighbourhood(points, p, radius);
  if (near.size() < 3) return Vector3d::Zero();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter(near)).eigenvectors().col(0);
}

Vector3d axis_from_normals(const Points& normals) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Vector3d& n : normals) sum += n * n.transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors().col(0);
}

Vector3d axis_from_spread(const Points& points) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter(points)).eigenvectors().col(2);
}

Circle fit_circle(const Points& points, const Vector3d& axis) {
  Circle circle;
  if (points.empty()) return circle;
  const Vector3d u = axis.unitOrthogonal();
  const Vector3d v = axis.cross(u);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Vector3d& p : points) mean += Eigen::Vector2d(u.dot(p), v.dot(p)) / static_cast<double>(points.size());

  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  Eigen::Vector2d skew = Eigen::Vector2d::Zero();  // sum of q |q|^2
  double mean_square = 0;
  for (const Vector3d& p : points) {
    const Eigen::Vector2d q = Eigen::Vector2d(u.dot(p), v.dot(p)) - mean;
    scatter += q * q.transpose();
    skew += q * q.squaredNorm();
    mean_square += q.squaredNorm() / static_cast<double>(points.size());
  }
  if (!(scatter.determinant() > kSingularScatter * scatter.trace() * scatter.trace())) return circle;
  const Eigen::Vector2d offset = scatter.inverse() * skew / 2;  // of the centre from the mean
  const Eigen::Vector2d centre = mean + offset;
  circle.centre = centre.x() * u + centre.y() * v;
  circle.radius = std::sqrt(offset.squaredNorm() + mean_square);
  return circle;
}

}  // namespace handhold::reference
