// Taubin's fit of a quadric (paper, section 3.1, eq. 1 and 2): of all f = c . l the one with the least mean of f^2 per
// mean of |grad f|^2.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

#include "reference/moments.h"

namespace handhold::reference {

/// The monomials of a quadric, l = (x^2, y^2, z^2, xy, yz, xz, x, y, z, 1).
inline constexpr int kQuadricTerms = 10;
inline constexpr std::array<Exponents, kQuadricTerms> kQuadric = {
    {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};

template <class T>
using QuadricVector = Eigen::Matrix<T, 10, 1>;
template <class T>
using QuadricMatrix = Eigen::Matrix<T, 10, 10>;

/// Mean of l l^T.
template <class T>
QuadricMatrix<T> mean_values(const MomentSums<T>& sums) {
  QuadricMatrix<T> M;
  for (int a = 0; a < kQuadricTerms; ++a)
    for (int b = 0; b < kQuadricTerms; ++b) {
      Exponents e;
      for (int axis = 0; axis < 3; ++axis) e[axis] = kQuadric[a][axis] + kQuadric[b][axis];
      M(a, b) = mean_of(sums, e);
    }
  return M;
}

/// Mean of l_x l_x^T + l_y l_y^T + l_z l_z^T, with l_x the derivative of l along x.
template <class T>
QuadricMatrix<T> mean_gradients(const MomentSums<T>& sums) {
  QuadricMatrix<T> N = QuadricMatrix<T>::Zero();
  for (int axis = 0; axis < 3; ++axis)
    for (int a = 0; a < kQuadricTerms; ++a)
      for (int b = 0; b < kQuadricTerms; ++b) {
        const int factor = kQuadric[a][axis] * kQuadric[b][axis];  // of d/dx x^i = i x^(i-1)
        if (factor == 0) continue;
        Exponents e;
        for (int i = 0; i < 3; ++i) e[i] = kQuadric[a][i] + kQuadric[b][i];
        e[axis] -= 2;
        N(a, b) += factor * mean_of(sums, e);
      }
  return N;
}

/// The problem without the constant term. A constant has no gradient, so c10 is free to make the mean of f zero, and
/// what remains is (M - lambda N) c' = 0 in nine unknowns.
template <class T>
struct TaubinProblem {
  Eigen::Matrix<T, 9, 9> M;     ///< covariance of l'
  Eigen::Matrix<T, 9, 9> N;     ///< mean of the gradients' products
  Eigen::Matrix<T, 9, 1> mean;  ///< mean of l'
};

template <class T>
TaubinProblem<T> taubin_problem(const MomentSums<T>& sums) {
  const QuadricMatrix<T> M = mean_values(sums);
  TaubinProblem<T> problem;
  problem.mean = M.template topRightCorner<9, 1>();
  problem.M = M.template topLeftCorner<9, 9>() - problem.mean * problem.mean.transpose();
  problem.N = mean_gradients(sums).template topLeftCorner<9, 9>();
  return problem;
}

/// Below this a pivot of N counts as zero: every point then lies on one plane (or line, or place), where some
/// polynomial vanishes together with its gradient and the quotient means nothing.
inline constexpr double kFlatPivot = 1e-9;

/// Smallest pivot of the Cholesky factorisation of N, before the square root, with the linear terms taken first: their
/// pivots are 1, and those of the squares then do not depend on where the origin is.
template <class T>
T smallest_pivot(const Eigen::Matrix<T, 9, 9>& N) {
  Eigen::Matrix<T, 6, 6> rest =
      N.template topLeftCorner<6, 6>() - N.template topRightCorner<6, 3>() * N.template bottomLeftCorner<3, 6>();
  T smallest = 1;
  for (int k = 0; k < 6; ++k) {
    const T pivot = rest(k, k);
    if (!(pivot > 0)) return pivot;  // also NaN, for no points at all
    smallest = std::min(smallest, pivot);
    for (int i = k + 1; i < 6; ++i)
      for (int j = k + 1; j < 6; ++j) rest(i, j) -= rest(i, k) * rest(k, j) / pivot;
  }
  return smallest;
}

template <class T>
struct Quadric {
  bool flat = true;                                          ///< the points define no quadric; nothing below is valid
  QuadricVector<T> coefficients = QuadricVector<T>::Zero();  ///< sign arbitrary, c^T N c = 1
  T lambda = 0;                                              ///< smallest generalized eigenvalue: mean of f^2
  T next_lambda = 0;                                         ///< the second one: how well defined the solution is
};

template <class T>
Quadric<T> fit_quadric(const MomentSums<T>& sums) {
  const TaubinProblem<T> problem = taubin_problem(sums);
  Quadric<T> fit;
  if (!(smallest_pivot(problem.N) >= T(kFlatPivot))) return fit;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix<T, 9, 9>> solver(problem.M, problem.N);
  fit.flat = false;
  fit.lambda = solver.eigenvalues()[0];
  fit.next_lambda = solver.eigenvalues()[1];
  const Eigen::Matrix<T, 9, 1> c = solver.eigenvectors().col(0);  // Eigen returns them with c^T N c = 1
  fit.coefficients << c, -problem.mean.dot(c);
  return fit;
}

// Eigen's solvers take most of a minute to compile: instances.cpp does so once for all tests.
#define HANDHOLD_TAUBIN_INSTANCES(PREFIX, T)                             \
  PREFIX template TaubinProblem<T> taubin_problem(const MomentSums<T>&); \
  PREFIX template T smallest_pivot(const Eigen::Matrix<T, 9, 9>&);       \
  PREFIX template Quadric<T> fit_quadric(const MomentSums<T>&);
HANDHOLD_TAUBIN_INSTANCES(extern, double)
HANDHOLD_TAUBIN_INSTANCES(extern, long double)

}  // namespace handhold::reference
