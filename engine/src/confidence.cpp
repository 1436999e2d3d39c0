#include "confidence.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

constexpr double kWeights[kFeatures] = {-0.1141, -1.0318, 0.0186,  -2.3409, 0.7453,  0.1903,  0.7583,  -0.7864,
                                        -0.2629, 1.6323,  -1.7967, 0.2037,  0.4703,  0.5519,  0.1758,  -1.0703,
                                        -0.0678, 0.4068,  -0.2820, -0.2628, -0.0842, -0.3215, -0.0571, 0.6525,
                                        -1.3544, -0.2092, 2.8553,  -0.3118, 1.3932,  -1.0395, -0.5888, -1.5918,
                                        -4.1320, 0.7497,  1.1160,  -1.1817, -0.6997, 0.4640,  -0.0773};

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
