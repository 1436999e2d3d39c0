#include "profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace handhold {
namespace {

/// Radius over length: up to here a piece is a cone, beyond it the shoulder between two; a short piece sooner, as the
/// slices at its ends hold points of its neighbours.
constexpr double kSteep = 0.18, kSteepShort = 0.15;
constexpr std::size_t kShort = 3;  ///< slices

struct Line {
  double middle = 0, slope = 0, cost = 0;  ///< radius at `at`, its change per slice
  double at = 0;
  double operator()(double i) const { return middle + slope * (i - at); }
};

/// Weighted line of least squares through slices [a, b) from prefix sums of (w, wi, wii, wr, wri, wrr).
Line fit(const std::vector<double>& sums, std::size_t a, std::size_t b) {
  double s[6];
  for (std::size_t k = 0; k < 6; ++k) s[k] = sums[6 * b + k] - sums[6 * a + k];
  Line line;
  if (!(s[0] > 0)) {
    line.at = 0.5 * static_cast<double>(a + b);
    return line;
  }
  line.at = s[1] / s[0], line.middle = s[3] / s[0];
  const double ii = s[2] - s[1] * line.at, ri = s[4] - s[3] * line.at, rr = s[5] - s[3] * line.middle;
  line.slope = ii > 1e-9 * s[2] ? ri / ii : 0;
  line.cost = std::max(0.0, rr - line.slope * ri);
  return line;
}

}  // namespace

void cut_profile(const std::vector<ProfileSlice>& slices, double width, double least_jump, double penalty,
                 ProfileScratch& scratch, std::vector<ProfilePiece>& pieces) {
  const std::size_t n = slices.size();
  std::vector<double>& sums = scratch.sums;
  sums.assign(6 * (n + 1), 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const double w = slices[i].weight, r = slices[i].radius, x = static_cast<double>(i);
    const double terms[6] = {w, w * x, w * x * x, w * r, w * r * x, w * r * r};
    for (std::size_t k = 0; k < 6; ++k) sums[6 * (i + 1) + k] = sums[6 * i + k] + terms[k];
  }
  scratch.cost.assign(n + 1, std::numeric_limits<double>::infinity());
  scratch.from.assign(n + 1, 0);
  scratch.cost[0] = 0;
  for (std::size_t b = 1; b <= n; ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const double cost = scratch.cost[a] + fit(sums, a, b).cost + penalty;
      if (cost < scratch.cost[b]) scratch.cost[b] = cost, scratch.from[b] = a;
    }
  }
  std::vector<ProfilePiece>& found = scratch.pieces;
  found.clear();
  for (std::size_t b = n; b > 0; b = scratch.from[b]) found.push_back({scratch.from[b], b});
  std::reverse(found.begin(), found.end());
  const std::size_t before = pieces.size();
  bool joins = false;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Line line = fit(sums, found[i].first, found[i].last);
    const bool is_short = found[i].last - found[i].first <= kShort;
    if (std::fabs(line.slope) > (is_short ? kSteepShort : kSteep) * width) {
      joins = false;
      continue;
    }
    if (joins) {
      const Line left = fit(sums, found[i - 1].first, found[i - 1].last);
      const double edge = static_cast<double>(found[i].first) - 0.5;
      joins = std::fabs(left(edge) - line(edge)) < least_jump;
    }
    if (joins && pieces.size() > before) {
      pieces.back().last = found[i].last;
    } else {
      pieces.push_back(found[i]);
    }
    joins = true;
  }
}

}  // namespace handhold
