// Standard normal values, several at a time (Box and Muller 1958), in plain single precision: loops that the compiler
// can take four or more at once and whose bits do not depend on how many it takes.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "candidate.h"

namespace handhold {

/// Natural logarithm of positive normal numbers, to 2e-7 of its size or of one. The polynomial is that of the Cephes
/// library (S. Moshier).
HANDHOLD_SHARED float log_of(float x) {
  std::int32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  // x = 2^e m, m from root(1/2) to root(2)
  const std::int32_t e = (bits - 0x3f3504f3) >> 23;
  bits -= e * 0x00800000;
  float m;
  std::memcpy(&m, &bits, sizeof m);
  const float f = m - 1, f2 = f * f;
  float p = 7.0376836292e-2f;
  p = p * f - 1.1514610310e-1f, p = p * f + 1.1676998740e-1f, p = p * f - 1.2420140846e-1f;
  p = p * f + 1.4249322787e-1f, p = p * f - 1.6668057665e-1f, p = p * f + 2.0000714765e-1f;
  p = p * f - 2.4999993993e-1f, p = p * f + 3.3333331174e-1f;
  return static_cast<float>(e) * 0.693147180559945f + (f - 0.5f * f2 + f * f2 * p);
}

/// Sine and cosine of at most an eighth of a turn either way (rad); Cephes, too.
HANDHOLD_SHARED float short_sine(float x) {
  const float x2 = x * x;
  return x + x * x2 * (-1.6666654611e-1f + x2 * (8.3321608736e-3f - x2 * 1.9515295891e-4f));
}
HANDHOLD_SHARED float short_cosine(float x) {
  const float x2 = x * x;
  return 1 - 0.5f * x2 + x2 * x2 * (4.166664568298827e-2f + x2 * (-1.388731625493765e-3f + x2 * 2.443315711809948e-5f));
}

/// What a random word says of two normal values: of its bits 23 make the radius, 23 the angle within a quarter of a
/// turn, and two more the quarter.
struct NormalParts {
  float u;             ///< in the open interval (0, 1)
  float x;             ///< rad; within an eighth of a turn either way
  float sine, cosine;  ///< of the quarter
};
HANDHOLD_SHARED NormalParts normal_parts(std::uint64_t word) {
  const auto angle = static_cast<std::int32_t>(word >> 18 & 0x7fffff) - 0x400000;
  const auto quarter = static_cast<std::int32_t>(word >> 16 & 3);
  return {(static_cast<float>(static_cast<std::int32_t>(word >> 41)) + 0.5f) * 0x1p-23f,
          (static_cast<float>(angle) + 0.5f) * (0x1p-23f * 1.57079632679489662f),
          static_cast<float>(quarter == 1) - static_cast<float>(quarter == 3),
          static_cast<float>(quarter == 0) - static_cast<float>(quarter == 2)};
}
HANDHOLD_SHARED void normals_of(const NormalParts& p, float& first, float& second) {
  const float s = short_sine(p.x), c = short_cosine(p.x), r = sqrtf(-2 * log_of(p.u));
  first = r * (c * p.cosine - s * p.sine);
  second = r * (s * p.cosine + c * p.sine);
}

/// Two independent standard normal values for each of kNormalWords random words; none is beyond 5.8.
inline constexpr std::size_t kNormalWords = 16;
inline void normal_pairs(const std::uint64_t* words, float* first, float* second) {
  float u[kNormalWords], x[kNormalWords], sine[kNormalWords], cosine[kNormalWords];
  for (std::size_t i = 0; i < kNormalWords; ++i) {
    const NormalParts p = normal_parts(words[i]);
    u[i] = p.u, x[i] = p.x, sine[i] = p.sine, cosine[i] = p.cosine;
  }
  for (std::size_t i = 0; i < kNormalWords; ++i) normals_of({u[i], x[i], sine[i], cosine[i]}, first[i], second[i]);
}

}  // namespace handhold
