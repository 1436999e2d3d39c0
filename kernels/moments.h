// Moments of neighbourhoods up to degree 4.
//
// Float sums are fast but lose the axis where a surface is smooth and dense. Two measures keep it: sums are carried to
// double every `kChunk` vectors, and the points' height is taken over a rough tangent plane, so that the small numbers
// that decide the fit are summed as small numbers. The plane comes from the sums that each tile carries; it is a shear
// along the coordinate axis nearest its normal (two fused multiply-adds a point, where a rotation would take nine), and
// the shear is undone exactly, in double, on the moments.
//
// Three phases for sixteen neighbourhoods at a time: find blocks and add up the sums of their tiles; rough planes, one
// neighbourhood a lane, where flat ones end; then the tiles and points of the others, compacted where a tile crosses
// the ball, in two passes over the 34 sums because the registers do not hold them all at once.
#pragma once

#include "kernels.h"
#include "lane.h"
#include "moment_sums.h"
#include "neighbours.h"
#include "rough_plane.h"

namespace handhold::HANDHOLD_LANE {

inline constexpr int kSubBatch = 16;       ///< neighbourhoods per round of the three phases
inline constexpr int kBufferVectors = 64;  ///< compacted boundary points held at once

/// What the kernel keeps between its phases; followed in memory by sixteen lists of blocks and two of tiles.
struct alignas(64) MomentScratch {
  float sums[16][kSubBatch];       ///< tile sums about the sample, one neighbourhood a lane
  float rows[48][16];              ///< accumulators on their way to double
  float plane[3][kSubBatch];       ///< height axis, shear a, shear b: height = w - a u - b v
  float residual2[kSubBatch];      ///< mean squared distance from the plane (m^2)
  float narrow2[kSubBatch];        ///< variance along the plane's short side (m^2)
  std::int32_t blocks[kSubBatch];  ///< lengths of the lists of blocks
  double total[kSubBatch][48];     ///< [0]: n, [1 ..]: sums
  double shear[2][kSubBatch];      ///< of the neighbourhoods that were summed
  float buffer[3][kBufferVectors * 16 + 16];
};

// ---- Phase 1: touched blocks, and the sums of the tiles whose mean lies in the ball --------------------------------

/// Writes the numbers of the touched blocks and their count; adds up into lane `lane` of m.sums.
LANE_FN void add_tile_sums(const kernels::Tiles& tiles, const kernels::Candidates& candidates, const float* centre,
                           float radius, int lane, std::uint32_t* blocks, MomentScratch& m) {
  const Ball ball(centre, radius);
  const F16 zero(0.0f);
  F16 s[10];
  LANE_UNROLL(10)
  for (int i = 0; i < 10; ++i) s[i] = zero;
  const int n = touched_blocks(candidates, ball, blocks);
  m.blocks[lane] = n;
  for (int i = 0; i < n; ++i) add_block_sums(tiles, blocks[i], ball, s);
  float sums[10];
  reduce_each(s, sums);
  LANE_UNROLL(10)
  for (int i = 0; i < 10; ++i) m.sums[i][lane] = sums[i];
}

// ---- Phase 2: rough planes, one neighbourhood a lane --------------------------------------------------------------

LANE_FN void rough_planes(MomentScratch& m, float radius) {
  F16 sums[kLowSums];
  LANE_UNROLL(10)
  for (int k = 0; k < kLowSums; ++k) sums[k] = F16::load(m.sums[k]);
  const RoughPlane<F16> plane = rough_plane(sums, radius);
  plane.up.store(m.plane[0]), plane.a.store(m.plane[1]), plane.b.store(m.plane[2]);
  plane.residual2.store(m.residual2), plane.narrow2.store(m.narrow2);
}

// ---- Phase 3: the points ------------------------------------------------------------------------------------------

/// Adds the sums [kFirst, kLast) over n_inside whole tiles and n_buffer vectors of the buffer, and leaves them in
/// m.rows.
template <int kFirst, int kLast>
LANE_FN void sum_range(const kernels::Tiles& tiles, const std::uint32_t* inside, int n_inside, int first, int n_buffer,
                       const float* centre, const HeightFrame& frame, MomentScratch& m) {
  const Sum a(frame.a), b(frame.b);
  const Sum cu(centre[frame.u]), cv(centre[frame.v]), cw(centre[frame.w]);
  LANE_ROLLED
  for (int lane = 0; lane < 16; lane += kSumLanes) {
    Sum s[kLast - kFirst];
    LANE_UNROLL(34)
    for (int k = 0; k < kLast - kFirst; ++k) s[k] = Sum(0.0f);
    const float *pu = tiles.points + 16 * frame.u + lane, *pv = tiles.points + 16 * frame.v + lane;
    const float* pw = tiles.points + 16 * frame.w + lane;
    LANE_ROLLED
    for (int i = 0; i < n_inside; ++i) {
      const std::size_t at = 48 * static_cast<std::size_t>(inside[i]);
      const Sum x = Sum::load(pu + at) - cu, y = Sum::load(pv + at) - cv;
      const Sum z = fnma(a, x, fnma(b, y, Sum::load(pw + at) - cw));
      add_point<kFirst, kLast>(s, x, y, z);
    }
    pu = m.buffer[frame.u] + lane, pv = m.buffer[frame.v] + lane, pw = m.buffer[frame.w] + lane;
    LANE_ROLLED
    for (int i = first; i < first + n_buffer; ++i) {
      const Sum x = Sum::load(pu + 16 * i), y = Sum::load(pv + 16 * i);
      const Sum z = fnma(a, x, fnma(b, y, Sum::load(pw + 16 * i)));
      add_point<kFirst, kLast>(s, x, y, z);
    }
    LANE_UNROLL(34)
    for (int k = 0; k < kLast - kFirst; ++k) s[k].store(m.rows[kFirst + k] + lane);
  }
}

/// All 34 sums over one chunk, in as many passes as keep the accumulators in registers, added to the double sums.
LANE_FN void sum_chunk(const kernels::Tiles& tiles, const std::uint32_t* inside, int n_inside, int first, int n_buffer,
                       const float* centre, const HeightFrame& frame, MomentScratch& m, double* total) {
#if defined(HANDHOLD_ISA_AVX512)
  sum_range<0, 19>(tiles, inside, n_inside, first, n_buffer, centre, frame, m);
  sum_range<19, 34>(tiles, inside, n_inside, first, n_buffer, centre, frame, m);
#else
  sum_range<0, 9>(tiles, inside, n_inside, first, n_buffer, centre, frame, m);
  sum_range<9, 19>(tiles, inside, n_inside, first, n_buffer, centre, frame, m);
  sum_range<19, 27>(tiles, inside, n_inside, first, n_buffer, centre, frame, m);
  sum_range<27, 34>(tiles, inside, n_inside, first, n_buffer, centre, frame, m);
#endif
  // Rows 34 and on are zero.
  for (int k = 0; k < 48; k += 16) add_to_doubles(total + k, reduce_rows(m.rows + k));
}

/// Sums of one neighbourhood in its height frame: m.total[slot][k] for k < 34 as add_point. Returns the number of
/// points. What is summed is a row of vectors, the tiles within the ball and then what is left of those on its surface,
/// in chunks of kChunk.
LANE_FN std::int32_t sum_neighbourhood(const kernels::Tiles& tiles, const std::uint32_t* boundary, int n_boundary,
                                       const std::uint32_t* inside, int n_inside, const float* centre, const Ball& ball,
                                       const HeightFrame& frame, MomentScratch& m, int slot) {
  double* const total = m.total[slot];
  LANE_UNROLL(6)
  for (int k = 0; k < 48; k += 8) D8(0.0).store(total + k);
  std::int32_t count = 16 * n_inside;
  int n_buffer = 0, next = 0;
  for (bool all = false; !all;) {
    for (; next < n_boundary && n_buffer <= (kBufferVectors - 1) * 16; ++next) {
      const float* p = tile_points(tiles, boundary[next]);
      const F16 dx = F16::load(p) - ball.x, dy = F16::load(p + 16) - ball.y, dz = F16::load(p + 32) - ball.z;
      const M16 in = squared_norm(dx, dy, dz) <= ball.r2;
      compress_store(m.buffer[0] + n_buffer, in, dx);
      compress_store(m.buffer[1] + n_buffer, in, dy);
      n_buffer += compress_store(m.buffer[2] + n_buffer, in, dz);
    }
    all = next == n_boundary;
    if (all) {
      // Zeros add nothing to any sum: the last vector is filled up with them.
      for (int k = 0; k < 3; ++k) F16(0.0f).storeu(m.buffer[k] + n_buffer);
    }
    int left = all ? (n_buffer + 15) / 16 : n_buffer / 16, first = 0;
    while (n_inside + left >= kChunk || (all && n_inside + left > 0)) {
      const int whole = n_inside < kChunk ? n_inside : kChunk;
      const int rest = left < kChunk - whole ? left : kChunk - whole;
      sum_chunk(tiles, inside, whole, first, rest, centre, frame, m, total);
      inside += whole, n_inside -= whole;
      first += rest, left -= rest;
    }
    if (all) {
      count += n_buffer;
      break;
    }
    // What is left moves to the front; it is less than a chunk.
    for (int i = 0; 16 * (first + i) < n_buffer; ++i) {
      for (int k = 0; k < 3; ++k) F16::load(m.buffer[k] + 16 * (first + i)).store(m.buffer[k] + 16 * i);
    }
    count += 16 * first;
    n_buffer -= 16 * first;
  }
  return count;
}

/// Undoes the shear, scales by the radius and writes the moments of up to kSubBatch neighbourhoods.
LANE_FN void finish_moments(MomentScratch& m, int n, float radius, kernels::Moments* const* out) {
  alignas(64) double column[kernels::kMoments][kSubBatch];
  for (int i = 0; i < kSubBatch; ++i) {
    const int from = i < n ? i : 0;
    column[0][i] = static_cast<double>(out[from]->count);
    for (int k = 1; k < kernels::kMoments; ++k) column[k][i] = m.total[from][k - 1];
    m.shear[0][i] = m.shear[0][from], m.shear[1][i] = m.shear[1][from];
  }
  LANE_ROLLED
  for (int lane = 0; lane < kSubBatch; lane += 8) {
    D8 v[kernels::kMoments];
    LANE_UNROLL(35)
    for (int k = 0; k < kernels::kMoments; ++k) {
      v[k] = D8::load(column[k] + lane);
    }
    moments_from_sums(v, radius, D8::load(m.shear[0] + lane), D8::load(m.shear[1] + lane));
    LANE_UNROLL(35)
    for (int k = 0; k < kernels::kMoments; ++k) v[k].store(column[k] + lane);
  }
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < kernels::kMoments; ++k) out[i]->sum[k] = column[k][i];
}

