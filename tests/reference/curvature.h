// Curvature of a quadric f = 0 (paper, section 3.1): eigenvalues of the shape operator P H P / |g| with g = grad f,
// H = Hessian of f, n = g / |g|, P = I - n n^T.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "reference/taubin.h"

namespace handhold::reference {

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

template <class T>
T quadric_value(const QuadricVector<T>& c, const Vector3<T>& p) {
  T sum = 0;
  for (int a = 0; a < kQuadricTerms; ++a) sum += c[a] * monomial(p, kQuadric[a]);
  return sum;
}

template <class T>
Eigen::Matrix<T, 3, 3> quadric_hessian(const QuadricVector<T>& c) {
  Eigen::Matrix<T, 3, 3> H;
  H << 2 * c[0], c[3], c[5],  //
      c[3], 2 * c[1], c[4],   //
      c[5], c[4], 2 * c[2];
  return H;
}

template <class T>
Vector3<T> quadric_gradient(const QuadricVector<T>& c, const Vector3<T>& p) {
  return quadric_hessian(c) * p + c.template segment<3>(6);
}

/// The point of the surface near p: two Newton steps along the gradient. Where the gradient vanishes p stays.
template <class T>
Vector3<T> foot(const QuadricVector<T>& c, Vector3<T> p) {
  for (int step = 0; step < 2; ++step) {
    const Vector3<T> g = quadric_gradient(c, p);
    const T g2 = g.squaredNorm();
    if (g2 > 0) p -= quadric_value(c, p) / g2 * g;
  }
  return p;
}

template <class T>
struct PrincipalCurvatures {
  Vector3<T> normal = Vector3<T>::Zero();  ///< unit; along the gradient
  T minor = 0,
    major = 0;  ///< of smaller and larger absolute value; positive where a sphere with outward gradient has it
  Vector3<T> minor_direction = Vector3<T>::Zero(), major_direction = Vector3<T>::Zero();  ///< unit, tangent; sign arbitrary
};

template <class T>
PrincipalCurvatures<T> principal_curvatures(const QuadricVector<T>& c, const Vector3<T>& p) {
  const Vector3<T> g = quadric_gradient(c, p);
  PrincipalCurvatures<T> k;
  k.normal = g.norm() > 0 ? Vector3<T>(g / g.norm()) : Vector3<T>::UnitZ();
  Eigen::Matrix<T, 3, 2> tangents;
  tangents.col(0) = k.normal.unitOrthogonal();
  tangents.col(1) = k.normal.cross(tangents.col(0));
  const Eigen::Matrix<T, 2, 2> shape =
      tangents.transpose() * quadric_hessian(c) * tangents / (g.norm() > 0 ? g.norm() : T(1));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<T, 2, 2>> solver(shape);
  const int minor = std::abs(solver.eigenvalues()[0]) <= std::abs(solver.eigenvalues()[1]) ? 0 : 1;
  k.minor = solver.eigenvalues()[minor];
  k.major = solver.eigenvalues()[1 - minor];
  k.minor_direction = tangents * solver.eigenvectors().col(minor);
  k.major_direction = tangents * solver.eigenvectors().col(1 - minor);
  return k;
}

/// What the fit says about a neighbourhood, in its scaled frame (curvatures in 1/radius).
template <class T>
struct Curvature {
  PrincipalCurvatures<T> at_foot;  ///< at the sample's foot: its minor_direction is the axis
  T median = 0;                    ///< median of the larger absolute curvature over nine points of the neighbourhood
  T least_gradient = 0;            ///< least |g| met at the ten points: how well defined all this is
};

/// The nine points: a 3x3 grid about the sample's foot along the principal directions there, 1.2 standard deviations
/// apart, each brought to the surface. No random numbers, and the sign of a direction does not matter.
template <class T>
std::array<Vector3<T>, 9> nine_points(const QuadricVector<T>& c, const MomentSums<T>& sums) {
  const Vector3<T> q = foot(c, Vector3<T>(Vector3<T>::Zero()));
  const PrincipalCurvatures<T> k = principal_curvatures(c, q);
  const Eigen::Matrix<T, 3, 3> C = covariance(sums);
  const Vector3<T>& a = k.minor_direction;
  const Vector3<T>& b = k.major_direction;
  const auto spread = [&C](const Vector3<T>& d) { return T(1.2) * std::sqrt(std::max(T(0), d.dot(C * d))); };
  std::array<Vector3<T>, 9> points;
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      points[3 * (i + 1) + (j + 1)] = foot(c, Vector3<T>(q + i * spread(a) * a + j * spread(b) * b));
  return points;
}

template <class T>
Curvature<T> curvature(const QuadricVector<T>& c, const MomentSums<T>& sums) {
  Curvature<T> result;
  const Vector3<T> sample_foot = foot(c, Vector3<T>(Vector3<T>::Zero()));
  result.at_foot = principal_curvatures(c, sample_foot);
  result.least_gradient = quadric_gradient(c, sample_foot).norm();
  std::array<T, 9> major;
  int n = 0;
  for (const Vector3<T>& p : nine_points(c, sums)) {
    major[n++] = std::abs(principal_curvatures(c, p).major);
    result.least_gradient = std::min(result.least_gradient, quadric_gradient(c, p).norm());
  }
  std::sort(major.begin(), major.end());
  result.median = major[4];
  return result;
}

#define HANDHOLD_CURVATURE_INSTANCES(PREFIX, T)                                                            \
  PREFIX template Vector3<T> foot(const QuadricVector<T>&, Vector3<T>);                                    \
  PREFIX template PrincipalCurvatures<T> principal_curvatures(const QuadricVector<T>&, const Vector3<T>&); \
  PREFIX template std::array<Vector3<T>, 9> nine_points(const QuadricVector<T>&, const MomentSums<T>&);    \
  PREFIX template Curvature<T> curvature(const QuadricVector<T>&, const MomentSums<T>&);
HANDHOLD_CURVATURE_INSTANCES(extern, double)
HANDHOLD_CURVATURE_INSTANCES(extern, long double)

}  // namespace handhold::reference
