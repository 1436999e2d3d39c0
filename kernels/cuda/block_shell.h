// The shell of a candidate by a whole block of threads: shell.h's definition by other means. A few thousand distances
// are too many for one pack to look through again and again while the others wait; order statistics do not depend on
// who counts, so the result is the same.
#pragma once

#include "stages.h"

namespace handhold::HANDHOLD_LANE {

inline constexpr int kShellThreads = 128;

/// Shared memory of a block.
struct BlockShell {
  static constexpr std::uint32_t kGroups = 128, kBlocks = 256, kTiles = 2048, kValues = 4096, kBins = 256;
  kernels::ShellQuery query;
  std::uint32_t group[kGroups], block[kBlocks], tile[kTiles];
  float value[kValues];
  std::uint32_t groups, blocks, tiles, values;  ///< how many there are, or would be with room
  std::uint32_t bin[kBins], chosen, above;
  std::uint32_t partial[2][kShellThreads / 32];
};

/// Squared distances that all threads of a block look through together. Every thread gets every answer.
class BlockValues {
 public:
  LANE_FN BlockValues(BlockShell& s, const float* value, std::uint32_t n) : s_(s), value_(value), n_(n) {}

  /// Number of values in the open interval (low, high).
  LANE_FN std::int32_t between(float low, float high) {
    std::uint32_t n = 0;
    for (std::uint32_t i = threadIdx.x; i < n_; i += kShellThreads) n += value_[i] > low && value_[i] < high;
    const std::uint32_t of_warp = __reduce_add_sync(0xffffffffu, n);
    if (threadIdx.x % 32 == 0) s_.partial[turn_][threadIdx.x / 32] = of_warp;
    __syncthreads();
    std::uint32_t all = 0;
    LANE_UNROLL(4)
    for (int w = 0; w < kShellThreads / 32; ++w) all += s_.partial[turn_][w];
    turn_ ^= 1;  // what is written next was read before the last barrier
    return static_cast<std::int32_t>(all);
  }

  /// The j-th largest value in the open interval (low, high), which holds at least j >= 1 of them. Eight bits at a
  /// time: numbers that are not negative are ordered as their bits are.
  LANE_FN float largest(std::uint32_t j, float low, float high) {
    std::uint32_t first = low < 0.0f ? 0 : __float_as_uint(low) + 1, last = __float_as_uint(high) - 1;
    while (first < last) {
      const int shift = ::max(0, 32 - __clz(static_cast<int>(last - first)) - 8);
      for (std::uint32_t b = threadIdx.x; b < BlockShell::kBins; b += kShellThreads) s_.bin[b] = 0;
      __syncthreads();
      for (std::uint32_t i = threadIdx.x; i < n_; i += kShellThreads) {
        const std::uint32_t v = __float_as_uint(value_[i]);
        if (v >= first && v <= last) atomicAdd(&s_.bin[(v - first) >> shift], 1u);
      }
      __syncthreads();
      if (threadIdx.x < 32) choose_bin(j);
      __syncthreads();
      first += s_.chosen << shift;
      last = ::min(last, first + ((1u << shift) - 1));
      j -= s_.above;
    }
    return __uint_as_float(first);
  }

 private:
  /// The bin that holds the j-th from above, and how many lie above it; by the first warp, eight bins a thread.
  LANE_FN void choose_bin(std::uint32_t j) {
    const std::uint32_t top = BlockShell::kBins - 1 - 8 * threadIdx.x;
    std::uint32_t own = 0;
    LANE_UNROLL(8)
    for (std::uint32_t k = 0; k < 8; ++k) own += s_.bin[top - k];
    std::uint32_t up_to = own;
    LANE_UNROLL(5)
    for (unsigned step = 1; step < 32; step += step) {
      const std::uint32_t before = __shfl_up_sync(0xffffffffu, up_to, step);
      if (threadIdx.x >= step) up_to += before;
    }
    std::uint32_t above = up_to - own;
    if (above >= j || up_to < j) return;
    std::uint32_t k = 0;
    for (; above + s_.bin[top - k] < j; ++k) above += s_.bin[top - k];
    s_.chosen = top - k, s_.above = above;
  }

