#include "revolution.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

/// Tilts are measured as the displacement at this distance along the axis (m).
constexpr double kArm = 0.02;
/// How far the axis may lie from where it starts (m, one standard deviation): what the points do not tell stays.
constexpr double kPrior = 0.003;

}  // namespace

bool step_axis_of_revolution(const PartPoints& points, double low, double width, std::size_t n, double sigma,
                             std::vector<RevolutionSums>& slices, Cylinder& c) {
  const double middle = low + 0.5 * static_cast<double>(n) * width;
  const auto slice_of = [&](std::size_t i) -> RevolutionSums& {
    const int at = static_cast<int>((points.height(i) - low) / width);
    return slices[static_cast<std::size_t>(std::clamp(at, 0, static_cast<int>(n) - 1))];
  };
  slices.assign(n, {});
  for (const std::uint32_t i : points.selected()) slice_of(i).w += 1, slice_of(i).d += points.distance(i);
  std::size_t filled = 0;
  for (RevolutionSums& s : slices) filled += s.w >= kLeastOfSlice;
  if (filled < 3) return false;
  std::vector<double> mean;
  for (const RevolutionSums& s : slices) mean.push_back(s.w > 0 ? s.d / s.w : 0);
  slices.assign(n, {});
  for (const std::uint32_t i : points.selected()) {
    const double distance = points.distance(i);
    if (!(distance > 0)) continue;
    RevolutionSums& s = slice_of(i);
    const double r = distance - mean[static_cast<std::size_t>(&s - slices.data())];
    const double weight = 1 / std::max(1.0, std::fabs(r) / (2 * sigma));
    const double e1 = points.side(i) / distance, e2 = points.ahead(i) / distance,
                 h = (points.height(i) - middle) / kArm;
    const double a[4] = {e1, e2, h * e1, h * e2};
    s.w += weight, s.d += weight * r;
    for (int j = 0, k = 0; j < 4; ++j) {
      s.a[j] += weight * a[j], s.ad[j] += weight * a[j] * r;
      for (int m = 0; m <= j; ++m, ++k) s.aa[k] += weight * a[j] * a[m];
    }
  }
  Eigen::Matrix4d A = Eigen::Matrix4d::Identity() * (sigma * sigma / (kPrior * kPrior));
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  for (const RevolutionSums& s : slices) {
    if (s.w < kLeastOfSlice) continue;
    for (int j = 0, k = 0; j < 4; ++j) {
      b[j] += s.ad[j] - s.a[j] * s.d / s.w;
      for (int m = 0; m <= j; ++m, ++k) A(j, m) += s.aa[k] - s.a[j] * s.a[m] / s.w;
    }
  }
  const Eigen::Vector4d x = A.selfadjointView<Eigen::Lower>().ldlt().solve(b);
  if (!x.allFinite()) return false;
  const CylinderFrame f = points.frame(c);
  const Vector3 at = c.point + middle * c.axis + x[0] * f.side + x[1] * f.ahead;
  c.axis = normalized(c.axis + (x[2] / kArm) * f.side + (x[3] / kArm) * f.ahead);
  // Heights keep their origin.
  c.point = at - middle * c.axis;
  return true;
}

}  // namespace handhold
