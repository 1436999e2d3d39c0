#include "confidence.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

constexpr double kWeights[kFeatures] = {
    0.1818, -1.0433, 0.1313,  -2.2967, 0.7143,  0.1285,  0.8670,  -0.7151, -0.3873, 1.7537,  -1.6102, 0.2265,  0.4621,
    0.5505, 0.4797,  -0.9113, -0.1287, 0.2955,  -0.2547, -0.3046, -0.1517, -0.3504, -0.0634, 0.5868,  -1.3252, -0.3101,
    2.8443, -0.5055, 1.3220,  -1.0916, -0.6364, -1.3841, -4.2722, 0.5941,  1.2615,  -1.1148, -0.8439, 0.5501,  -0.0493};

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
