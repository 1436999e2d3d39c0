// Algorithm 1 of the paper for one sample: from a neighbourhood to an affordance, or to the step that refused it.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "handhold/options.h"
#include "reference/circle.h"
#include "reference/curvature.h"
#include "reference/moments.h"
#include "reference/neighbours.h"
#include "reference/normals.h"
#include "reference/shell.h"
#include "reference/taubin.h"

namespace handhold::reference {

struct Cloud {
  Points points;                                          ///< m; not finite where nothing was measured
  std::optional<Vector3d> viewpoint = Vector3d(0, 0, 0);  ///< m; none: no single viewpoint
  Points normals = {};  ///< for AxisEstimator::kNormals: a unit normal per point, zero where unknown
};

/// Where a sample ended. The names are those of the funnel.
enum class Step { kTooFewPoints, kFlat, kCurvatureLow, kCircleWide, kCircleNarrow, kNoGap, kShellEmpty, kAffordance };

struct Affordance {
  Vector3d center = Vector3d::Zero();          ///< m; point of the axis at the sample's height
  Vector3d axis = Vector3d::Zero();            ///< unit; largest component positive
  Vector3d normal = Vector3d::Zero();          ///< unit; towards the viewpoint, or away from the axis when there is none
  double radius = 0;        ///< m; of the fitted circle
  double shell_radius = 0;  ///< m
  double gap = 0;           ///< m; free width beyond shell_radius
  double curvature = 0;     ///< 1/m; median of the larger absolute curvature
};

/// What every step found, as far as the sample came.
struct SampleResult {
  Step step = Step::kTooFewPoints;
  int neighbours = 0;
  Quadric<double> quadric;      ///< scaled
  Curvature<double> curvature;  ///< scaled
  Vector3d axis = Vector3d::Zero();
  Circle circle;  ///< m, relative to the sample
  ShellQuery shell_query;
  Shell shell;
  Affordance affordance;  ///< valid when step is kAffordance
};

/// Standard deviation of a structured-light depth camera at distance z (m): 0.8 mm up to 0.4 m, growing with the
/// square.
inline double depth_sigma(double z) {
  return z < 0.4 ? 0.8e-3 : 0.8e-3 + 1.9e-3 * (z - 0.4) * (z - 0.4);
}

/// Largest component positive: one of the two ways to write down the same axis.
inline Vector3d canonical_axis(const Vector3d& axis) {
  Eigen::Index largest;
  axis.cwiseAbs().maxCoeff(&largest);
  return axis[largest] < 0 ? Vector3d(-axis) : axis;
}

inline Vector3d estimate_axis(const Cloud& cloud, const Vector3d& sample, double radius, AxisEstimator estimator,
                              const Curvature<double>& curvature) {
  if (estimator == AxisEstimator::kTaubin) return curvature.at_foot.minor_direction;
  if (estimator == AxisEstimator::kPca) return axis_from_spread(scaled_neighbourhood(cloud.points, sample, radius));
  Points normals;
  for (std::size_t i : neighbours(cloud.points, sample, radius)) normals.push_back(cloud.normals.at(i));
  return axis_from_normals(normals);
}

/// Thresholds of the shell: areas times the neighbourhood's own density of points, so that a decision does not depend
/// on how densely a surface was sampled.
inline ShellQuery shell_query(const Cloud& cloud, const Vector3d& sample, int count, double circle_radius,
                              const Options& options) {
  const double radius = options.effective_radius().front();
  const double per_mm2 = count / (M_PI * radius * radius) * 1e-6;
  const double z = cloud.viewpoint ? (sample - *cloud.viewpoint).norm() : 0.0;
  ShellQuery query;
  query.start_radius = 0.7 * circle_radius;
  query.max_radius = options.hand_aperture / 2 + std::min(2 * depth_sigma(z), 0.1 * options.hand_aperture) + 2e-3;
  query.gap = options.finger_thickness;
  query.max_gap_points = static_cast<int>(std::floor(options.shell_gap_area_mm2 * per_mm2));
  query.min_inner_points = std::max(1, static_cast<int>(std::ceil(options.shell_inner_area_mm2 * per_mm2)));
  return query;
}

/// Looks at one sample with the first radius of the options.
inline SampleResult localize_sample(const Cloud& cloud, const Vector3d& sample, const Options& options) {
  const double radius = options.effective_radius().front();
  SampleResult result;
  const auto ended_at = [&result](Step step) {
    result.step = step;
    return result;
  };

  const Points scaled = scaled_neighbourhood(cloud.points, sample, radius);
  result.neighbours = static_cast<int>(scaled.size());
  if (result.neighbours < options.min_neighbours) return ended_at(Step::kTooFewPoints);

  const MomentSums<double> sums = moment_sums(scaled);
  result.quadric = fit_quadric(sums);
  if (result.quadric.flat) return ended_at(Step::kFlat);
  result.curvature = curvature(result.quadric.coefficients, sums);
  if (result.curvature.median / radius < 1 / options.effective_reach()) return ended_at(Step::kCurvatureLow);

  result.axis = estimate_axis(cloud, sample, radius, options.axis, result.curvature);
  const Circle circle = fit_circle(scaled, result.axis);
  result.circle = {circle.centre * radius, circle.radius * radius};
  if (2 * result.circle.radius > options.hand_aperture) return ended_at(Step::kCircleWide);
  if (2 * result.circle.radius < options.hand_minimum) return ended_at(Step::kCircleNarrow);

  const Vector3d center = sample + result.circle.centre;
  result.shell_query = shell_query(cloud, sample, result.neighbours, result.circle.radius, options);
  const std::vector<double> rho = distances_to_axis(cloud.points, center, result.axis, options.finger_width / 2);
  result.shell = find_shell_by_jumps(rho, result.shell_query);
  if (result.shell.status == ShellStatus::kNoGap) return ended_at(Step::kNoGap);
  if (result.shell.status == ShellStatus::kEmpty) return ended_at(Step::kShellEmpty);

  const Vector3d outward = cloud.viewpoint ? Vector3d(*cloud.viewpoint - sample) : Vector3d(sample - center);
  const Vector3d& normal = result.curvature.at_foot.normal;
  result.affordance.center = center;
  result.affordance.axis = canonical_axis(result.axis);
  result.affordance.normal = normal.dot(outward) < 0 ? Vector3d(-normal) : normal;
  result.affordance.radius = result.circle.radius;
  result.affordance.shell_radius = result.shell.radius;
  result.affordance.gap = result.shell.free_to - result.shell.radius;
  result.affordance.curvature = result.curvature.median / radius;
  return ended_at(Step::kAffordance);
}

}  // namespace handhold::reference
