// Straight ways in joint space, and their times.
#include "path.h"

#include <algorithm>
#include <cmath>

namespace handhold::plan {

void extend_straight(std::vector<JointVector>& path, const JointVector& to, double step) {
  const JointVector from = path.back();
  double farthest = 0;
  for (std::size_t j = 0; j < from.size(); ++j) farthest = std::max(farthest, std::fabs(to[j] - from[j]));
  // A hair less, so that rounding adds no sample.
  const auto pieces = static_cast<std::size_t>(std::ceil(farthest / step - 1e-9));
  for (std::size_t i = 1; i <= pieces; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(pieces);
    JointVector q = to;
    for (std::size_t j = 0; i < pieces && j < q.size(); ++j) q[j] = from[j] + share * (to[j] - from[j]);
    path.push_back(std::move(q));
  }
}

std::vector<JointVector> straight_path(const JointVector& from, const JointVector& to, double step) {
  std::vector<JointVector> path = {from};
  extend_straight(path, to, step);
  if (path.size() == 1) path.push_back(to);
  return path;
}

std::vector<double> path_times(const std::vector<JointVector>& path, const std::vector<Joint>& joints, double speed,
                               double acceleration_time) {
  std::vector<double> at_full_speed(path.size(), 0);  // s, so far
  for (std::size_t i = 1; i < path.size(); ++i) {
    double longest = 0;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      longest = std::max(longest, std::fabs(path[i][j] - path[i - 1][j]) / (speed * joints[j].velocity));
    }
    at_full_speed[i] = at_full_speed[i - 1] + longest;
  }
  if (path.empty()) return at_full_speed;
  const double length = at_full_speed.back(), ramp = acceleration_time;
  // Each half from its end at rest: a short one is over before the full speed is reached.
  const auto from_rest = [ramp](double s) { return s < ramp / 2 ? std::sqrt(2 * ramp * s) : s + ramp / 2; };
  const double total = 2 * from_rest(length / 2);
  std::vector<double> times;
  times.reserve(path.size());
  for (const double s : at_full_speed) {
    times.push_back(s <= length / 2 ? from_rest(s) : total - from_rest(length - s));
  }
  return times;
}

}  // namespace handhold::plan
