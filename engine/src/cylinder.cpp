#include "cylinder.h"

#include <algorithm>
#include <cmath>

#include "kernels.h"

namespace handhold {
namespace {

// Its limits are those of this fit, too.
using kernels::CylinderTrials;
/// For the rounding of a gain; and a cost that everything but a perfect fit is above.
constexpr double kGainSlack = 1.0001, kAlways = 1e-30;
/// Keeps unknowns that the points do not tell (a tilt of a short patch) where they are.
constexpr double kRidge = 1e-3;

struct Evaluated {
  kernels::CylinderEquations sums;
  Vector3 t1, t2;
};

/// Solves (A + damping * diag(A) + kRidge * I) x = b by Cholesky's factors L D L^T; A: lower triangle by rows. False
/// when rounding made the matrix indefinite.
bool solve(const float* A, double damping, const double* b, double* x) {
  double L[5][5], D[5], inverse[5];
  int k = 0;
#pragma GCC unroll 5
  for (int i = 0; i < 5; ++i) {
#pragma GCC unroll 5
    for (int j = 0; j < i; ++j, ++k) {
      double v = static_cast<double>(A[k]);
#pragma GCC unroll 5
      for (int m = 0; m < j; ++m) v -= L[i][m] * D[m] * L[j][m];
      L[i][j] = v * inverse[j];
    }
    D[i] = static_cast<double>(A[k++]) * (1 + damping) + kRidge;
#pragma GCC unroll 5
    for (int m = 0; m < i; ++m) D[i] -= L[i][m] * L[i][m] * D[m];
    if (!(D[i] > 0)) return false;
    inverse[i] = 1 / D[i];
  }
#pragma GCC unroll 5
  for (int i = 0; i < 5; ++i) {
    x[i] = b[i];
#pragma GCC unroll 5
    for (int m = 0; m < i; ++m) x[i] -= L[i][m] * x[m];
  }
#pragma GCC unroll 5
  for (int i = 4; i >= 0; --i) {
    x[i] *= inverse[i];
#pragma GCC unroll 5
    for (int m = i + 1; m < 5; ++m) x[i] -= L[m][i] * x[m];
  }
  return true;
}

/// Sum of n numbers in eight parts, which the machine can add up side by side.
double sum(const float* p, std::size_t n) {
  float parts[8] = {};
  std::size_t i = 0;
  for (; i + 8 <= n; i += 8)
    for (std::size_t k = 0; k < 8; ++k) parts[k] += p[i + k];
  double all = 0;
  for (; i < n; ++i) all += static_cast<double>(p[i]);
  for (const float part : parts) all += static_cast<double>(part);
  return all;
}

/// `skip_above`: kernels::CylinderQuery::skip_above
Evaluated evaluate(const PointArrays& points, const Cylinder& c, double sigma, double skip_above) {
  Evaluated e;
  e.t1 = any_perpendicular(c.axis), e.t2 = cross(c.axis, e.t1);
  kernels::CylinderQuery q;
  for (std::size_t k = 0; k < 3; ++k) {
    q.point[k] = static_cast<float>(c.point[k]), q.axis[k] = static_cast<float>(c.axis[k]);
    q.t1[k] = static_cast<float>(e.t1[k]), q.t2[k] = static_cast<float>(e.t2[k]);
  }
  q.radius = static_cast<float>(c.radius), q.sigma = static_cast<float>(sigma), q.arm = static_cast<float>(kTiltArm);
  q.skip_above = static_cast<float>(skip_above);
  kernels::kernels().cylinder(points.x, points.y, points.z, static_cast<std::int32_t>(points.n), q, e.sums);
  return e;
}

}  // namespace

double refine_cylinder(const PointArrays& points, double sigma, int steps, Cylinder& c) {
  if (points.n == 0) return 0;
  const double inverse = 1 / static_cast<double>(points.n);
  const Vector3 middle = inverse * Vector3{sum(points.x, points.n), sum(points.y, points.n), sum(points.z, points.n)};
  c.point = c.point + dot(middle - c.point, c.axis) * c.axis;

  double damping = 1e-3;
  Evaluated here = evaluate(points, c, sigma, steps > 0 ? 0 : kAlways);
  for (int step = 0; step < steps;) {
    double b[5], x[5];
    for (int i = 0; i < 5; ++i) b[i] = sigma * static_cast<double>(here.sums.b[i]);
    bool better = false;
    double gain = 0;
    for (int attempt = 0; attempt < 3 && !better && step < steps; ++attempt, ++step) {
      if (!solve(here.sums.A, damping, b, x)) {
        damping *= 10;
        continue;
      }
      Cylinder next;
      next.point = c.point + x[0] * here.t1 + x[1] * here.t2;
      next.axis = normalized(c.axis + (x[2] / kTiltArm) * here.t1 + (x[3] / kTiltArm) * here.t2);
      next.radius = c.radius + x[4];
      if (next.radius > CylinderTrials::kSmallest && next.radius < CylinderTrials::kLargest) {
        // The next step's equations, if there will be one.
        const double worth = kGainSlack * (1 - CylinderTrials::kLeastGain) * static_cast<double>(here.sums.cost);
        const Evaluated there = evaluate(points, next, sigma, step + 1 < steps ? worth : kAlways);
        better = there.sums.cost < here.sums.cost;
        if (better) {
          gain = 1 - static_cast<double>(there.sums.cost) / static_cast<double>(here.sums.cost);
          c = next, here = there;
        }
      }
      damping *= better ? 0.3 : 10;
    }
    if (!better || gain < CylinderTrials::kLeastGain) break;
  }
  return std::sqrt(static_cast<double>(here.sums.square) * inverse);
}

double turn_angle(float turn) {
  const float cosine = 1 - std::fabs(turn);
  return static_cast<double>(std::atan2(std::copysign(1 - std::fabs(cosine), turn), cosine));
}

double arc_of(const PointArrays& points, const Cylinder& c, const Vector3& towards) {
  constexpr std::size_t kMost = 128;
  static_assert(kMost * 3 / 100 < kernels::kTurns);
  const Vector3 ahead = normalized(towards - dot(towards, c.axis) * c.axis, any_perpendicular(c.axis));
  const Vector3 side = cross(c.axis, ahead);
  kernels::TurnQuery q;
  for (std::size_t k = 0; k < 3; ++k) {
    q.ahead[k] = static_cast<float>(ahead[k]), q.side[k] = static_cast<float>(side[k]);
    q.point[k] = static_cast<float>(c.point[k]);
  }
  const std::size_t stride = (points.n + kMost - 1) / kMost;
  if (stride == 0) return 0;
  const std::size_t n = (points.n + stride - 1) / stride;
  const float *x = points.x, *y = points.y, *z = points.z;
  float few[3][kMost + 16];
  if (stride > 1) {
    for (std::size_t i = 0; i < n; ++i) few[0][i] = x[stride * i], few[1][i] = y[stride * i], few[2][i] = z[stride * i];
    for (std::size_t k = 0; k < 3; ++k) std::fill_n(few[k] + n, 16, 0.0f);
    x = few[0], y = few[1], z = few[2];
  }
  float least[kernels::kTurns], most[kernels::kTurns];
  kernels::kernels().outer_turns(x, y, z, static_cast<std::int32_t>(n), q, least, most);
  const std::size_t low = n * 3 / 100, high = std::min(n - 1, n * 97 / 100);
  return turn_angle(most[n - 1 - high]) - turn_angle(least[low]);
}

}  // namespace handhold
