// Taubin fit by dense matrices and LAPACK, curvature of the quadric, and the circle across the axis.
#include <lapacke.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "baseline/stages.h"

namespace handhold::baseline {
namespace {

using Matrix10 = Eigen::Matrix<double, 10, 10>;

// Smallest pivot of the Cholesky factorisation of N' (before the square root) that a quadric may rest on.
constexpr double kMinPivot = 1e-9;

// M = mean of l l^T at the points y = (p - origin) * scale. Points are taken in chunks, one monomial a column, so that
// the entries are dot products of columns: over twice as fast here as adding one outer product for each point.
Matrix10 monomial_matrix(const PclCloud& cloud, const std::vector<int>& neighbours, const Eigen::Vector3d& origin,
                         double scale) {
  constexpr int kChunk = 32;
  Eigen::Matrix<double, kChunk, 10> l;
  Matrix10 M = Matrix10::Zero();
  const int n = static_cast<int>(neighbours.size());
  for (int begin = 0; begin < n; begin += kChunk) {
    const int count = std::min(kChunk, n - begin);
    for (int row = 0; row < count; ++row) {
      const pcl::PointXYZ& p = cloud[neighbours[begin + row]];
      l(row, 6) = (p.x - origin.x()) * scale;
      l(row, 7) = (p.y - origin.y()) * scale;
      l(row, 8) = (p.z - origin.z()) * scale;
      l(row, 9) = 1;
    }
    l.rightCols<4>().bottomRows(kChunk - count).setZero();
    l.col(0) = l.col(6).cwiseProduct(l.col(6));
    l.col(1) = l.col(7).cwiseProduct(l.col(7));
    l.col(2) = l.col(8).cwiseProduct(l.col(8));
    l.col(3) = l.col(6).cwiseProduct(l.col(7));
    l.col(4) = l.col(7).cwiseProduct(l.col(8));
    l.col(5) = l.col(6).cwiseProduct(l.col(8));
    for (int i = 0; i < 10; ++i)
      for (int j = i; j < 10; ++j) M(i, j) += l.col(i).dot(l.col(j));
  }
  M.triangularView<Eigen::StrictlyLower>() = M.transpose();
  return M / n;
}

// N = mean of l_x l_x^T + l_y l_y^T + l_z l_z^T. Its entries have degree two at most, and the last column of M, the
// mean of l itself, holds all of them.
Matrix10 gradient_matrix(const Matrix10& M) {
  const double xx = M(0, 9), yy = M(1, 9), zz = M(2, 9), xy = M(3, 9), yz = M(4, 9), xz = M(5, 9);
  const double x = M(6, 9), y = M(7, 9), z = M(8, 9);
  Matrix10 N = Matrix10::Zero();
  N.row(0) << 4 * xx, 0, 0, 2 * xy, 0, 2 * xz, 2 * x, 0, 0, 0;
  N.row(1) << 0, 4 * yy, 0, 2 * xy, 2 * yz, 0, 0, 2 * y, 0, 0;
  N.row(2) << 0, 0, 4 * zz, 0, 2 * yz, 2 * xz, 0, 0, 2 * z, 0;
  N.row(3) << 2 * xy, 2 * xy, 0, xx + yy, xz, yz, y, x, 0, 0;
  N.row(4) << 0, 2 * yz, 2 * yz, xz, yy + zz, xy, 0, z, y, 0;
  N.row(5) << 2 * xz, 0, 2 * xz, yz, xy, xx + zz, z, 0, x, 0;
  N.row(6) << 2 * x, 0, 0, y, 0, z, 1, 0, 0, 0;
  N.row(7) << 0, 2 * y, 0, x, z, 0, 0, 1, 0, 0;
  N.row(8) << 0, 0, 2 * z, 0, y, x, 0, 0, 1, 0;
  return N;
}

bool is_flat(const Matrix10& N) {
  Eigen::Matrix<double, 9, 9> L = N.topLeftCorner<9, 9>();
  for (int j = 0; j < 9; ++j) {
    const double pivot = L(j, j) - L.row(j).head(j).squaredNorm();
    if (!(pivot >= kMinPivot)) return true;
    L(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < 9; ++i) L(i, j) = (L(i, j) - L.row(i).head(j).dot(L.row(j).head(j))) / L(j, j);
  }
  return false;
}

constexpr int kRandomPoints = 50;
constexpr int kFixedPoints = 9;

// Value, gradient and Hessian of the quadric.
struct Surface {
  explicit Surface(const Vector10& c) : linear(c.segment<3>(6)), constant(c[9]) {
    hessian << 2 * c[0], c[3], c[5],  //
        c[3], 2 * c[1], c[4],         //
        c[5], c[4], 2 * c[2];
  }
  Eigen::Vector3d foot(Eigen::Vector3d y) const {
    for (int step = 0; step < 2; ++step) {
      const Eigen::Vector3d g = hessian * y + linear;
      const double f = 0.5 * y.dot(g + linear) + constant;
      const double g2 = g.squaredNorm();
      if (g2 > 0) y -= f / g2 * g;
    }
    return y;
  }

