// Cylindrical shell with a gap for the fingers (paper, section 3.2), in closed form.
//
// The paper steps through radii. Only the order of the points' distances rho from the axis matters: an inner radius r
// is good when at most k points have rho in the open interval (r, r + gap) and at least m have rho <= r. From any r
// with more than k points in its gap, r may jump to the (k+1)-th largest of them: every radius passed over still had
// k+1 points in its gap. About three jumps end it, exactly.
//
// Most candidates have no gap, and a part of the points proves that: k+1 of *any* subset in every gap is enough to
// refuse. So an eighth of the tiles is looked at first, then half, then all, each going on from the radius reached.
#pragma once

#include "kernels.h"
#include "lane.h"
#include "neighbours.h"

namespace handhold::HANDHOLD_LANE {

/// Squared distances, padded to a multiple of 16 with kFar.
struct Rho2 {
  const float* value;
  std::int32_t n;
};

/// Number of values in the open interval (low, high).
LANE_FN std::int32_t count_between(Rho2 rho2, float low, float high) {
  std::int32_t n = 0;
  for (std::int32_t i = 0; i < rho2.n; i += 16) {
    const F16 v = F16::load(rho2.value + i);
    n += count((v > F16(low)) & (v < F16(high)));
  }
  return n;
}
LANE_FN float smallest_above(Rho2 rho2, float low) {
  F16 best(kernels::kFar);
  for (std::int32_t i = 0; i < rho2.n; i += 16) {
    const F16 v = F16::load(rho2.value + i);
    best = min(select(v > F16(low), v, best), best);
  }
  return reduce_min(best);
}
LANE_FN float largest_below(Rho2 rho2, float high) {
  F16 best(-1.0f);
  for (std::int32_t i = 0; i < rho2.n; i += 16) {
    const F16 v = F16::load(rho2.value + i);
    best = max(select(v < F16(high), v, best), best);
  }
  return reduce_max(best);
}

/// Values that a selection may copy together before it bisects them.
inline constexpr std::int32_t kNear = 1024;

/// The `n` values in the open interval (low, high), copied to `near` (kNear + 16 floats); all of them when they are
/// more than fit there. A selection within the interval finds the same among either.
LANE_FN Rho2 between(Rho2 rho2, float low, float high, std::int32_t n, float* near) {
  if (n > kNear) return rho2;
  std::int32_t at = 0;
  for (std::int32_t i = 0; i < rho2.n; i += 16) {
    const F16 v = F16::load(rho2.value + i);
    at += compress_store(near + at, (v > F16(low)) & (v < F16(high)), v);
  }
  F16(kernels::kFar).storeu(near + at);
  return {near, at};
}

/// The j-th largest value in the open interval (low, high), which holds at least j >= 1 of them. Bisection on the
/// value.
LANE_FN float jth_largest(Rho2 rho2, float low, float high, std::int32_t j) {
  if (j == 1) return largest_below(rho2, high);
  // More than `a`: at least j. More than `b`: fewer than j.
  float a = low, b = high;
  for (;;) {
    const float middle = 0.5f * (a + b);
    if (!(middle > a && middle < b)) break;
    const std::int32_t n = count_between(rho2, middle, high);
    if (n < j) {
      b = middle;
    } else {
      a = middle;
      if (n == j) break;
    }
  }
  return smallest_above(rho2, a);
}
/// The j-th smallest value above `low`; at least j >= 1 values lie in (low, high).
LANE_FN float jth_smallest(Rho2 rho2, float low, float high, std::int32_t j) {
  float a = low, b = high;  // below `a`: fewer than j; below `b`: at least j
  for (;;) {
    const float middle = 0.5f * (a + b);
    if (!(middle > a && middle < b)) break;
    const std::int32_t n = count_between(rho2, low, middle);
    if (n < j) {
      a = middle;
    } else {
      b = middle;
      if (n == j) break;
    }
  }
  return largest_below(rho2, b);
}

/// Smallest squared radius >= r2 with at most k points in its gap; negative when it would exceed `max2`.
/// near: kNear + 16 floats of scratch, 64-byte aligned.
LANE_FN float find_gap(Rho2 rho2, float r2, float gap, float max2, std::int32_t k, float* near) {
  while (r2 <= max2) {
    const float outer = sqrt(r2) + gap;
    const float outer2 = outer * outer;
    const std::int32_t n = count_between(rho2, r2, outer2);
    if (n <= k) return r2;
    r2 = jth_largest(between(rho2, r2, outer2, n, near), r2, outer2, k + 1);
  }
  return -1.0f;
}

/// The shell from all points, starting at the squared radius `r2` below which there is none. near: as in find_gap.
LANE_FN void shell_from(Rho2 rho2, float r2, const kernels::ShellQuery& q, float* near, kernels::ShellResult& result) {
  const float max2 = q.max_radius * q.max_radius;
  const float above_max2 = next_above(max2);
  result = {kernels::kShellNoGap, 0.0f, 0.0f, 0, 0};
  r2 = find_gap(rho2, r2, q.gap, max2, q.max_gap_points, near);
  if (r2 < 0.0f) return;
  result.status = kernels::kShellEmpty;
  std::int32_t inner = count_between(rho2, -1.0f, next_above(r2));
  if (inner < q.min_inner_points) {
    if (count_between(rho2, -1.0f, above_max2) < q.min_inner_points) return;
    r2 = jth_smallest(rho2, -1.0f, above_max2, q.min_inner_points);
    r2 = find_gap(rho2, r2, q.gap, max2, q.max_gap_points, near);
    if (r2 < 0.0f) return;
    inner = count_between(rho2, -1.0f, next_above(r2));
  }
  result.status = kernels::kShellFound;
  result.radius = sqrt(r2);
  result.inner_points = inner;
  const float outer = result.radius + q.gap, limit = q.max_radius + q.gap;
  result.gap_points = count_between(rho2, r2, outer * outer);
  const std::int32_t beyond = count_between(rho2, r2, limit * limit);
  result.free_to = limit;
  if (beyond > q.max_gap_points) {
    const Rho2 outside = between(rho2, r2, limit * limit, beyond, near);
    result.free_to = sqrt(jth_smallest(outside, r2, limit * limit, q.max_gap_points + 1));
  }
}

/// kernels::Kernels::shell_gap
LANE_FN void shell_gap_only(const float* rho2, std::int32_t n, const kernels::ShellQuery& q,
                            kernels::ShellResult& result) {
  alignas(64) float near[kNear + 16];
  shell_from({rho2, n}, q.start_radius * q.start_radius, q, near, result);
}

/// Boxes that reach into the cylinder of half length `half_width` about the axis: near enough, and in the slab.
LANE_FN std::uint32_t test_slab(const float* const* box, std::size_t at, const Ball& ball, F16 ax, F16 ay, F16 az,
                                F16 half_width) {
  const std::uint32_t touched = test_boxes(box, at, ball).touched;
  if (!touched) return 0;
  const F16 half(0.5f);
  const F16 lx = F16::load(box[0] + at), ly = F16::load(box[1] + at), lz = F16::load(box[2] + at);
  const F16 hx = F16::load(box[3] + at), hy = F16::load(box[4] + at), hz = F16::load(box[5] + at);
  // About the centre before adding: the rounding is then that of the small numbers.
  const F16 mx = half * ((lx - ball.x) + (hx - ball.x)), my = half * ((ly - ball.y) + (hy - ball.y));
  const F16 mz = half * ((lz - ball.z) + (hz - ball.z));
  const F16 ex = half * (hx - lx), ey = half * (hy - ly), ez = half * (hz - lz);
  const F16 offset = abs(fma(ax, mx, fma(ay, my, az * mz)));
  const F16 extent = fma(abs(ax), ex, fma(abs(ay), ey, abs(az) * ez));
  // A hair of slack for rounding: a box is only ever kept without need.
  return touched & bits(offset <= (extent + half_width) * F16(1.00001f) + F16(1e-7f));
}

/// A shell's query as the tests on boxes and points want it.
struct ShellPlace {
  Ball ball;
  F16 ax, ay, az, width;
  LANE_FN explicit ShellPlace(const kernels::ShellQuery& q)
      : ball(q.centre, sqrt((q.max_radius + q.gap) * (q.max_radius + q.gap) + q.half_width * q.half_width)),
        ax(q.axis[0]),
        ay(q.axis[1]),
        az(q.axis[2]),
        width(q.half_width) {}
};

/// The tiles of a block that reach into the cylinder.
LANE_FN std::uint32_t shell_tiles(const kernels::Tiles& tiles, std::uint32_t block, const ShellPlace& place) {
  const float* b = tiles.boxes + static_cast<std::size_t>(block) * 96;
  const float* const rows[6] = {b, b + 16, b + 32, b + 48, b + 64, b + 80};
  return test_slab(rows, 0, place.ball, place.ax, place.ay, place.az, place.width);
}

/// The shell among the points of these tiles. rho2: 16 * n_tiles + 32 floats of scratch, 64-byte aligned; near: as in
/// find_gap.
LANE_FN void shell_among(const kernels::Tiles& tiles, const std::uint32_t* list, std::int32_t n_tiles,
                         const kernels::ShellQuery& q, const ShellPlace& place, float* rho2, float* near,
                         kernels::ShellResult& result) {
  const float limit = q.max_radius + q.gap;
  const F16 ax = place.ax, ay = place.ay, az = place.az, width = place.width, limit2(limit * limit);
  std::int32_t n = 0;
  const auto add = [&](std::int32_t first, std::int32_t step) LANE_INLINE {
    for (std::int32_t i = first; i < n_tiles; i += step) {
      const float* p = tile_points(tiles, list[i]);
      const F16 dx = F16::load(p) - place.ball.x, dy = F16::load(p + 16) - place.ball.y;
      const F16 dz = F16::load(p + 32) - place.ball.z;
      const F16 t = fma(ax, dx, fma(ay, dy, az * dz));
      const F16 r2 = squared_norm(fnma(t, ax, dx), fnma(t, ay, dy), fnma(t, az, dz));
      n += compress_store(rho2 + n, (abs(t) <= width) & (r2 < limit2), r2);
    }
    F16(kernels::kFar).storeu(rho2 + n);
  };
  float r2 = q.start_radius * q.start_radius;
  const float max2 = q.max_radius * q.max_radius;
  result = {kernels::kShellNoGap, 0.0f, 0.0f, 0, 0};
  add(0, 8);
  r2 = find_gap({rho2, n}, r2, q.gap, max2, q.max_gap_points, near);
  if (r2 < 0.0f) return;
  add(2, 8), add(4, 8), add(6, 8);
  r2 = find_gap({rho2, n}, r2, q.gap, max2, q.max_gap_points, near);
  if (r2 < 0.0f) return;
  add(1, 2);
  shell_from({rho2, n}, r2, q, near, result);
}

/// kernels::Kernels::shell. Scratch: 16 * blocks + 16 tile numbers, then 256 * blocks + 32 floats.
LANE_FN void find_shell(const kernels::Tiles& tiles, const kernels::Candidates& candidates,
                        const kernels::ShellQuery& q, void* scratch, kernels::ShellResult& result) {
  const std::size_t capacity = 16 * static_cast<std::size_t>(tiles.blocks) + 16;
  std::uint32_t* const list = static_cast<std::uint32_t*>(scratch);
  float* const rho2 = reinterpret_cast<float*>(static_cast<char*>(scratch) + sizeof(std::uint32_t) * capacity);
  const ShellPlace place(q);
  std::int32_t n_tiles = 0;
  for (std::int32_t i = 0; i < candidates.padded; i += 16) {
    std::uint32_t blocks =
        test_slab(candidates.boxes, static_cast<std::size_t>(i), place.ball, place.ax, place.ay, place.az, place.width);
    for (; blocks; blocks &= blocks - 1) {
      const std::uint32_t block = candidates.block[i + lowest_bit(blocks)];
      n_tiles += append_bits(list + n_tiles, shell_tiles(tiles, block, place), 16 * block);
    }
  }
  alignas(64) float near[kNear + 16];
  shell_among(tiles, list, n_tiles, q, place, rho2, near, result);
}

}  // namespace handhold::HANDHOLD_LANE
