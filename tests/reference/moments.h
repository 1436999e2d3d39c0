// Moments up to degree 4: all that a quadric fit, a circle fit and a covariance need to know of a neighbourhood.
#pragma once

#include <Eigen/Core>
#include <array>
#include <stdexcept>
#include <vector>

#include "reference/neighbours.h"

namespace handhold::reference {

inline constexpr int kMomentCount = 35;

/// Exponents of x^i y^j z^k.
using Exponents = std::array<int, 3>;

/// The 35 monomials with i + j + k <= 4: by degree, within a degree by falling i, then falling j.
inline const std::array<Exponents, kMomentCount>& monomials() {
  static const std::array<Exponents, kMomentCount> list = [] {
    std::array<Exponents, kMomentCount> all{};
    int n = 0;
    for (int degree = 0; degree <= 4; ++degree)
      for (int i = degree; i >= 0; --i)
        for (int j = degree - i; j >= 0; --j) all[n++] = {i, j, degree - i - j};
    return all;
  }();
  return list;
}

/// Position of x^i y^j z^k in `monomials()`. @throws std::out_of_range for a degree above 4
inline int monomial_index(const Exponents& e) {
  for (int n = 0; n < kMomentCount; ++n)
    if (monomials()[n] == e) return n;
  throw std::out_of_range("monomial_index: exponents must be >= 0 and add up to at most 4");
}

template <class T>
T power(T x, int exponent) {
  T product = 1;
  for (int i = 0; i < exponent; ++i) product *= x;
  return product;
}

/// x^i y^j z^k
template <class T>
T monomial(const Eigen::Matrix<T, 3, 1>& p, const Exponents& e) {
  return power(p.x(), e[0]) * power(p.y(), e[1]) * power(p.z(), e[2]);
}

/// Sums of the 35 monomials over points; the first is the number of points.
template <class T>
using MomentSums = Eigen::Matrix<T, kMomentCount, 1>;

template <class T = double>
MomentSums<T> moment_sums(const Points& points) {
  MomentSums<T> sums = MomentSums<T>::Zero();
  for (const Vector3d& p : points)
    for (int n = 0; n < kMomentCount; ++n) sums[n] += monomial<T>(p.cast<T>(), monomials()[n]);
  return sums;
}

/// Mean of x^i y^j z^k.
template <class T>
T mean_of(const MomentSums<T>& sums, const Exponents& e) {
  return sums[monomial_index(e)] / sums[0];
}

/// Mean of the points.
template <class T>
Eigen::Matrix<T, 3, 1> mean_point(const MomentSums<T>& sums) {
  return {mean_of(sums, {1, 0, 0}), mean_of(sums, {0, 1, 0}), mean_of(sums, {0, 0, 1})};
}

/// Covariance of the points about their mean.
template <class T>
Eigen::Matrix<T, 3, 3> covariance(const MomentSums<T>& sums) {
  Eigen::Matrix<T, 3, 3> C;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      Exponents e{};
      ++e[a];
      ++e[b];
      C(a, b) = mean_of(sums, e);
    }
  return C - mean_point(sums) * mean_point(sums).transpose();
}

}  // namespace handhold::reference
