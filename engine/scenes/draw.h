// Random numbers of scenes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "handhold/sensor.h"
#include "random.h"

namespace handhold::sensor {

/// Numbers drawn one after the other from a seed.
class Draw {
 public:
  /// @param series  of numbers that have nothing to do with those of the seed's other series
  explicit Draw(std::uint64_t seed, std::uint32_t series = 0) : seed_(seed), series_(series) {}
  std::uint32_t bits() { return philox({count_++, series_, 0, 0x7363656E}, seed_)[0]; }
  double uniform(double low, double high) { return low + (high - low) * to_uniform(bits()); }
  bool chance(double probability) { return to_uniform(bits()) < probability; }
  std::size_t index(std::size_t n) { return std::min(n - 1, static_cast<std::size_t>(to_uniform(bits()) * n)); }
  double normal() {
    const std::uint32_t a = bits(), b = bits();
    return to_normal(a, b);
  }
  /// Uniform over all orientations: a unit quaternion from four normal numbers.
  Pose orientation() {
    const double w = normal(), x = normal(), y = normal(), z = normal();
    return rotation({x, y, z}, 2 * std::atan2(std::sqrt(x * x + y * y + z * z), w));
  }

 private:
  std::uint64_t seed_;
  std::uint32_t series_;
  std::uint32_t count_ = 0;
};

}  // namespace handhold::sensor