  Eigen::Matrix3d hessian;
  Eigen::Vector3d linear;
  double constant;
};

// Principal curvatures and directions: the paper's dense 3x3 eigenproblem of (I - N N^T) grad N. It is solved in its
// symmetric form P H P / |g|, which has the same curvatures and the same directions in the tangent plane; the general
// solver that the matrix as printed needs takes about twice as long.
struct PrincipalCurvature {
  PrincipalCurvature(const Surface& surface, const Eigen::Vector3d& y, int options) {
    const Eigen::Vector3d g = surface.hessian * y + surface.linear;
    const double length = g.norm();
    normal = length > 0 ? Eigen::Vector3d(g / length) : Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d P = Eigen::Matrix3d::Identity() - normal * normal.transpose();
    const Eigen::Matrix3d shape = P * surface.hessian * P / (length > 0 ? length : 1.0);
    solver.compute(shape, options);
  }
  double largest() const { return solver.eigenvalues().cwiseAbs().maxCoeff(); }
  Eigen::Vector3d direction_of_largest() const {
    Eigen::Index which;
    solver.eigenvalues().cwiseAbs().maxCoeff(&which);
    return solver.eigenvectors().col(which);
  }

  Eigen::Vector3d normal;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
};

}  // namespace

Quadric fit_quadric(const PclCloud& cloud, const std::vector<int>& neighbours, const Eigen::Vector3f& sample,
                    double radius) {
  Matrix10 M = monomial_matrix(cloud, neighbours, sample.cast<double>(), 1 / radius);
  Matrix10 N = gradient_matrix(M);

  Quadric quadric;
  if (is_flat(N)) {
    quadric.flat = true;
    return quadric;
  }

  quadric.mean = M.block<3, 1>(6, 9);
  quadric.covariance = M.block<3, 3>(6, 6) - quadric.mean * quadric.mean.transpose();

  // dggev destroys its matrices; N c is needed for the normalisation.
  const Matrix10 N_copy = N;
  Vector10 alpha_real, alpha_imaginary, beta;
  Matrix10 vectors;
  std::array<double, 1024> work;  // dggev asks for 80 at least; one block of 32 columns is more than it can use
  const lapack_int info = LAPACKE_dggev_work(LAPACK_COL_MAJOR, 'N', 'V', 10, M.data(), 10, N.data(), 10,
                                             alpha_real.data(), alpha_imaginary.data(), beta.data(), nullptr, 1,
                                             vectors.data(), 10, work.data(), static_cast<lapack_int>(work.size()));
  // The constant row of N is zero, so one eigenvalue is infinite (beta = 0 up to rounding).
  int best = -1;
  double lambda = std::numeric_limits<double>::infinity();
  for (int i = 0; info == 0 && i < 10; ++i) {
    if (std::abs(beta[i]) <= 1e-12 || alpha_imaginary[i] != 0) continue;
    if (alpha_real[i] / beta[i] < lambda) {
      lambda = alpha_real[i] / beta[i];
      best = i;
    }
  }
  if (best < 0) {
    quadric.flat = true;
    return quadric;
  }
  quadric.c = vectors.col(best);
  quadric.c /= std::sqrt(quadric.c.dot(N_copy * quadric.c));
  return quadric;
}

Curvature estimate_curvature(const Quadric& quadric, const PclCloud& cloud, const std::vector<int>& neighbours,
                             const Eigen::Vector3f& sample, double radius, CurvaturePoints points) {
  const Surface surface(quadric.c);
  const Eigen::Vector3d foot = surface.foot(Eigen::Vector3d::Zero());
  const PrincipalCurvature there(surface, foot, Eigen::ComputeEigenvectors);
  // Of the three directions one is the normal. Of the other two, the axis is the one across the larger curvature.
  const Eigen::Vector3d most = there.direction_of_largest();
  const Eigen::Vector3d least = most.cross(there.normal).normalized();

  std::array<double, std::max(kRandomPoints, kFixedPoints)> largest;
  int n = 0;
  const auto look_at = [&](const Eigen::Vector3d& y) {
    largest[n++] = PrincipalCurvature(surface, surface.foot(y), Eigen::EigenvaluesOnly).largest();
  };
  if (points == CurvaturePoints::kRandom) {
    std::minstd_rand random(static_cast<std::uint32_t>(neighbours.size()));  // the same sample, the same points
    while (n < kRandomPoints) {
      const pcl::PointXYZ& p = cloud[neighbours[random() % neighbours.size()]];
      look_at((p.getVector3fMap() - sample).cast<double>() / radius);
    }
  } else {
    // Spread as the neighbourhood is: 1.2 standard deviations along both principal directions at the sample's foot.
    const auto spread = [&](const Eigen::Vector3d& direction) {
      return Eigen::Vector3d(1.2 * std::sqrt(std::max(0.0, direction.dot(quadric.covariance * direction))) * direction);
    };
    const Eigen::Vector3d a = spread(least), b = spread(most);
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j) look_at(foot + i * a + j * b);
  }
  const auto middle = largest.begin() + n / 2;
  std::nth_element(largest.begin(), middle, largest.begin() + n);
  return {least, there.normal, *middle};
}

