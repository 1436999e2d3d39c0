// Cylindrical shells by a loop over radii.
#include <algorithm>
#include <cmath>

#include "baseline/stages.h"

namespace handhold::baseline {

namespace {

// Steps from `start` (m) to the first radius with at most `max_gap_points` in its gap; negative: there is none.
double first_gap(const std::vector<float>& rho2, const ShellLimits& limits, double start) {
  for (int step = 0; start + step * limits.step <= limits.max_radius; ++step) {
    const double r = start + step * limits.step;
    const float low2 = static_cast<float>(r * r);
    const float high2 = static_cast<float>((r + limits.gap) * (r + limits.gap));
    int in_gap = 0;
    for (const float value : rho2) in_gap += static_cast<int>(value > low2) & static_cast<int>(value < high2);
    if (in_gap <= limits.max_gap_points) return r;
  }
  return -1;
}

}  // namespace

Shell find_shell(const PclCloud& cloud, RadiusSearch& search, const Eigen::Vector3d& center,
                 const Eigen::Vector3d& axis, const ShellLimits& limits, std::vector<float>& rho2) {
  const double outer = limits.max_radius + limits.gap;
  const Eigen::Vector3f c = center.cast<float>();
  const Eigen::Vector3f a = axis.cast<float>();
  const std::vector<int>& slab = search.find(c, std::hypot(outer, limits.half_width));
  const float half_width = static_cast<float>(limits.half_width);
  rho2.clear();
  for (const int i : slab) {
    const Eigen::Vector3f offset = cloud[i].getVector3fMap() - c;
    const float along = a.dot(offset);
    // Squared distance to the axis from its vector: |offset|^2 - along^2 would cancel.
    if (std::abs(along) <= half_width) rho2.push_back((offset - along * a).squaredNorm());
  }

  Shell shell;
  const std::size_t m = static_cast<std::size_t>(limits.min_inner_points);
  if (m <= rho2.size()) {
    std::nth_element(rho2.begin(), rho2.begin() + (m - 1), rho2.end());
    const double start = std::max(limits.start_radius, std::sqrt(static_cast<double>(rho2[m - 1])));
    shell.radius = first_gap(rho2, limits, start);
    if (shell.radius >= 0) {
      shell.outcome = Outcome::kAffordance;
      return shell;
    }
  }
  shell.outcome = first_gap(rho2, limits, limits.start_radius) >= 0 ? Outcome::kShellEmpty : Outcome::kNoGap;
  return shell;
}

}  // namespace handhold::baseline
