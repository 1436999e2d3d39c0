#include "confidence.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

constexpr double kWeights[kFeatures] = {1.5747,  -0.5530, 0.0117,  -0.3282, 0.0602,  0.1071,  0.0663,  0.5105,  -1.3726,
                                        1.7977,  -3.7641, 0.2657,  1.0657,  0.5342,  0.8904,  0.4600,  -0.0490, 1.1039,
                                        -0.2260, -0.5088, -0.0449, -0.2806, -0.0781, -0.2547, -0.8991, -0.6972, 3.5252,
                                        -0.2091, 0.7513,  -1.1755, -0.7567, -1.2609, -2.0582, 0.4285};

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
          e.steps_less, e.steps_more, near, far, near * near, far * far, e.steps_less * thin, far * thin};
}

double confidence(const Evidence& evidence) {
  const std::array<double, kFeatures> x = features(evidence);
  double sum = 0;
  for (std::size_t i = 0; i < kFeatures; ++i) sum += kWeights[i] * x[i];
  return 1 / (1 + std::exp(-sum));
}

}  // namespace handhold
