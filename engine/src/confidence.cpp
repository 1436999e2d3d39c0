#include "confidence.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

constexpr double kWeights[kFeatures] = {3.7835, 1.2395, -0.0517, -1.7140, -0.1045, -0.1937, -0.8196, -0.2008, -0.7596, 0.3983, -3.8146, 0.0754, 1.1512, 0.6262, 0.4436, -0.4902, -0.4767, -0.1104, -0.0563, -0.4084};

}  // namespace

std::array<double, kFeatures> features(const Evidence& e) {
  const double r = std::max(e.radius, 1e-3), sigma = std::max(e.sigma, 1e-4);
  const double noise = 1e3 * sigma - 1.5, thin = std::max(0.0, std::log(0.014 / r));
  return {1.0,
          std::log(std::max(e.length, 1e-3) / 0.04),
          e.arc - 2.2,
          e.residual / sigma - 1,
          10 * e.residual / r,
          10 * (1 - e.free),
          10 * e.normal_error,
          noise,
          std::log(r / 0.02),
          std::log(1 + e.members) - 2.5,
          thin,
          10 * e.normal_error * noise,
          10 * e.normal_error * thin,
          10 * std::clamp(e.corner_gain, -0.5, 0.5),
          std::sqrt(std::min(e.inner, 1.0)),
          std::sqrt(std::min(e.outer, 1.0)),
          std::min(2.0, e.bend / (sigma + 0.05 * r)),
          std::min(3.0, e.waviness / sigma),
          10 * std::min(e.radius_spread, 0.4),
          10 * std::min(e.axis_spread, 0.4)};
}

double confidence(const Evidence& evidence) {
  const std::array<double, kFeatures> x = features(evidence);
  double sum = 0;
  for (std::size_t i = 0; i < kFeatures; ++i) sum += kWeights[i] * x[i];
  return 1 / (1 + std::exp(-sum));
}

}  // namespace handhold
