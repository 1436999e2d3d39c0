// Stable least-significant-digit radix sort of 64-bit words by some of their bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

namespace handhold {

/// Sorts `n` words by the bits [first_bit, first_bit + bits), eleven at a time. `a` and `b` hold n words each; returns
/// the one that holds the result.
inline std::uint64_t* radix_sort(std::uint64_t* a, std::uint64_t* b, std::size_t n, int first_bit, int bits) {
  constexpr int kDigit = 11;
  constexpr std::size_t kBuckets = std::size_t{1} << kDigit;
  for (int done = 0; done < bits; done += kDigit) {
    const int shift = first_bit + done;
    std::uint32_t start[kBuckets] = {};
    for (std::size_t i = 0; i < n; ++i) ++start[a[i] >> shift & (kBuckets - 1)];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) sum += std::exchange(s, sum);
    for (std::size_t i = 0; i < n; ++i) b[start[a[i] >> shift & (kBuckets - 1)]++] = a[i];
    std::swap(a, b);
  }
  return a;
}

}  // namespace handhold
