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
#include "moment_shift.h"
#include "neighbours.h"

namespace handhold::HANDHOLD_LANE {

#ifndef HANDHOLD_CHUNK
#define HANDHOLD_CHUNK 48
#endif
inline constexpr int kChunk =
    HANDHOLD_CHUNK;                        ///< vectors of 16 points summed in float before they are carried to double
inline constexpr int kSubBatch = 16;       ///< neighbourhoods per round of the three phases
inline constexpr int kBufferVectors = 64;  ///< compacted boundary points held at once

/// What the kernel keeps between its phases; followed in memory by sixteen lists of blocks and two of tiles.
struct alignas(64) MomentScratch {
  float sums[16][kSubBatch];   ///< tile sums: n, x y z, xx xy xz yy yz zz about the sample, one neighbourhood a lane
  float rows[48][16];          ///< accumulators on their way to double
  float plane[3][kSubBatch];   ///< height axis, shear a, shear b: height = w - a u - b v
  float residual2[kSubBatch];  ///< mean squared distance from the plane (m^2)
  float narrow2[kSubBatch];    ///< variance along the plane's short side (m^2)
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
#pragma GCC unroll 10
  for (int i = 0; i < 10; ++i) s[i] = zero;
  const int n = touched_blocks(candidates, ball, blocks);
  m.blocks[lane] = n;
  for (int i = 0; i < n; ++i) {
    const float* t = tiles.sums + static_cast<std::size_t>(blocks[i]) * 160;
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
#pragma GCC unroll 10
  for (int i = 0; i < 10; ++i) s[i].store(m.rows[i]);
  alignas(64) float sums[16];
  reduce_rows(m.rows).store(sums);
#pragma GCC unroll 10
  for (int i = 0; i < 10; ++i) m.sums[i][lane] = sums[i];
}

// ---- Phase 2: rough planes, one neighbourhood a lane --------------------------------------------------------------

/// Plane of least squares through the summed tiles: smallest eigenvalue of their covariance by Newton's iteration from
/// zero (monotone, since all roots are real and not negative), normal from the cross product of two rows.
LANE_FN void rough_planes(MomentScratch& m, float radius) {
  const float(*column)[kSubBatch] = m.sums;
  const F16 zero(0.0f), one(1.0f);
  const F16 n = F16::load(column[0]);
  const F16 inverse = one / max(n, one);
  const F16 s1 = inverse * F16(1.0f / radius), s2 = s1 * F16(1.0f / radius);
  const F16 mx = F16::load(column[1]) * s1, my = F16::load(column[2]) * s1, mz = F16::load(column[3]) * s1;
  const F16 a = fnma(mx, mx, F16::load(column[4]) * s2), b = fnma(mx, my, F16::load(column[5]) * s2);
  const F16 c = fnma(mx, mz, F16::load(column[6]) * s2), d = fnma(my, my, F16::load(column[7]) * s2);
  const F16 e = fnma(my, mz, F16::load(column[8]) * s2), f = fnma(mz, mz, F16::load(column[9]) * s2);
  const F16 trace = a + d + f;
  const F16 minors = fnma(b, b, a * d) + fnma(c, c, a * f) + fnma(e, e, d * f);
  const F16 determinant = a * fnma(e, e, d * f) - b * fnma(c, e, b * f) + c * fnma(c, d, b * e);
  F16 lambda = zero;
#pragma GCC unroll 1
  for (int i = 0; i < 8; ++i) {
    // p = det - lambda minors + lambda^2 trace - lambda^3
    const F16 p = fnma(minors - lambda * (trace - lambda), lambda, determinant);
    const F16 slope = minors - lambda * (F16(2.0f) * trace - F16(3.0f) * lambda);
    lambda = lambda + select(slope > F16(1e-12f), p / max(slope, F16(1e-12f)), zero);
  }
  lambda = max(lambda, zero);
  (lambda * F16(radius * radius)).store(m.residual2);
  // The other two roots have the sum t and the product p; the smaller one.
  const F16 t = trace - lambda, p = fnma(lambda, t, minors);
  const F16 middle = F16(0.5f) * t - sqrt(max(fnma(F16(1.0f), p, F16(0.25f) * t * t), zero));
  (middle * F16(radius * radius)).store(m.narrow2);
  // Normal: the longest cross product of two rows of (C - lambda I).
  const F16 ra = a - lambda, rd = d - lambda, rf = f - lambda;
  const F16 x0 = b * e - c * rd, y0 = c * b - ra * e, z0 = ra * rd - b * b;  // row 0 x row 1
  const F16 x1 = b * rf - c * e, y1 = c * c - ra * rf, z1 = ra * e - b * c;  // row 0 x row 2
  const F16 x2 = rd * rf - e * e, y2 = e * c - b * rf, z2 = b * e - rd * c;  // row 1 x row 2
  F16 nx = x0, ny = y0, nz = z0, best = squared_norm(x0, y0, z0);
  const F16 l1 = squared_norm(x1, y1, z1), l2 = squared_norm(x2, y2, z2);
  M16 better = l1 > best;
  nx = select(better, x1, nx), ny = select(better, y1, ny), nz = select(better, z1, nz),
  best = select(better, l1, best);
  better = l2 > best;
  nx = select(better, x2, nx), ny = select(better, y2, ny), nz = select(better, z2, nz),
  best = select(better, l2, best);
  const M16 none = ~(best > F16(1e-30f));
  nx = select(none, zero, nx), ny = select(none, zero, ny), nz = select(none, one, nz);
  // Height along the coordinate axis nearest the normal; u, v are the other two in cyclic order.
  const F16 ax = abs(nx), ay = abs(ny), az = abs(nz);
  const M16 is_z = (az >= ax) & (az >= ay);
  const M16 is_y = ~is_z & (ay >= ax);
  const F16 w = select(is_z, nz, select(is_y, ny, nx));
  const F16 u = select(is_z, nx, select(is_y, nz, ny));
  const F16 v = select(is_z, ny, select(is_y, nx, nz));
  select(is_z, F16(2.0f), select(is_y, one, zero)).store(m.plane[0]);
  (-(u / w)).store(m.plane[1]);
  (-(v / w)).store(m.plane[2]);
}

// ---- Phase 3: the points ------------------------------------------------------------------------------------------

/// Sums 0..8 are of degree 1 and 2, 9..18 of degree 3, 19..33 of degree 4, in the order of moment_index less one.
template <int kFirst, int kLast, int k>
LANE_FN void add_if(Sum* s, Sum a, Sum b) {
  if constexpr (k >= kFirst && k < kLast) s[k - kFirst] = fma(a, b, s[k - kFirst]);
}
template <int kFirst, int kLast>
LANE_FN void add_point(Sum* s, Sum x, Sum y, Sum z) {
  if constexpr (kFirst == 0) s[0] = s[0] + x, s[1] = s[1] + y, s[2] = s[2] + z;
  add_if<kFirst, kLast, 3>(s, x, x), add_if<kFirst, kLast, 4>(s, x, y), add_if<kFirst, kLast, 5>(s, x, z);
  add_if<kFirst, kLast, 6>(s, y, y), add_if<kFirst, kLast, 7>(s, y, z), add_if<kFirst, kLast, 8>(s, z, z);
  if constexpr (kLast > 9) {
    const Sum xx = x * x, xy = x * y, yy = y * y, zz = z * z;
    add_if<kFirst, kLast, 9>(s, xx, x), add_if<kFirst, kLast, 10>(s, xx, y), add_if<kFirst, kLast, 11>(s, xx, z);
    add_if<kFirst, kLast, 12>(s, yy, x), add_if<kFirst, kLast, 13>(s, xy, z), add_if<kFirst, kLast, 14>(s, zz, x);
    add_if<kFirst, kLast, 15>(s, yy, y), add_if<kFirst, kLast, 16>(s, yy, z), add_if<kFirst, kLast, 17>(s, zz, y);
    add_if<kFirst, kLast, 18>(s, zz, z);
    if constexpr (kLast > 19) {
      const Sum xz = x * z, yz = y * z;
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

/// Adds the sums [kFirst, kLast) over n_inside whole tiles and n_buffer vectors of the buffer, and leaves them in
/// m.rows.
template <int kFirst, int kLast>
LANE_FN void sum_range(const kernels::Tiles& tiles, const std::uint32_t* inside, int n_inside, int first, int n_buffer,
                       const float* centre, const HeightFrame& frame, MomentScratch& m) {
  const Sum a(frame.a), b(frame.b);
  const Sum cu(centre[frame.u]), cv(centre[frame.v]), cw(centre[frame.w]);
#pragma GCC unroll 1
  for (int lane = 0; lane < 16; lane += kSumLanes) {
    Sum s[kLast - kFirst];
#pragma GCC unroll 34
    for (int k = 0; k < kLast - kFirst; ++k) s[k] = Sum(0.0f);
    const float *pu = tiles.points + 16 * frame.u + lane, *pv = tiles.points + 16 * frame.v + lane;
    const float* pw = tiles.points + 16 * frame.w + lane;
#pragma GCC unroll 1
    for (int i = 0; i < n_inside; ++i) {
      const std::size_t at = 48 * static_cast<std::size_t>(inside[i]);
      const Sum x = Sum::load(pu + at) - cu, y = Sum::load(pv + at) - cv;
      const Sum z = fnma(a, x, fnma(b, y, Sum::load(pw + at) - cw));
      add_point<kFirst, kLast>(s, x, y, z);
    }
    pu = m.buffer[frame.u] + lane, pv = m.buffer[frame.v] + lane, pw = m.buffer[frame.w] + lane;
#pragma GCC unroll 1
    for (int i = first; i < first + n_buffer; ++i) {
      const Sum x = Sum::load(pu + 16 * i), y = Sum::load(pv + 16 * i);
      const Sum z = fnma(a, x, fnma(b, y, Sum::load(pw + 16 * i)));
      add_point<kFirst, kLast>(s, x, y, z);
    }
#pragma GCC unroll 34
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
/// points.
LANE_FN std::int32_t sum_neighbourhood(const kernels::Tiles& tiles, const std::uint32_t* boundary, int n_boundary,
                                       const std::uint32_t* inside, int n_inside, const float* centre, const Ball& ball,
                                       const HeightFrame& frame, MomentScratch& m, int slot) {
  double* const total = m.total[slot];
#pragma GCC unroll 6
  for (int k = 0; k < 48; k += 8) D8(0.0).store(total + k);
  std::int32_t count = 16 * n_inside;
  int n_buffer = 0;
  for (int i = 0; i < n_boundary; ++i) {
    const float* p = tile_points(tiles, boundary[i]);
    const F16 dx = F16::load(p) - ball.x, dy = F16::load(p + 16) - ball.y, dz = F16::load(p + 32) - ball.z;
    const M16 in = squared_norm(dx, dy, dz) <= ball.r2;
    compress_store(m.buffer[0] + n_buffer, in, dx);
    compress_store(m.buffer[1] + n_buffer, in, dy);
    n_buffer += compress_store(m.buffer[2] + n_buffer, in, dz);
    if (n_buffer > (kBufferVectors - 1) * 16) {
      // Full: the whole vectors go, the rest moves to the front.
      constexpr int kWhole = kBufferVectors - 1;
      for (int first = 0; first < kWhole; first += kChunk) {
        sum_chunk(tiles, nullptr, 0, first, kWhole - first < kChunk ? kWhole - first : kChunk, centre, frame, m, total);
      }
      for (int k = 0; k < 3; ++k) F16::load(m.buffer[k] + kWhole * 16).store(m.buffer[k]);
      count += kWhole * 16;
      n_buffer -= kWhole * 16;
    }
  }
  count += n_buffer;
  // Zeros add nothing to any sum: the last vector is filled up with them.
  for (int k = 0; k < 3; ++k) F16(0.0f).storeu(m.buffer[k] + n_buffer);
  int left = (n_buffer + 15) / 16, first = 0;
  do {
    const int whole = n_inside < kChunk ? n_inside : kChunk;
    const int rest = left < kChunk - whole ? left : kChunk - whole;
    sum_chunk(tiles, inside, whole, first, rest, centre, frame, m, total);
    inside += whole, n_inside -= whole;
    first += rest, left -= rest;
  } while (n_inside > 0 || left > 0);
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
  const double s = 1.0 / static_cast<double>(radius);
  const double scale[5] = {1.0, s, s * s, s * s * s, s * s * s * s};
#pragma GCC unroll 1
  for (int lane = 0; lane < kSubBatch; lane += 8) {
    D8 v[kernels::kMoments];
#pragma GCC unroll 35
    for (int k = 0; k < kernels::kMoments; ++k) {
      v[k] = D8::load(column[k] + lane) * D8(scale[k == 0 ? 0 : k < 4 ? 1 : k < 10 ? 2 : k < 20 ? 3 : 4]);
    }
    shear_moments(v, D8::load(m.shear[0] + lane), D8::load(m.shear[1] + lane));
#pragma GCC unroll 35
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
      float flat = batch.flat_rms;
      if (batch.flat_slope > 0.0f && batch.flat_slope * m.narrow2[i] < flat) flat = batch.flat_slope * m.narrow2[i];
      // Twelve points are enough to tell a plane; fewer go on and are judged by their exact number.
      // Points on a line are flat, too: float sums cannot tell what lies beside it.
      const bool line = batch.flat_slope > 0.0f && m.narrow2[i] <= 1e-5f * batch.radius * batch.radius;
      if (m.sums[0][i] >= 12.0f && (line || m.residual2[i] < flat * flat)) {
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
