// Which tiles a ball touches: blocks, then the tiles of a block, sixteen boxes at a time.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// The tests on boxes allow for rounding so that they never contradict the test on points: a box counts as outside only
/// beyond, and as inside only within, the radius by more than the rounding of a squared distance.
inline constexpr float kOutside = 1.0f + 2e-6f;
inline constexpr float kInside = 1.0f - 2e-6f;

struct Ball {
  F16 x, y, z;
  F16 r2, r2_outside, r2_inside;
  LANE_FN Ball(const float* c, float r)
      : x(c[0]), y(c[1]), z(c[2]), r2(r * r), r2_outside(r * r * kOutside), r2_inside(r * r * kInside) {}
};

/// Squared distance of points (dx, dy, dz) from the centre; the one expression that decides who is a neighbour.
LANE_FN F16 squared_norm(F16 dx, F16 dy, F16 dz) {
  return fma(dx, dx, fma(dy, dy, dz * dz));
}

struct BoxHits {
  std::uint32_t touched, inside;
};

/// Tests sixteen boxes (low x, y, z, high x, y, z; `stride` floats apart) against a ball.
LANE_FN BoxHits test_boxes(const float* const* box, std::size_t at, const Ball& ball) {
  const F16 zero(0.0f);
  const F16 ax = F16::load(box[0] + at) - ball.x, bx = ball.x - F16::load(box[3] + at);
  const F16 ay = F16::load(box[1] + at) - ball.y, by = ball.y - F16::load(box[4] + at);
  const F16 az = F16::load(box[2] + at) - ball.z, bz = ball.z - F16::load(box[5] + at);
  // Nearest point of the box: positive parts; farthest corner: the more negative side.
  const F16 nx = max(max(ax, bx), zero), ny = max(max(ay, by), zero), nz = max(max(az, bz), zero);
  const F16 fx = min(ax, bx), fy = min(ay, by), fz = min(az, bz);
  const M16 touched = squared_norm(nx, ny, nz) <= ball.r2_outside;
  const M16 inside = squared_norm(fx, fy, fz) <= ball.r2_inside;
  return {bits(touched), bits(inside & touched)};
}

/// Writes the numbers of the candidate blocks that a ball touches, in their order; room for `padded` + 16 entries.
LANE_FN int touched_blocks(const kernels::Candidates& candidates, const Ball& ball, std::uint32_t* list) {
  int n = 0;
  for (std::int32_t i = 0; i < candidates.padded; i += 16) {
    const std::uint32_t touched = test_boxes(candidates.boxes, static_cast<std::size_t>(i), ball).touched;
    n += append_selected(list + n, touched, candidates.block + i);
  }
  return n;
}

/// Which tiles of a block a ball touches.
struct TileHits {
  std::uint32_t boundary;  ///< tiles whose points must be tested one by one
  std::uint32_t inside;    ///< tiles of 16 points that lie wholly within
};
LANE_FN TileHits touched_tiles(const kernels::Tiles& tiles, std::uint32_t block, const Ball& ball) {
  const float* b = tiles.boxes + static_cast<std::size_t>(block) * 96;
  const float* const rows[6] = {b, b + 16, b + 32, b + 48, b + 64, b + 80};
  const BoxHits hits = test_boxes(rows, 0, ball);
  const std::uint32_t inside = hits.inside & tiles.full[block];
  return {hits.touched & ~inside, inside};
}

/// Start of a tile's x16 | y16 | z16; tiles are numbered through all blocks.
LANE_FN const float* tile_points(const kernels::Tiles& tiles, std::uint32_t tile) {
  return tiles.points + static_cast<std::size_t>(tile) * 48;
}

/// Visits the tiles that the ball touches, block by block: f(dx, dy, dz) with their points relative to its centre, and
/// `after_block()` when a block's are done. It may shrink the ball for those to come.
template <class F, class G>
LANE_FN void for_each_tile(const kernels::Tiles& tiles, const kernels::Candidates& candidates, const Ball& ball, F&& f,
                           G&& after_block) {
  for (std::int32_t i = 0; i < candidates.padded; i += 16) {
    std::uint32_t blocks = test_boxes(candidates.boxes, static_cast<std::size_t>(i), ball).touched;
    for (; blocks; blocks &= blocks - 1) {
      const std::uint32_t block = candidates.block[i + lowest_bit(blocks)];
      const TileHits hits = touched_tiles(tiles, block, ball);
      for (std::uint32_t rest = hits.boundary | hits.inside; rest; rest &= rest - 1) {
        const float* p = tile_points(tiles, 16 * block + static_cast<std::uint32_t>(lowest_bit(rest)));
        f(F16::load(p) - ball.x, F16::load(p + 16) - ball.y, F16::load(p + 32) - ball.z);
      }
      after_block();
    }
  }
}

