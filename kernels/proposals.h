// What draws of samples about affordances share (paper, section 3.4, Algorithm 2).
#pragma once

#include <cstdint>

#include "candidate.h"
#include "normals.h"
#include "random.h"

namespace handhold::kernels {

inline constexpr int kTries = 100;  ///< draws of a sample at most; then it is drawn uniformly
/// Of the radius within which a draw goes to the nearest point: the larger ball only if the smaller one is empty. Half
/// of the draws lie within 0.45 of it of a surface.
inline constexpr float kNearShare = 0.45f;

/// An attempt of a sample: about which of n centres, and where, in standard deviations.
struct Draw {
  std::uint64_t centre;
  float normal[3];
};
HANDHOLD_SHARED Draw draw_attempt(std::uint64_t of_stream, std::uint64_t sample, std::uint64_t attempt,
                                  std::uint64_t centres) {
  CounterRandom random(of_stream, sample * kTries + attempt);
  Draw d;
  d.centre = random.below(centres);
  const std::uint64_t one = random.next(), other = random.next();
  float unused;
  normals_of(normal_parts(one), d.normal[0], d.normal[2]);
  normals_of(normal_parts(other), d.normal[1], unused);
  return d;
}

}  // namespace handhold::kernels
