// Morton (Z-order) codes.
#pragma once

#include <cstdint>

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

}  // namespace handhold
