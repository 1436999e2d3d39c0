#include "confidence.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

constexpr double kWeights[kFeatures] = {4.3087,  -0.2550, 0.8847,  0.4678,  -0.4730, -0.2765, 0.5877,  0.7266,  -1.1710,
                                        1.8640,  -3.7305, 0.3092,  0.4797,  0.6852,  1.6675,  -0.8067, -0.4573, 1.6981,
                                        -0.2010, -0.5466, -0.4729, -0.4148, -0.1016, -0.3566, -1.0219, -0.5988};

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
