// Small clouds as file contents.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace handhold::test {

using Points = std::vector<std::array<float, 3>>;

/// A cylinder of 20 mm radius and 150 mm length along y, 0.7 m before the sensor: the half that a camera at the origin
/// sees, every millimetre.
inline constexpr double kCylinderRadius = 0.02;
inline constexpr std::array<double, 3> kCylinderCenter = {0.05, 0.0, 0.7};
Points cylinder();

std::string binary_pcd(const Points& points);
std::string ascii_pcd(const Points& points);
std::string ascii_ply(const Points& points);

struct DepthImage {
  int width = 160, height = 120;
  std::vector<std::uint16_t> values;  ///< row after row; mm
};

/// Of the same kind of cylinder, 0.7 m before the camera and `x` m beside its axis: fx = fy = 300, cx = 79.5, cy = 59.5
/// px.
DepthImage depth_image(double x = 0);

/// 16-bit gray PNG.
std::string png(const DepthImage& image);
std::string depth_png();  ///< of depth_image()

}  // namespace handhold::test
