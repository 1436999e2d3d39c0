#include "confidence.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

// Written by handhold_confidence (bench/).
#include "confidence_model.inc"

double log_of(double metres, double least = 0.003) {
  return std::log(std::clamp(metres, least, 0.3));
}

}  // namespace

std::array<double, kFeatures> features(const Evidence& e) {
  const double r = std::max(e.radius, 1e-3), sigma = std::max(e.sigma, 1e-4), log_r = std::log(r);
  const auto end = [](double share) { return std::clamp(share, 0.3, 3.0); };
  std::array<double, kLooksBeyond> less, more;
  std::transform(e.fall_less.begin(), e.fall_less.end(), less.begin(), [](double x) { return log_of(x); });
  std::transform(e.fall_more.begin(), e.fall_more.end(), more.begin(), [](double x) { return log_of(x); });
  return {log_of(e.length, 1e-3), e.arc, e.residual / sigma, e.residual / r, 1 - e.free, e.normal_error, sigma, log_r,
          std::log(1 + e.members), e.corner_gain, std::min(e.inner, 1.0), std::min(e.outer, 1.0),
          e.bend / (sigma + 0.05 * r), e.waviness / sigma, e.radius_spread, e.axis_spread,
          // Rims and edges go on beside.
          e.steps_less, e.steps_more, end(e.nearer_end), end(e.farther_end), e.strap, less[0], less[1], less[2],
          more[0], more[1], more[2],
          // A wall that is seen at a grazing angle falls away by and by; what lies on something by its own thickness.
          less[0] - less[2], more[0] - more[2], less[2] - more[2], less[2] - log_r, more[2] - log_r,
          log_of(e.length, 1e-3) - log_r, e.followed, e.turn, e.off_middle, e.off_direction};
}

double confidence(const Evidence& evidence) {
  const std::array<double, kFeatures> x = features(evidence);
  double sum = kStart;
  for (const ConfidenceTree& tree : kTrees) sum += tree(x);
  return 1 / (1 + std::exp(-sum));
}

}  // namespace handhold
