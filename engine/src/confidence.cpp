#include "confidence.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

constexpr double kWeights[kFeatures] = {
    -0.7282, -0.8667, -0.0819, -1.8415, 0.7121,  0.1807,  1.2973,  -0.3948, -0.4950, 1.5755,  -1.0860, 0.1955,  0.1874,
    0.5816,  0.9222,  -1.7078, -0.3042, 0.8591,  -0.3572, -0.2683, -0.0815, -0.4319, -0.0606, 0.5662,  -1.1983, -0.2627,
    2.8457,  -0.3352, 1.1103,  -1.1370, -0.9268, -1.1637, -4.1048, 0.2372,  1.3323,  -1.0386, -1.3440, 0.3644,  0.1228};

}  // namespace

std::array<double, kFeatures> features(const Evidence& e) {
  const double r = std::max(e.radius, 1e-3), sigma = std::max(e.sigma, 1e-4);
  const double noise = std::min(1e3 * sigma, 3.0) - 1.5, thin = std::max(0.0, std::log(0.014 / r));
  const double arc = e.arc - 2.2, normals = 10 * e.normal_error, members = std::log(1 + e.members) - 2.5;
  const double corner = 10 * std::clamp(e.corner_gain, -0.5, 0.5), axes = 10 * std::min(e.axis_spread, 0.4);
  const double near = std::log(std::clamp(e.nearer_end, 0.3, 3.0)), far = std::log(std::clamp(e.farther_end, 0.3, 3.0));
  return {1.0, std::log(std::max(e.length, 1e-3) / 0.04), arc, e.residual / sigma - 1, 10 * e.residual / r,
          10 * (1 - e.free), normals, noise, std::log(r / 0.02), members, thin, normals * noise, normals * thin, corner,
          std::sqrt(std::min(e.inner, 1.0)), std::sqrt(std::min(e.outer, 1.0)),
          std::min(2.0, e.bend / (sigma + 0.05 * r)), std::min(3.0, e.waviness / sigma),
          10 * std::min(e.radius_spread, 0.4), axes,
          // What is right has a middle: an arc can be too wide, normals are never perfect.
          arc * arc, normals * normals, corner * corner, noise * noise,
          // Few samples fall on what is thin; many that disagree are no evidence.
          members * thin, members * axes,
          // Rims and edges go on beside.
          e.steps_less, e.steps_more, near, far, near * near, far * far, e.steps_less * thin, far * thin, e.strap,
          e.strap * noise, e.strap * std::log(std::max(e.length, 1e-3) / 0.04), e.strap * arc, e.strap * members};
}

double confidence(const Evidence& evidence) {
  const std::array<double, kFeatures> x = features(evidence);
  double sum = 0;
  for (std::size_t i = 0; i < kFeatures; ++i) sum += kWeights[i] * x[i];
  return 1 / (1 + std::exp(-sum));
}

}  // namespace handhold
