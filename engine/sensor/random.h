// Counter-based random numbers: a value is a function of a key and a counter, so pixels can be drawn in any order.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace handhold::sensor {

/// Philox4x32-10 (Salmon, Moraes, Dror, Shaw: "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
inline std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter, std::uint64_t key) {
  auto k0 = static_cast<std::uint32_t>(key), k1 = static_cast<std::uint32_t>(key >> 32);
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = 0xD2511F53ull * counter[0], p1 = 0xCD9E8D57ull * counter[2];
    counter = {static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ k0, static_cast<std::uint32_t>(p1),
               static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ k1, static_cast<std::uint32_t>(p0)};
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  return counter;
}

/// Uniform in the open interval (0, 1).
inline double to_uniform(std::uint32_t bits) {
  return (bits + 0.5) * 0x1p-32;
}

/// Standard normal from two words (Box and Muller).
inline double to_normal(std::uint32_t a, std::uint32_t b) {
  return std::sqrt(-2 * std::log(to_uniform(a))) * std::cos(6.283185307179586 * to_uniform(b));
}

}  // namespace handhold::sensor
