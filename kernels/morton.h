// Morton (Z-order) codes.
#pragma once

#include <cstdint>

#include "candidate.h"

namespace handhold {

/// Spreads the low 21 bits of v so that two zero bits follow each.
constexpr std::uint64_t spread3(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x001f00000000ffffull;
  v = (v | v << 16) & 0x001f0000ff0000ffull;
  v = (v | v << 8) & 0x100f00f00f00f00full;
  v = (v | v << 4) & 0x10c30c30c30c30c3ull;
  v = (v | v << 2) & 0x1249249249249249ull;
  return v;
}
constexpr std::uint64_t morton3(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread3(x) | spread3(y) << 1 | spread3(z) << 2;
}

/// Spreads the low 16 bits of v so that a zero bit follows each.
constexpr std::uint32_t spread2(std::uint32_t v) {
  v &= 0xffff;
  v = (v | v << 8) & 0x00ff00ff;
  v = (v | v << 4) & 0x0f0f0f0f;
  v = (v | v << 2) & 0x33333333;
  v = (v | v << 1) & 0x55555555;
  return v;
}
constexpr std::uint32_t morton2(std::uint32_t x, std::uint32_t y) {
  return spread2(x) | spread2(y) << 1;
}

namespace kernels {

/// A grid of cubic cells, numbered along the Morton curve.
struct MortonCells {
  float origin[3];    ///< m
  float size;         ///< m
  std::int32_t bits;  ///< of each coordinate

  /// Of the cell that holds a point (m), or of the outermost one on its side.
  HANDHOLD_SHARED std::uint64_t number(const float* p) const {
    const float last = static_cast<float>((1 << bits) - 1);
    std::uint32_t c[3] = {};
    for (int k = 0; k < 3; ++k) {
      const float at = (p[k] - origin[k]) / size;
      c[k] = static_cast<std::uint32_t>(at < 0.0f ? 0.0f : last < at ? last : at);
    }
    return morton3(c[0], c[1], c[2]);
  }
};

}  // namespace kernels

}  // namespace handhold