  BlockShell& s_;
  const float* value_;
  std::uint32_t n_;
  int turn_ = 0;
};

/// As find_gap.
LANE_FN float block_gap(BlockValues& values, float r2, float gap, float max2, std::int32_t k) {
  while (r2 <= max2) {
    const float outer = sqrt(r2) + gap, outer2 = outer * outer;
    if (values.between(r2, outer2) <= k) return r2;
    r2 = values.largest(static_cast<std::uint32_t>(k) + 1, r2, outer2);
  }
  return -1.0f;
}

/// As shell_from, from the start radius on.
LANE_FN kernels::ShellResult block_shell_from(BlockValues& values, const kernels::ShellQuery& q) {
  const float max2 = q.max_radius * q.max_radius, above_max2 = next_above(max2);
  kernels::ShellResult result = {kernels::kShellNoGap, 0.0f, 0.0f, 0, 0};
  float r2 = block_gap(values, q.start_radius * q.start_radius, q.gap, max2, q.max_gap_points);
  if (r2 < 0.0f) return result;
  result.status = kernels::kShellEmpty;
  std::int32_t inner = values.between(-1.0f, next_above(r2));
  if (inner < q.min_inner_points) {
    const std::int32_t all = values.between(-1.0f, above_max2);
    if (all < q.min_inner_points) return result;
    // The m-th smallest.
    r2 = values.largest(static_cast<std::uint32_t>(all - q.min_inner_points) + 1, -1.0f, above_max2);
    r2 = block_gap(values, r2, q.gap, max2, q.max_gap_points);
    if (r2 < 0.0f) return result;
    inner = values.between(-1.0f, next_above(r2));
  }
  result.status = kernels::kShellFound;
  result.radius = sqrt(r2);
  result.inner_points = inner;
  const float outer = result.radius + q.gap, limit = q.max_radius + q.gap;
  result.gap_points = values.between(r2, outer * outer);
  const std::int32_t beyond = values.between(r2, limit * limit);
  result.free_to = limit;
  if (beyond > q.max_gap_points)
    result.free_to = sqrt(values.largest(static_cast<std::uint32_t>(beyond - q.max_gap_points), r2, limit * limit));
  return result;
}

/// Appends base + t for every bit of `mask` to a list that other packs append to, too, as long as there is room.
LANE_FN void share_bits(std::uint32_t* list, std::uint32_t room, std::uint32_t* n, std::uint32_t mask,
                        std::uint32_t base) {
  std::uint32_t at = 0;
  const auto more = static_cast<std::uint32_t>(count_bits(mask));
  if (first_lane()) at = atomicAdd(n, more);
  at = from_first_lane(at);
  if (at + more <= room) append_bits(list + at, mask, base);
}

/// find_shell_of by a block of kShellThreads threads, all of which get the answer. scratch: of the block.
LANE_FN bool block_shell_of(const FrameView& f, const FrameQuery& q, const kernels::FrameCandidate& c,
                            std::uint32_t* scratch, BlockShell& s, kernels::ShellResult& r) {
  const std::uint32_t pack = threadIdx.x / 16, packs = kShellThreads / 16;
  if (threadIdx.x == 0) {
    s.query = kernels::shell_query(q.shell, q.fit, c.position, c.place, c.radius, c.density);
    s.groups = s.blocks = s.tiles = s.values = 0;
  }
  __syncthreads();
  const kernels::ShellQuery query = s.query;
  const ShellPlace place(query);
  const kernels::Tiles tiles = f.tiles();
  // Down the tree, level by level.
  std::uint32_t turn = 0;
  for (std::uint32_t top = 0; 16 * top < f.regions; ++top) {
    std::uint32_t regions = touched_boxes(f.region_boxes + 96 * static_cast<std::size_t>(top), place.ball);
    for (; regions; regions &= regions - 1) {
      if (turn++ % packs != pack) continue;
      const std::uint32_t region = 16 * top + static_cast<std::uint32_t>(lowest_bit(regions));
      share_bits(s.group, BlockShell::kGroups, &s.groups,
                 touched_boxes(f.group_boxes + 96 * static_cast<std::size_t>(region), place.ball), 16 * region);
    }
  }
  __syncthreads();
  for (std::uint32_t i = pack; i < s.groups && s.groups <= BlockShell::kGroups; i += packs) {
    const float* b = f.block_boxes + 96 * static_cast<std::size_t>(s.group[i]);
    const float* const rows[6] = {b, b + 16, b + 32, b + 48, b + 64, b + 80};
    share_bits(s.block, BlockShell::kBlocks, &s.blocks,
               test_slab(rows, 0, place.ball, place.ax, place.ay, place.az, place.width), 16 * s.group[i]);
  }
  __syncthreads();
  for (std::uint32_t i = pack; i < s.blocks && s.blocks <= BlockShell::kBlocks; i += packs)
    share_bits(s.tile, BlockShell::kTiles, &s.tiles, shell_tiles(tiles, s.block[i], place), 16 * s.block[i]);
  __syncthreads();
  const std::uint32_t n_tiles = s.tiles;
  if (s.groups > BlockShell::kGroups || s.blocks > BlockShell::kBlocks || n_tiles > BlockShell::kTiles) {
    // More than a block has room for: one pack does it as a CPU would.
    bool found = false;
    if (pack == 0) {
      found = find_shell_of(f, q, c, scratch, s.value, r);
      if (first_lane()) s.chosen = found;
    }
    __syncthreads();
    found = s.chosen != 0;
    __syncthreads();
    return found;
  }
  if (16 * n_tiles > BlockShell::kValues && 16 * n_tiles > f.scratch_words) {
    if (threadIdx.x == 0) add_one(&f.counts->lost), raise(&f.counts->wanted, 16 * n_tiles);
    return false;
  }
  float* const value = 16 * n_tiles > BlockShell::kValues ? reinterpret_cast<float*>(scratch) : s.value;
  const float limit = query.max_radius + query.gap;
  constexpr std::uint32_t kAtOnce = 4;
  for (std::uint32_t first = pack; first < n_tiles; first += kAtOnce * packs) {
    F16 x[kAtOnce], y[kAtOnce], z[kAtOnce];
    LANE_UNROLL(4)
    for (std::uint32_t j = 0; j < kAtOnce; ++j) {
      const std::uint32_t i = first + j * packs;
      const float* p = tile_points(tiles, s.tile[i < n_tiles ? i : first]);
      x[j] = F16::load(p) - place.ball.x, y[j] = F16::load(p + 16) - place.ball.y;
      z[j] = F16::load(p + 32) - place.ball.z;
    }
    LANE_UNROLL(4)
    for (std::uint32_t j = 0; j < kAtOnce; ++j) {
      if (first + j * packs >= n_tiles) break;
      const F16 t = fma(place.ax, x[j], fma(place.ay, y[j], place.az * z[j]));
      const F16 r2 = squared_norm(fnma(t, place.ax, x[j]), fnma(t, place.ay, y[j]), fnma(t, place.az, z[j]));
      const M16 in = (abs(t) <= place.width) & (r2 < F16(limit * limit));
      const std::uint32_t all = bits(in);
      std::uint32_t at = 0;
      if (first_lane()) at = atomicAdd(&s.values, static_cast<std::uint32_t>(count_bits(all)));
      at = from_first_lane(at);
      if (in.m) value[at + static_cast<std::uint32_t>(count_bits(all & ((1u << pack_lane()) - 1)))] = r2.v;
    }
  }
  __syncthreads();
  BlockValues values(s, value, s.values);
  r = block_shell_from(values, query);
  const kernels::End end = kernels::end_of_shell(r);
  if (threadIdx.x == 0) f.end[c.sample] = end;
  return end == kernels::kEndAffordance;
}

}  // namespace handhold::HANDHOLD_LANE