/// kernels::Kernels::moments
LANE_FN void neighbourhood_moments(const kernels::Tiles& tiles, const kernels::Candidates& candidates,
                                   const kernels::NeighbourhoodBatch& batch, void* memory, kernels::Moments* out) {
  MomentScratch& m = *static_cast<MomentScratch*>(memory);
  std::uint32_t* const lists = reinterpret_cast<std::uint32_t*>(static_cast<char*>(memory) + sizeof(MomentScratch));
  const std::size_t capacity = static_cast<std::size_t>(candidates.padded) + 16;
  std::uint32_t* const boundary = lists + kSubBatch * capacity;
  std::uint32_t* const inside = boundary + 16 * capacity;
  kernels::Moments* summed[kSubBatch];  // they wait until as many are there as can be finished at once
  int n_summed = 0;
  for (std::int32_t first = 0; first < batch.n; first += kSubBatch) {
    const int n = batch.n - first < kSubBatch ? batch.n - first : kSubBatch;
    for (int k = 0; k < 10; ++k) F16(0.0f).store(m.sums[k]);
    for (int k = 34; k < 48; ++k) F16(0.0f).store(m.rows[k]);
    for (int i = 0; i < n; ++i) {
      add_tile_sums(tiles, candidates, batch.centre + 3 * (first + i), batch.radius, i,
                    lists + capacity * static_cast<std::size_t>(i), m);
    }
    rough_planes(m, batch.radius);
    for (int i = 0; i < n; ++i) {
      kernels::Moments& to = out[first + i];
      const float* c = batch.centre + 3 * (first + i);
      to.skipped = 0;
      if (is_flat(m.sums[0][i], m.residual2[i], m.narrow2[i], batch.radius, batch.flat_rms, batch.flat_slope)) {
        to.skipped = 1;
        to.count = static_cast<std::int32_t>(m.sums[0][i]);
        continue;
      }
      const int w = static_cast<int>(m.plane[0][i]), u = (w + 1) % 3, v = (w + 2) % 3;
      const HeightFrame frame = {u, v, w, m.plane[1][i], m.plane[2][i]};
      const std::uint32_t* blocks = lists + capacity * static_cast<std::size_t>(i);
      const Ball ball(c, batch.radius);
      int n_boundary = 0, n_inside = 0;
      for (std::int32_t b = 0; b < m.blocks[i]; ++b) {
        const TileHits hits = touched_tiles(tiles, blocks[b], ball);
        n_boundary += append_bits(boundary + n_boundary, hits.boundary, 16 * blocks[b]);
        n_inside += append_bits(inside + n_inside, hits.inside, 16 * blocks[b]);
      }
      to.count = sum_neighbourhood(tiles, boundary, n_boundary, inside, n_inside, c, ball, frame, m, n_summed);
      if (to.count < batch.min_points) {
        to.skipped = 1;
        continue;
      }
      for (int k = 0; k < 9; ++k) to.R_frame_cloud[k] = 0.0;
      to.R_frame_cloud[u] = to.R_frame_cloud[3 + v] = to.R_frame_cloud[6 + w] = 1.0;
      m.shear[0][n_summed] = static_cast<double>(frame.a), m.shear[1][n_summed] = static_cast<double>(frame.b);
      summed[n_summed++] = &to;
      if (n_summed == kSubBatch) {
        finish_moments(m, n_summed, batch.radius, summed);
        n_summed = 0;
      }
    }
  }
  if (n_summed) finish_moments(m, n_summed, batch.radius, summed);
}

}  // namespace handhold::HANDHOLD_LANE
