#include "confidence.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

constexpr double kWeights[kFeatures] = {4.0791,  -0.4975, 0.9363,  0.6241,  -0.5918, -0.2895, 0.7799,  0.8285,  -1.2487,
                                        1.9570,  -3.1985, 0.3791,  0.6661,  0.7109,  0.9509,  -0.5172, -0.2715, 2.0503,
                                        -0.2819, -0.7360, -0.4366, -0.4505, -0.0764, -0.3432, -1.0299, -0.6553};

}  // namespace

std::array<double, kFeatures> features(const Evidence& e) {
  const double r = std::max(e.radius, 1e-3), sigma = std::max(e.sigma, 1e-4);
  const double noise = 1e3 * sigma - 1.5, thin = std::max(0.0, std::log(0.014 / r));
  const double arc = e.arc - 2.2, normals = 10 * e.normal_error, members = std::log(1 + e.members) - 2.5;
  const double corner = 10 * std::clamp(e.corner_gain, -0.5, 0.5), axes = 10 * std::min(e.axis_spread, 0.4);
  return {1.0, std::log(std::max(e.length, 1e-3) / 0.04), arc, e.residual / sigma - 1, 10 * e.residual / r,
          10 * (1 - e.free), normals, noise, std::log(r / 0.02), members, thin, normals * noise, normals * thin, corner,
          std::sqrt(std::min(e.inner, 1.0)), std::sqrt(std::min(e.outer, 1.0)),
          std::min(2.0, e.bend / (sigma + 0.05 * r)), std::min(3.0, e.waviness / sigma),
          10 * std::min(e.radius_spread, 0.4), axes,
          // What is right has a middle: an arc can be too wide, normals are never perfect.
          arc * arc, normals * normals, corner * corner, noise * noise,
          // Few samples fall on what is thin; many that disagree are no evidence.
          members * thin, members * axes};
}

double confidence(const Evidence& evidence) {
  const std::array<double, kFeatures> x = features(evidence);
  double sum = 0;
  for (std::size_t i = 0; i < kFeatures; ++i) sum += kWeights[i] * x[i];
  return 1 / (1 + std::exp(-sum));
}

}  // namespace handhold
