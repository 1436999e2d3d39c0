#include "confidence.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

constexpr double kWeights[kFeatures] = {
    1.7917, -0.6512, -0.0085, -0.4580, 0.1918,  0.0650,  -0.0856, 0.5408,  -0.2401, 1.6294,  -2.1238, 0.0462,  1.0818,
    0.6075, -0.7966, -1.4087, -0.3042, 1.2897,  -0.1715, -0.4891, -0.2295, -0.1699, -0.0828, -0.1875, -0.8534, -0.6128,
    2.9346, 0.1460,  1.0828,  -1.2654, -0.6498, -1.3967, -1.9919, 0.1557,  -0.2398, -0.8075, -0.9004, 0.7518,  -0.3233};

}  // namespace

std::array<double, kFeatures> features(const Evidence& e) {
  const double r = std::max(e.radius, 1e-3), sigma = std::max(e.sigma, 1e-4);
  const double noise = 1e3 * sigma - 1.5, thin = std::max(0.0, std::log(0.014 / r));
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
