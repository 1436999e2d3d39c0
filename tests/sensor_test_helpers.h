// What the tests of the simulated camera share.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

#include "handhold/sensor.h"

namespace handhold::sensor {

inline Eigen::Vector3d eigen(const Vector3& v) {
  return {v[0], v[1], v[2]};
}

inline Eigen::Vector3d point(const Cloud& cloud, std::size_t i) {
  return {cloud.xyz[3 * i], cloud.xyz[3 * i + 1], cloud.xyz[3 * i + 2]};
}

inline bool measured(const Cloud& cloud, std::size_t i) {
  return std::isfinite(cloud.xyz[3 * i]);
}

/// Bit by bit, so that what was not measured equals itself.
inline bool same_bytes(const Cloud& a, const Cloud& b) {
  return a.xyz.size() == b.xyz.size() && std::memcmp(a.xyz.data(), b.xyz.data(), a.xyz.size() * sizeof(float)) == 0;
}
inline bool same_bytes(const Cloud& a, const Cloud& b, std::size_t pixel) {
  return std::memcmp(&a.xyz[3 * pixel], &b.xyz[3 * pixel], 3 * sizeof(float)) == 0;
}

inline std::size_t measured_points(const Cloud& cloud) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) n += measured(cloud, i);
  return n;
}

/// Small and quick: 160x120 pixels with the field of view of the full image.
inline CameraOptions small_camera() {
  CameraOptions options;
  options.width = 160;
  options.height = 120;
  options.fx = options.fy = 575.0 / 4;
  options.cx = 79.5;
  options.cy = 59.5;
  return options;
}

/// A board across the optical axis at depth z, in the camera's frame.
inline Scene wall(double z) {
  Scene scene;
  scene.add({"wall", box(4, 4, 0.1), {}}, translation(0, 0, z + 0.05));
  return scene;
}

}  // namespace handhold::sensor
