// The pinhole camera and what the sensor does to depth.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "handhold/sensor.h"
#include "random.h"
#include "ray_caster.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr double kRightAngle = 1.5707963267948966;

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

/// Depth as measured, or NaN when nothing comes back. `pixel` counts row by row.
double measure(const CameraOptions& options, double z, double cos_incidence, std::uint32_t pixel) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  // Seen from behind: the camera is inside a solid.
  if (!(cos_incidence > 0)) return kNothing;
  const NoiseOptions& noise = options.noise;
  const std::array<std::uint32_t, 4> bits = philox({pixel, 0, 0, 0}, options.seed);
  if (to_uniform(bits[0]) < noise.dropout(std::acos(std::min(1.0, cos_incidence)))) return kNothing;
  z += noise.sigma(z) * to_normal(bits[1], bits[2]);
  z = noise.quantized(z);
  return z >= options.min_range && z <= options.max_range ? z : kNothing;
}

}  // namespace

double NoiseOptions::sigma(double z) const {
  const double beyond = std::max(0.0, z - axial_from);
  return axial_sigma + axial_growth * beyond * beyond;
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

void CameraOptions::validate() const {
  require(width >= 1 && width <= 16384, "width", width, "1 to 16384 px");
  require(height >= 1 && height <= 16384, "height", height, "1 to 16384 px");
  require(finite_positive(fx), "fx", fx, "above 0 px");
  require(finite_positive(fy), "fy", fy, "above 0 px");
  require(std::isfinite(cx), "cx", cx, "finite (px)");
  require(std::isfinite(cy), "cy", cy, "finite (px)");
  require(finite_positive(min_range), "min_range", min_range, "above 0 m");
  require(max_range > min_range && finite_positive(max_range), "max_range", max_range, "above min_range (m)");
  require(finite_not_negative(noise.axial_sigma), "noise.axial_sigma", noise.axial_sigma, "0 m or more");
  require(finite_not_negative(noise.axial_growth), "noise.axial_growth", noise.axial_growth, "0 1/m or more");
  require(finite_not_negative(noise.axial_from), "noise.axial_from", noise.axial_from, "0 m or more");
  require(finite_not_negative(noise.disparity_step), "noise.disparity_step", noise.disparity_step, "0 px or more");
  require(finite_positive(noise.disparity_focal), "noise.disparity_focal", noise.disparity_focal, "above 0 px");
  require(finite_positive(noise.baseline), "noise.baseline", noise.baseline, "above 0 m");
  require(noise.dropout_from >= 0 && noise.dropout_from <= kRightAngle, "noise.dropout_from", noise.dropout_from,
          "0 to pi/2 rad");
  require(noise.dropout_to >= noise.dropout_from && noise.dropout_to <= kRightAngle, "noise.dropout_to",
          noise.dropout_to, "dropout_from to pi/2 rad");
}

CameraOptions CameraOptions::kinect() {
  CameraOptions options;
  options.max_range = 4.0;
  options.noise.axial_sigma = 0.0008;
  options.noise.axial_growth = 0.0019;
  options.noise.axial_from = 0.4;
  options.noise.disparity_step = 0.125;
  // Between 70 and 85 degrees the pattern thins out until no match is left.
  options.noise.dropout_from = 1.22;
  options.noise.dropout_to = 1.48;
  return options;
}

DepthCamera::DepthCamera(const CameraOptions& options) : options_(options) {
  options_.validate();
}

Vector3 DepthCamera::ray(double u, double v) const {
  return {(u - options_.cx) / options_.fx, (v - options_.cy) / options_.fy, 1};
}

std::optional<Point2> DepthCamera::project(const Vector3& p) const {
  if (!(p[2] > 0)) return std::nullopt;
  return Point2{options_.fx * p[0] / p[2] + options_.cx, options_.fy * p[1] / p[2] + options_.cy};
}

Frame DepthCamera::capture(const Scene& scene, const Pose& T_world_camera) const {
  const RayCaster caster(scene);
  Frame frame;
  frame.cloud.width = options_.width;
  frame.cloud.height = options_.height;
  frame.cloud.viewpoint = Vector3{0, 0, 0};
  const std::size_t pixels = frame.cloud.size();
  frame.cloud.xyz.assign(3 * pixels, std::numeric_limits<float>::quiet_NaN());
  frame.object.assign(pixels, -1);
  tbb::parallel_for(std::uint32_t{0}, options_.height, [&](std::uint32_t v) {
    for (std::uint32_t u = 0; u < options_.width; ++u) {
      const Vector3 direction = ray(u, v);
      // The direction has z = 1 in the camera, so the ray's parameter is the depth.
      const std::optional<RayHit> hit = caster.cast(T_world_camera.t, T_world_camera.direction(direction));
      if (!hit) continue;
      const std::uint32_t pixel = v * options_.width + u;
      const double z = measure(options_, hit->t, hit->cos_incidence, pixel);
      if (std::isnan(z)) continue;
      for (int k = 0; k < 3; ++k)
        frame.cloud.xyz[3 * static_cast<std::size_t>(pixel) + k] = static_cast<float>(z * direction[k]);
      frame.object[pixel] = hit->object;
    }
  });
  return frame;
}

}  // namespace handhold::sensor
