// Counter-based random numbers: a value is a function of (seed, stream, index, draw) and of nothing else, so samples do
// not depend on the order in which threads make them.
#pragma once

#include <cstdint>

namespace handhold {

/// Finaliser of SplitMix64 (Steele, Lea, Flood 2014): a bijection whose output bits all depend on all input bits.
constexpr std::uint64_t mix64(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ull;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebull;
  return x ^ x >> 31;
}

class CounterRandom {
 public:
  /// What the numbers of one stream have in common.
  static constexpr std::uint64_t stream_state(std::uint64_t seed, std::uint64_t stream) {
    return mix64(mix64(seed + kStep) + kStep * (stream + 1));
  }
  constexpr CounterRandom(std::uint64_t of_stream, std::uint64_t index)
      : state_(mix64(of_stream + kStep * (index + 1))) {}
  constexpr CounterRandom(std::uint64_t seed, std::uint64_t stream, std::uint64_t index)
      : CounterRandom(stream_state(seed, stream), index) {}

  constexpr std::uint64_t next() { return mix64(state_ += kStep); }
  /// Uniform over 0 .. n-1 (n > 0), by multiplication: the bias is below n / 2^64.
  constexpr std::uint64_t below(std::uint64_t n) {
    return static_cast<std::uint64_t>(static_cast<unsigned __int128>(next()) * n >> 64);
  }
  /// Uniform in the open interval (0, 1).
  constexpr double uniform() { return (static_cast<double>(next() >> 11) + 0.5) * 0x1p-53; }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ull;
  std::uint64_t state_;
};

}  // namespace handhold
