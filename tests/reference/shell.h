// Cylindrical shell (paper, section 3.2): the smallest inner radius with a gap for the fingers outside it and enough
// points within it. Found by jumps, and once more by trying every radius that could be an answer.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "reference/neighbours.h"

namespace handhold::reference {

struct ShellQuery {
  double start_radius = 0;   ///< m; no smaller inner radius
  double max_radius = 0;     ///< m; no larger inner radius
  double gap = 0;            ///< m
  int max_gap_points = 0;    ///< at most so many points in the open interval (r, r + gap)
  int min_inner_points = 1;  ///< at least so many points with rho <= r
};

enum class ShellStatus {
  kFound,
  kNoGap,  ///< no radius has a gap
  kEmpty,  ///< some radius has a gap, none of them has enough points within
};

struct Shell {
  ShellStatus status = ShellStatus::kNoGap;
  double radius = 0;  ///< m; smallest inner radius that satisfies the conditions
  double free_to =
      0;  ///< m; supremum of radii up to which at most max_gap_points lie beyond `radius`; <= max_radius + gap
  int inner_points = 0;  ///< points with rho <= radius
  int gap_points = 0;    ///< points in (radius, radius + gap)
};

/// Distances to the axis, ascending, of the measured points whose offset along it is at most half_width; all in m.
/// `axis` is unit, `centre` a point of it.
inline std::vector<double> distances_to_axis(const Points& points, const Vector3d& centre, const Vector3d& axis,
                                             double half_width) {
  std::vector<double> rho;
  for (const Vector3d& p : points) {
    if (!is_measured(p)) continue;
    const double along = axis.dot(p - centre);
    if (std::abs(along) <= half_width) rho.push_back((p - centre - along * axis).norm());
  }
  std::sort(rho.begin(), rho.end());
  return rho;
}

/// Points with rho <= r. rho ascending.
inline int count_inner(const std::vector<double>& rho, double r) {
  return static_cast<int>(std::upper_bound(rho.begin(), rho.end(), r) - rho.begin());
}

/// Points in the open interval (low, high). rho ascending.
inline int count_between(const std::vector<double>& rho, double low, double high) {
  const auto first = std::upper_bound(rho.begin(), rho.end(), low);
  const auto last = std::lower_bound(rho.begin(), rho.end(), high);
  return first < last ? static_cast<int>(last - first) : 0;
}

/// The shell of inner radius r, described. rho ascending.
inline Shell describe_shell(const std::vector<double>& rho, const ShellQuery& query, double r) {
  Shell shell;
  shell.status = ShellStatus::kFound;
  shell.radius = r;
  shell.inner_points = count_inner(rho, r);
  shell.gap_points = count_between(rho, r, r + query.gap);
  shell.free_to = query.max_radius + query.gap;
  const std::size_t blocking = static_cast<std::size_t>(shell.inner_points) + query.max_gap_points;
  if (blocking < rho.size()) shell.free_to = std::min(shell.free_to, rho[blocking]);
  return shell;
}

/// Smallest r in [from, max_radius] with at most k points in its gap, or -1. Jumps: with more than k points in
/// (r, r + gap), every radius below the (k+1)-th largest of them still has those k+1 in its gap, so none is skipped
/// that could be an answer.
inline double first_gap_by_jumps(const std::vector<double>& rho, const ShellQuery& query, double from) {
  const std::size_t k = query.max_gap_points;
  double r = from;
  while (r <= query.max_radius) {
    if (count_between(rho, r, r + query.gap) <= query.max_gap_points) return r;
    const std::size_t end = std::lower_bound(rho.begin(), rho.end(), r + query.gap) - rho.begin();
    r = rho[end - 1 - k];
  }
  return -1;
}

/// rho ascending.
inline Shell find_shell_by_jumps(const std::vector<double>& rho, const ShellQuery& query) {
  const std::size_t m = std::max(query.min_inner_points, 0);
  if (m <= rho.size()) {
    const double from = std::max(query.start_radius, m > 0 ? rho[m - 1] : 0.0);
    const double r = first_gap_by_jumps(rho, query, from);
    if (r >= 0) return describe_shell(rho, query, r);
  }
  Shell none;
  none.status = first_gap_by_jumps(rho, query, query.start_radius) >= 0 ? ShellStatus::kEmpty : ShellStatus::kNoGap;
  return none;
}

/// The same by trying every candidate. A gap can only get emptier, and the inside only fuller, where r passes a point,
/// so the smallest answer is the start radius or the radius of a point. Counts by looking at every point. rho in any
/// order.
inline Shell find_shell_exhaustively(std::vector<double> rho, const ShellQuery& query) {
  std::vector<double> candidates = rho;
  candidates.push_back(query.start_radius);
  std::sort(candidates.begin(), candidates.end());
  Shell shell;
  for (double r : candidates) {
    if (r < query.start_radius || r > query.max_radius) continue;
    int inner = 0, between = 0;
    for (double d : rho) {
      inner += d <= r;
      between += d > r && d < r + query.gap;
    }
    if (between > query.max_gap_points) continue;
    shell.status = ShellStatus::kEmpty;
    if (inner < query.min_inner_points) continue;
    std::sort(rho.begin(), rho.end());
    return describe_shell(rho, query, r);
  }
  return shell;
}

}  // namespace handhold::reference
