#include "baseline/baseline.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "baseline/stages.h"

namespace handhold::baseline {
namespace {

Vector3 array(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

// Adds the time since the last call to a stage.
class StageClock {
 public:
  void lap(double& stage) {
    const auto now = Clock::now();
    stage += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }
  double since_start() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
};

// An axis has no sign: its largest component is made positive.
Eigen::Vector3d canonical(const Eigen::Vector3d& axis) {
  Eigen::Index largest;
  axis.cwiseAbs().maxCoeff(&largest);
  return axis[largest] < 0 ? Eigen::Vector3d(-axis) : axis;
}

// Standard deviation (m) of a depth measurement at distance z (m) from the sensor.
double depth_sigma(double z) {
  return z < 0.4 ? 0.0008 : 0.0008 + 0.0019 * (z - 0.4) * (z - 0.4);
}

// The normal on the side of the sensor; without one, on the side away from the circle's axis.
Eigen::Vector3d outward_normal(const CloudView& cloud, const Eigen::Vector3f& sample, const Eigen::Vector3d& center,
                               const Eigen::Vector3d& normal) {
  const Eigen::Vector3d p = sample.cast<double>();
  Eigen::Vector3d outward = p - center;
  if (cloud.viewpoint) outward = Eigen::Vector3d(cloud.viewpoint->data()) - p;
  return normal.dot(outward) < 0 ? Eigen::Vector3d(-normal) : normal;
}

ShellLimits shell_limits(const CloudView& cloud, const Options& options, const Eigen::Vector3f& sample,
                         std::size_t neighbours, double circle_radius) {
  const double radius = options.effective_radius().front();
  const double density = static_cast<double>(neighbours) / (M_PI * radius * radius);  // points per m^2
  double distance = 0;
  if (cloud.viewpoint) distance = (sample.cast<double>() - Eigen::Vector3d(cloud.viewpoint->data())).norm();
  ShellLimits limits{};
  limits.half_width = options.finger_width / 2;
  limits.start_radius = 0.7 * circle_radius;
  limits.max_radius = options.hand_aperture / 2 + std::min(2 * depth_sigma(distance), 0.1 * options.hand_aperture) + 0.002;
  limits.gap = options.finger_thickness;
  limits.max_gap_points = static_cast<int>(std::floor(options.shell_gap_area_mm2 * 1e-6 * density));
  limits.min_inner_points = std::max(1, static_cast<int>(std::ceil(options.shell_inner_area_mm2 * 1e-6 * density)));
  return limits;
}

}  // namespace

std::string_view to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::kTooFewPoints:
      return "too_few_points";
    case Outcome::kFlat:
      return "flat";
    case Outcome::kCurvatureLow:
      return "curvature_low";
    case Outcome::kCircleWide:
      return "circle_wide";
    case Outcome::kCircleNarrow:
      return "circle_narrow";
    case Outcome::kNoGap:
      return "no_gap";
    case Outcome::kShellEmpty:
      return "shell_empty";
    case Outcome::kAffordance:
      return "affordance";
  }
  return "";
}

Result localize(const CloudView& view, const Options& options, const std::vector<std::array<float, 3>>& samples,
                const Settings& settings) {
  Result result;
  result.samples.resize(samples.size());
  StageSeconds& seconds = result.seconds;
  StageClock clock;

  const PclCloud::Ptr cloud = to_pcl(view);
  RadiusSearch search(cloud, settings.search);
  clock.lap(seconds.index);

  const double radius = options.effective_radius().front();
  const double reach = options.effective_reach();
  std::vector<float> rho2;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    SampleResult& out = result.samples[s];
    out.affordance.sample = static_cast<std::uint32_t>(s);
    const Eigen::Vector3f sample(samples[s][0], samples[s][1], samples[s][2]);

    const std::vector<int>& neighbours = search.find(sample, radius);
    const std::size_t count = neighbours.size();  // the shell's search reuses the list
    out.neighbours = static_cast<std::int32_t>(count);
    clock.lap(seconds.neighbours);
    out.outcome = Outcome::kTooFewPoints;
    if (out.neighbours < options.min_neighbours) continue;

    const Quadric quadric = fit_quadric(*cloud, neighbours, sample, radius);
    clock.lap(seconds.fit);
    out.outcome = Outcome::kFlat;
    if (quadric.flat) continue;

    const Curvature curvature = 
        estimate_curvature(quadric, *cloud, neighbours, sample, radius, settings.curvature_points);
    clock.lap(seconds.curvature);
    out.affordance.curvature = curvature.median / radius;
    out.outcome = Outcome::kCurvatureLow;
    if (out.affordance.curvature < 1 / reach) continue;

    const Circle circle = fit_circle(*cloud, neighbours, sample, curvature.axis);
    clock.lap(seconds.circle);
    out.affordance.axis = array(canonical(curvature.axis));
    out.affordance.center = array(circle.center);
    out.affordance.radius = circle.radius;
    out.outcome = Outcome::kCircleWide;
    if (2 * circle.radius > options.hand_aperture) continue;
    out.outcome = Outcome::kCircleNarrow;
    if (2 * circle.radius < options.hand_minimum) continue;

    ShellLimits limits = shell_limits(view, options, sample, count, circle.radius);
    limits.step = settings.shell_step;
    const Shell shell = find_shell(*cloud, search, circle.center, curvature.axis, limits, rho2);
    clock.lap(seconds.shell);
    out.outcome = shell.outcome;
    if (shell.outcome != Outcome::kAffordance) continue;
    out.affordance.normal = array(outward_normal(view, sample, circle.center, curvature.normal));
    out.affordance.shell_radius = shell.radius;
    out.affordance.gap = limits.gap;
  }

  result.handles = find_handles(result.samples, options);
  clock.lap(seconds.handles);
  seconds.total = clock.since_start();
  return result;
}

}  // namespace handhold::baseline
