// What the tests of the simulated camera share.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstddef>

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

inline std::size_t measured_points(const Cloud& cloud) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) n += measured(cloud, i);
  return n;
}

}  // namespace handhold::sensor