Circle fit_circle(const PclCloud& cloud, const std::vector<int>& neighbours, const Eigen::Vector3f& sample,
                  const Eigen::Vector3d& axis) {
  const Eigen::Vector3d origin = sample.cast<double>();
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  double su = 0, sv = 0, suu = 0, suv = 0, svv = 0, sul = 0, svl = 0;
  for (const int i : neighbours) {
    const Eigen::Vector3d offset = cloud[i].getVector3fMap().cast<double>() - origin;
    const double pu = u.dot(offset), pv = v.dot(offset);
    const double square = pu * pu + pv * pv;
    su += pu;
    sv += pv;
    suu += pu * pu;
    suv += pu * pv;
    svv += pv * pv;
    sul += pu * square;
    svl += pv * square;
  }
  const double n = static_cast<double>(neighbours.size());
  const double mu = su / n, mv = sv / n;
  const double cuu = suu / n - mu * mu, cuv = suv / n - mu * mv, cvv = svv / n - mv * mv;
  const double trace = cuu + cvv;
  if (!(cuu * cvv - cuv * cuv > 1e-12 * trace * trace)) return {origin, std::numeric_limits<double>::infinity()};

  // sum l l^T (a, b, c)^T = -sum lambda l with l = (u, v, 1), lambda = u^2 + v^2
  Eigen::Matrix3d A;
  A << suu, suv, su,  //
      suv, svv, sv,   //
      su, sv, n;
  const Eigen::Vector3d abc = A.ldlt().solve(-Eigen::Vector3d(sul, svl, suu + svv));
  const double radius2 = 0.25 * (abc[0] * abc[0] + abc[1] * abc[1]) - abc[2];
  return {origin - 0.5 * (abc[0] * u + abc[1] * v), std::sqrt(std::max(0.0, radius2))};
}

}  // namespace handhold::baseline
