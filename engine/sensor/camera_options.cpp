// The options of the camera: what may be, the presets, and the formulas of the noise.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "handhold/sensor.h"

namespace handhold::sensor {
namespace {

constexpr double kRightAngle = 1.5707963267948966;
/// The noise grows without bound towards grazing incidence; 85 degrees is beyond what was ever measured.
constexpr double kSteepest = 85 * kRightAngle / 90;

/// Phrased so that NaN fails.
void require(bool valid, const char* name, double value, const char* range) {
  if (valid) return;
  throw std::invalid_argument(std::string("camera option ") + name + " = " + std::to_string(value) + ": must be " +
                              range);
}

bool finite_positive(double x) {
  return x > 0 && x <= std::numeric_limits<double>::max();
}
bool finite_not_negative(double x) {
  return x >= 0 && x <= std::numeric_limits<double>::max();
}

void validate(const NoiseOptions& noise) {
  require(finite_not_negative(noise.axial_sigma), "noise.axial_sigma", noise.axial_sigma, "0 m or more");
  require(finite_not_negative(noise.axial_growth), "noise.axial_growth", noise.axial_growth, "0 1/m or more");
  require(finite_not_negative(noise.axial_from), "noise.axial_from", noise.axial_from, "0 m or more");
  require(finite_not_negative(noise.axial_slant), "noise.axial_slant", noise.axial_slant, "0 m^(3/2) or more");
  require(finite_not_negative(noise.lateral_sigma), "noise.lateral_sigma", noise.lateral_sigma, "0 px or more");
  require(finite_not_negative(noise.lateral_slant), "noise.lateral_slant", noise.lateral_slant, "0 px or more");
  require(noise.correlation_u >= 0 && noise.correlation_u <= 16, "noise.correlation_u", noise.correlation_u,
          "0 to 16 px");
  require(noise.correlation_v >= 0 && noise.correlation_v <= 16, "noise.correlation_v", noise.correlation_v,
          "0 to 16 px");
  require(finite_not_negative(noise.disparity_step), "noise.disparity_step", noise.disparity_step, "0 px or more");
  require(finite_positive(noise.disparity_focal), "noise.disparity_focal", noise.disparity_focal, "above 0 px");
  require(finite_positive(noise.baseline), "noise.baseline", noise.baseline, "above 0 m");
  require(noise.dropout_from >= 0 && noise.dropout_from <= kRightAngle, "noise.dropout_from", noise.dropout_from,
          "0 to pi/2 rad");
  require(noise.dropout_to >= noise.dropout_from && noise.dropout_to <= kRightAngle, "noise.dropout_to",
          noise.dropout_to, "dropout_from to pi/2 rad");
  require(noise.glare_width >= 0 && noise.glare_width <= kRightAngle, "noise.glare_width", noise.glare_width,
          "0 to pi/2 rad");
  require(finite_not_negative(noise.signal_none), "noise.signal_none", noise.signal_none, "0 1/m^2 or more");
  require(noise.signal_full >= noise.signal_none && finite_not_negative(noise.signal_full), "noise.signal_full",
          noise.signal_full, "signal_none (1/m^2) or more");
  require(finite_positive(noise.edge_step), "noise.edge_step", noise.edge_step, "above 0 m");
  require(noise.edge_dropout >= 0 && noise.edge_dropout <= 1, "noise.edge_dropout", noise.edge_dropout, "0 to 1");
  require(noise.mixed >= 0 && noise.mixed <= 1 - noise.edge_dropout, "noise.mixed", noise.mixed,
          "0 to 1 - edge_dropout");
}

}  // namespace

double NoiseOptions::sigma(double z, double incidence) const {
  const double beyond = std::max(0.0, z - axial_from);
  const double theta = std::min(incidence, kSteepest), slant = theta / (kRightAngle - theta);
  return axial_sigma + axial_growth * beyond * beyond + axial_slant / std::sqrt(z) * slant * slant;
}

double NoiseOptions::lateral(double incidence) const {
  const double theta = std::min(incidence, kSteepest);
  return lateral_sigma + lateral_slant * theta / (kRightAngle - theta);
}

double NoiseOptions::quantized(double z) const {
  // Noise may have brought z to or behind the camera: that is no disparity.
  if (disparity_step == 0 || !(z > 0)) return z;
  const double steps = std::round(disparity_focal * baseline / (z * disparity_step));
  return disparity_focal * baseline / (std::max(1.0, steps) * disparity_step);
}

double NoiseOptions::dropout(double incidence) const {
  if (incidence < dropout_from) return 0;
  if (incidence >= dropout_to) return 1;
  return (incidence - dropout_from) / (dropout_to - dropout_from);
}

double NoiseOptions::glare(double specular, double angle) const {
  if (glare_width == 0) return 0;
  return specular * std::exp(-(angle / glare_width) * (angle / glare_width));
}

double NoiseOptions::darkness(double signal) const {
  if (signal >= signal_full) return 0;
  if (signal <= signal_none) return 1;
  return (signal_full - signal) / (signal_full - signal_none);
}

void CameraOptions::validate() const {
  require(width >= 1 && width <= 16384, "width", width, "1 to 16384 px");
  require(height >= 1 && height <= 16384, "height", height, "1 to 16384 px");
  require(finite_positive(fx), "fx", fx, "above 0 px");
  require(finite_positive(fy), "fy", fy, "above 0 px");
  require(std::isfinite(cx), "cx", cx, "finite (px)");
  require(std::isfinite(cy), "cy", cy, "finite (px)");
  require(finite_positive(min_range), "min_range", min_range, "above 0 m");
  require(max_range > min_range && finite_positive(max_range), "max_range", max_range, "above min_range (m)");
  sensor::validate(noise);
}

CameraOptions CameraOptions::kinect() {
  CameraOptions options;
  options.min_range = 0.4;
  options.max_range = 4.0;
  NoiseOptions& noise = options.noise;
  noise.axial_sigma = 0.0012;
  noise.axial_growth = 0.0019;
  noise.axial_from = 0.4;
  noise.axial_slant = 0.0001;
  noise.lateral_sigma = 0.8;
  noise.lateral_slant = 0.035;
  // On flat patches of real frames the error of one pixel reaches farther along the rows, in which the sensor searches.
  noise.correlation_u = 4;
  noise.correlation_v = 2;
  noise.disparity_step = 0.125;
  noise.disparity_focal = options.fx;
  noise.shadows = true;
  // Between 70 and 85 degrees the pattern thins out until no match is left.
  noise.dropout_from = 1.22;
  noise.dropout_to = 1.48;
  noise.glare_width = 0.1;
  // White paper (0.9) faced squarely is lost beyond 5 m, black plastic (0.04) beyond 1.1 m.
  noise.signal_full = 0.035;
  noise.signal_none = 0.015;
  // On real frames about a quarter of the outlines miss a pixel, most of it by shadow and grazing incidence, and one in
  // a hundred shows a depth in between.
  noise.edge_dropout = 0.05;
  noise.mixed = 0.005;
  return options;
}

CameraOptions CameraOptions::xtion() {
  CameraOptions options = kinect();
  options.fx = options.fy = options.noise.disparity_focal = 570;
  options.max_range = 3.5;
  return options;
}

}  // namespace handhold::sensor
