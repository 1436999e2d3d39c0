// The random numbers of a frame, pixel by pixel; neighbouring pixels may draw alike.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "handhold/sensor.h"

namespace handhold::sensor {

/// What one pixel draws. The first three correlate between neighbouring pixels where the options say so.
struct Draw {
  double axial;                   ///< standard normal
  std::array<double, 2> lateral;  ///< standard normal, along rows and columns
  double dropout;                 ///< uniform in (0, 1)
  double edge;                    ///< uniform in (0, 1): what becomes of a pixel beside a depth edge
  double mixture;                 ///< uniform in (0, 1): where between two surfaces
};

/// A function of the options (size, correlation, seed) alone.
class NoiseField {
 public:
  explicit NoiseField(const CameraOptions& options);
  Draw at(std::uint32_t u, std::uint32_t v) const;

 private:
  using Normals = std::array<float, 4>;
  std::uint32_t width_;
  std::uint64_t seed_;
  std::vector<Normals> smooth_;  ///< width * height; empty when every pixel draws for itself
};

}  // namespace handhold::sensor