/// kernels::Kernels::collect
LANE_FN std::int32_t collect_points(const kernels::Tiles& tiles, const kernels::Candidates& candidates,
                                    const float* centre, float radius, float* x, float* y, float* z) {
  const Ball ball(centre, radius);
  std::int32_t n = 0;
  for_each_tile(
      tiles, candidates, ball,
      [&](F16 dx, F16 dy, F16 dz) LANE_INLINE {
        const M16 in = squared_norm(dx, dy, dz) <= ball.r2;
        compress_store(x + n, in, dx);
        compress_store(y + n, in, dy);
        n += compress_store(z + n, in, dz);
      },
      [] {});
  return n;
}

/// kernels::Kernels::second_moments
LANE_FN void sum_second_moments(const kernels::Tiles& tiles, const kernels::Candidates& candidates, const float* centre,
                                float radius, float* sums) {
  const Ball ball(centre, radius);
  const F16 zero(0.0f), one(1.0f);
  F16 s[10];
  LANE_UNROLL(10)
  for (int k = 0; k < 10; ++k) s[k] = zero;
  for_each_tile(
      tiles, candidates, ball,
      [&](F16 x, F16 y, F16 z) LANE_INLINE {
        const M16 in = squared_norm(x, y, z) <= ball.r2;
        x = select(in, x, zero), y = select(in, y, zero), z = select(in, z, zero);
        s[0] = s[0] + select(in, one, zero), s[1] = s[1] + x, s[2] = s[2] + y, s[3] = s[3] + z;
        s[4] = fma(x, x, s[4]), s[5] = fma(x, y, s[5]), s[6] = fma(x, z, s[6]);
        s[7] = fma(y, y, s[7]), s[8] = fma(y, z, s[8]), s[9] = fma(z, z, s[9]);
      },
      [] {});
  float all[10];
  reduce_each(s, all);
  for (int k = 0; k < 10; ++k) sums[k] = all[k];
}

/// kernels::Kernels::nearest
LANE_FN bool nearest_point(const kernels::Tiles& tiles, const kernels::Candidates& candidates, const float* centre,
                           float radius, float* offset) {
  Ball ball(centre, radius);
  const F16 zero(0.0f);
  float limit = radius * radius;
  F16 best(2 * limit), x = zero, y = zero, z = zero;
  for_each_tile(
      tiles, candidates, ball,
      [&](F16 dx, F16 dy, F16 dz) LANE_INLINE {
        const F16 d2 = squared_norm(dx, dy, dz);
        const M16 nearer = d2 < best;
        best = select(nearer, d2, best), x = select(nearer, dx, x), y = select(nearer, dy, y),
        z = select(nearer, dz, z);
      },
      // What is farther than the best one need not be looked at.
      [&]() LANE_INLINE {
        const float least = reduce_min(best);
        if (least < limit) limit = least, ball.r2_outside = F16(limit * kOutside), ball.r2_inside = zero;
      });
  if (!(reduce_min(best) <= radius * radius)) return false;
  // Of equally near ones in several lanes the first.
  const std::uint32_t lane = static_cast<std::uint32_t>(lowest_bit(bits(best <= F16(reduce_min(best)))));
  offset[0] = lane_value(x, lane), offset[1] = lane_value(y, lane), offset[2] = lane_value(z, lane);
  return true;
}

/// kernels::Kernels::any_nearer
LANE_FN bool find_nearer(const float* px, const float* py, const float* pz, std::int32_t n, const float* place,
                         float limit2) {
  const F16 x(place[0]), y(place[1]), z(place[2]), limit(limit2);
  const auto nearer = [&](std::int32_t i) LANE_INLINE {
    return squared_norm(F16::loadu(px + i) - x, F16::loadu(py + i) - y, F16::loadu(pz + i) - z) < limit;
  };
  std::int32_t i = 0;
  for (; i + 16 <= n; i += 16) {
    if (any(nearer(i))) return true;
  }
  return i < n && any(nearer(i) & (lane_numbers() < F16(static_cast<float>(n - i))));
}

}  // namespace handhold::HANDHOLD_LANE
