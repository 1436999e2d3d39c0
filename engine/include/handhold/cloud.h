// A point cloud as the caller holds it, seen without a copy.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace handhold {

/// x, y, z in metres, in the frame of the cloud.
using Vector3 = std::array<double, 3>;

/// A cloud in the caller's memory. Nothing is copied; the memory must live as long as the call that takes the view.
///
/// Points are three consecutive floats (x, y, z; metres; any frame), `point_step` bytes apart. A point with a
/// coordinate that is not finite counts as missing. `height` > 1 means organized: row-major, `width` points a row, as a
/// depth camera delivers them; `height` == 1 means unorganized.
struct CloudView {
  const float* data = nullptr;  ///< x of the first point; null only for an empty cloud
  std::size_t point_step = 12;  ///< bytes from one point to the next: a multiple of 4, at least 12 (pcl::PointXYZ: 16)
  std::uint32_t width = 0;      ///< points in a row
  std::uint32_t height = 1;     ///< rows; 1: unorganized
  std::optional<Vector3> viewpoint =
      Vector3{0, 0, 0};  ///< where the sensor stood (m, cloud frame); none: no single viewpoint

  std::size_t size() const { return static_cast<std::size_t>(width) * height; }
  bool organized() const { return height > 1; }
  /// The i-th point's x, y, z (three floats), i < size().
  const float* point(std::size_t i) const {
    return reinterpret_cast<const float*>(reinterpret_cast<const std::byte*>(data) + i * point_step);
  }
};

/// A cloud that owns its points: tightly packed x, y, z (metres), row-major.
struct Cloud {
  std::vector<float> xyz;          ///< 3 * width * height values; NaN where the sensor measured nothing
  std::vector<std::uint32_t> rgb;  ///< 0x00RRGGBB for each point, or empty; only pictures use it
  std::uint32_t width = 0;
  std::uint32_t height = 1;
  std::optional<Vector3> viewpoint = Vector3{0, 0, 0};

  std::size_t size() const { return static_cast<std::size_t>(width) * height; }
  CloudView view() const { return {xyz.data(), 12, width, height, viewpoint}; }
};

}  // namespace handhold
