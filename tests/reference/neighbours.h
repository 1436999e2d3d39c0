// Neighbours by brute force.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

namespace handhold::reference {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;  ///< m

/// A coordinate beyond this is no measurement of a depth sensor (m); its square must also stay finite in float.
inline constexpr double kLargestCoordinate = 1e6;

/// Whether the sensor measured something here. NaN fails every comparison.
inline bool is_measured(const Vector3d& p) {
  return std::abs(p.x()) <= kLargestCoordinate && std::abs(p.y()) <= kLargestCoordinate &&
         std::abs(p.z()) <= kLargestCoordinate;
}

/// Indices, ascending, of the measured points of the closed ball |p - centre| <= radius.
inline std::vector<std::size_t> neighbours(const Points& points, const Vector3d& centre, double radius) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (is_measured(points[i]) && (points[i] - centre).squaredNorm() <= radius * radius) found.push_back(i);
  return found;
}

/// The neighbours of `centre`, relative to it and in units of the radius: the frame in which surfaces are fitted.
inline Points scaled_neighbourhood(const Points& points, const Vector3d& centre, double radius) {
  Points scaled;
  for (std::size_t i : neighbours(points, centre, radius)) scaled.push_back((points[i] - centre) / radius);
  return scaled;
}

}  // namespace handhold::reference
