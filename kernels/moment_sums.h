// What is summed over the points of a neighbourhood, and what becomes of it.
#pragma once

#include "kernels.h"
#include "lane.h"
#include "moment_shift.h"
#include "neighbours.h"
#include "rough_plane.h"

namespace handhold::HANDHOLD_LANE {

#ifndef HANDHOLD_CHUNK
#define HANDHOLD_CHUNK 48
#endif
/// Vectors of 16 points summed in float before they are carried to double.
inline constexpr int kChunk = HANDHOLD_CHUNK;

/// Adds the low-order sums of those tiles of a block whose mean lies in the ball, one tile a lane.
LANE_FN void add_block_sums(const kernels::Tiles& tiles, std::uint32_t block, const Ball& ball, F16* s) {
  const F16 zero(0.0f);
  const float* t = tiles.sums + static_cast<std::size_t>(block) * 160;
  const F16 x = F16::load(t + 16) - ball.x, y = F16::load(t + 32) - ball.y, z = F16::load(t + 48) - ball.z;
  const M16 in = squared_norm(x, y, z) <= ball.r2;
  // Nothing is infinite here: an empty tile has the mean kFar and no points, and 0 * kFar is 0.
  const F16 w = select(in, F16::load(t), zero);
  const F16 wx = w * x, wy = w * y, wz = w * z;
  s[0] = s[0] + w, s[1] = s[1] + wx, s[2] = s[2] + wy, s[3] = s[3] + wz;
  s[4] = add_where(in, fma(wx, x, s[4]), F16::load(t + 64));
  s[5] = add_where(in, fma(wx, y, s[5]), F16::load(t + 80));
  s[6] = add_where(in, fma(wx, z, s[6]), F16::load(t + 96));
  s[7] = add_where(in, fma(wy, y, s[7]), F16::load(t + 112));
  s[8] = add_where(in, fma(wy, z, s[8]), F16::load(t + 128));
  s[9] = add_where(in, fma(wz, z, s[9]), F16::load(t + 144));
}

/// Sums 0..8 are of degree 1 and 2, 9..18 of degree 3, 19..33 of degree 4, in the order of moment_index less one.
template <int kFirst, int kLast, int k, class V>
LANE_FN void add_if(V* s, V a, V b) {
  if constexpr (k >= kFirst && k < kLast) s[k - kFirst] = fma(a, b, s[k - kFirst]);
}
template <int kFirst, int kLast, class V>
LANE_FN void add_point(V* s, V x, V y, V z) {
  if constexpr (kFirst == 0) s[0] = s[0] + x, s[1] = s[1] + y, s[2] = s[2] + z;
  add_if<kFirst, kLast, 3>(s, x, x), add_if<kFirst, kLast, 4>(s, x, y), add_if<kFirst, kLast, 5>(s, x, z);
  add_if<kFirst, kLast, 6>(s, y, y), add_if<kFirst, kLast, 7>(s, y, z), add_if<kFirst, kLast, 8>(s, z, z);
  if constexpr (kLast > 9) {
    const V xx = x * x, xy = x * y, yy = y * y, zz = z * z;
    add_if<kFirst, kLast, 9>(s, xx, x), add_if<kFirst, kLast, 10>(s, xx, y), add_if<kFirst, kLast, 11>(s, xx, z);
    add_if<kFirst, kLast, 12>(s, yy, x), add_if<kFirst, kLast, 13>(s, xy, z), add_if<kFirst, kLast, 14>(s, zz, x);
    add_if<kFirst, kLast, 15>(s, yy, y), add_if<kFirst, kLast, 16>(s, yy, z), add_if<kFirst, kLast, 17>(s, zz, y);
    add_if<kFirst, kLast, 18>(s, zz, z);
    if constexpr (kLast > 19) {
      const V xz = x * z, yz = y * z;
      add_if<kFirst, kLast, 19>(s, xx, xx), add_if<kFirst, kLast, 20>(s, xx, xy), add_if<kFirst, kLast, 21>(s, xx, xz);
      add_if<kFirst, kLast, 22>(s, xx, yy), add_if<kFirst, kLast, 23>(s, xx, yz), add_if<kFirst, kLast, 24>(s, xx, zz);
      add_if<kFirst, kLast, 25>(s, xy, yy), add_if<kFirst, kLast, 26>(s, yy, xz), add_if<kFirst, kLast, 27>(s, xy, zz);
      add_if<kFirst, kLast, 28>(s, xz, zz), add_if<kFirst, kLast, 29>(s, yy, yy), add_if<kFirst, kLast, 30>(s, yy, yz);
      add_if<kFirst, kLast, 31>(s, yy, zz), add_if<kFirst, kLast, 32>(s, yz, zz), add_if<kFirst, kLast, 33>(s, zz, zz);
    }
  }
}

/// Coordinates of a neighbourhood's frame: u, v, and the height over the rough plane.
struct HeightFrame {
  int u, v, w;  ///< which coordinate: 0, 1 or 2
  float a, b;   ///< height = w - a u - b v
};

/// Sums over heights, about the sample (m), to moments: undoes the shear and scales by the radius. v[0]: number of
/// points.
template <class R>
LANE_FN void moments_from_sums(R* v, float radius, R a, R b) {
  const double s = 1.0 / static_cast<double>(radius);
  const double scale[5] = {1.0, s, s * s, s * s * s, s * s * s * s};
  LANE_UNROLL(35)
  for (int k = 0; k < kernels::kMoments; ++k)
    v[k] = v[k] * R(scale[k == 0 ? 0 : k < 4 ? 1 : k < 10 ? 2 : k < 20 ? 3 : 4]);
  shear_moments(v, a, b);
}

}  // namespace handhold::HANDHOLD_LANE
