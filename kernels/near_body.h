// Which pixels of a cloud are near to their neighbours; which of its points are near to a body, by branch and bound
// over boxes about regions, groups, blocks and tiles.
#pragma once

#include "kernels.h"
#include "lane.h"
#include "neighbours.h"

namespace handhold::HANDHOLD_LANE {

/// kernels::Kernels::near_pixels
LANE_FN void count_near_pixels(const kernels::PixelRow& row, float* counts) {
  const F16 zero(0.0f), one(1.0f), limit(row.limit2);
  const std::ptrdiff_t down = row.stride, around[8] = {-down - 1, -down, -down + 1, -1, 1, down - 1, down, down + 1};
  for (std::ptrdiff_t i = 0; i < row.width; i += 16) {
    const F16 x = F16::loadu(row.x + i), y = F16::loadu(row.y + i), z = F16::loadu(row.z + i);
    F16 sum = zero;
    LANE_UNROLL(8)
    for (int k = 0; k < 8; ++k) {
      const std::ptrdiff_t j = i + around[k];
      const F16 d2 = squared_norm(F16::loadu(row.x + j) - x, F16::loadu(row.y + j) - y, F16::loadu(row.z + j) - z);
      sum = add_where(d2 <= limit, sum, one);
    }
    sum.storeu(counts + i);
  }
}

/// Orders places by their signed distance d from a box without a root: d^2 outside, d inside.
///
/// The key never falls when one of the three excesses (distance beyond the box along its edges) grows, and neither does
/// its rounded value; so whatever bounds the excesses of some points bounds their keys, to the last bit.
LANE_FN F16 distance_key(F16 x, F16 y, F16 z) {
  const F16 zero(0.0f), ox = max(x, zero), oy = max(y, zero), oz = max(z, zero);
  return fma(ox, ox, fma(oy, oy, oz * oz)) + min(max(max(x, y), z), zero);
}
LANE_FN float distance_key(float distance) {
  return distance > 0 ? distance * distance : distance;
}

/// A key beyond all limits.
inline constexpr float kFarKey = 1e37f;

class BodyLanes {
 public:
  LANE_FN explicit BodyLanes(const kernels::BodyQuery& q) {
    const float sum = q.half[0] + q.half[1] + q.half[2];
    for (int i = 0; i < 3; ++i) {
      centre_[i] = F16(q.centre[i]), half_[i] = F16(q.half[i]), wide_[i] = F16(q.half[i] + kSlack * sum);
    }
    for (int i = 0; i < 9; ++i) turn_[i] = F16(q.R_body_cloud[i]), size_[i] = abs(turn_[i]);
  }

  /// Keys of sixteen points: x16 | y16 | z16.
  LANE_FN F16 of_points(const float* p) const {
    const F16 x = F16::load(p) - centre_[0], y = F16::load(p + 16) - centre_[1], z = F16::load(p + 32) - centre_[2];
    F16 excess[3];
    LANE_UNROLL(3)
    for (int i = 0; i < 3; ++i) excess[i] = abs(along(turn_ + 3 * i, x, y, z)) - half_[i];
    return distance_key(excess[0], excess[1], excess[2]);
  }

  /// At most the keys of the points in each of sixteen boxes (low x, y, z, then high x, y, z): of the boxes about them
  /// along the body's edges. Huge for an empty box.
  LANE_FN F16 of_boxes(const float* box) const {
    const F16 half(0.5f);
    F16 middle[3], extent[3];
    LANE_UNROLL(3)
    for (int i = 0; i < 3; ++i) {
      const F16 low = F16::load(box + 16 * i) - centre_[i], high = F16::load(box + 48 + 16 * i) - centre_[i];
      middle[i] = half * (low + high), extent[i] = half * (high - low);
    }
    const F16 reach = (abs(middle[0]) + extent[0]) + (abs(middle[1]) + extent[1]) + (abs(middle[2]) + extent[2]);
    F16 excess[3];
    LANE_UNROLL(3)
    for (int i = 0; i < 3; ++i) {
      const F16 size = fma(F16(kSlack), reach, along(size_ + 3 * i, extent[0], extent[1], extent[2]));
      excess[i] = abs(along(turn_ + 3 * i, middle[0], middle[1], middle[2])) - (wide_[i] + size);
    }
    return distance_key(excess[0], excess[1], excess[2]);
  }

 private:
  /// Of a box's distance and size: more than the rounding of what comes of them, so that no box is farther than one of
  /// its points. Some 20 times the unit of rounding, where 12 are needed.
  static constexpr float kSlack = 1.2e-6f;

  static LANE_FN F16 along(const F16* row, F16 x, F16 y, F16 z) { return fma(row[0], x, fma(row[1], y, row[2] * z)); }

  F16 centre_[3], half_[3], wide_[3];
  F16 turn_[9], size_[9];
};

/// Sixteen boxes of a level of the tree.
LANE_FN const float* box_record(const float* level, std::uint32_t parent) {
  return level + std::size_t{96} * parent;
}

/// Which of sixteen boxes a ball touches.
LANE_FN M16 touches(const float* boxes, const Ball& ball) {
  const F16 zero(0.0f);
  const F16 x = max(max(F16::load(boxes) - ball.x, ball.x - F16::load(boxes + 48)), zero);
  const F16 y = max(max(F16::load(boxes + 16) - ball.y, ball.y - F16::load(boxes + 64)), zero);
  const F16 z = max(max(F16::load(boxes + 32) - ball.z, ball.z - F16::load(boxes + 80)), zero);
  return squared_norm(x, y, z) <= ball.r2_outside;
}

/// Visits the lanes set in a mask until one of them says true.
template <class F>
LANE_FN bool any_lane(M16 mask, F&& visit) {
  for (std::uint32_t rest = bits(mask); rest; rest &= rest - 1) {
    if (visit(static_cast<std::uint32_t>(lowest_bit(rest)))) return true;
  }
  return false;
}

/// kernels::Kernels::any_point_within
LANE_FN bool find_point_within(const kernels::TileTree& tree, const kernels::BodyQuery& q) {
  const BodyLanes body(q);
  const F16 limit(distance_key(q.limit));
  // The ball that holds all places within the limit takes far fewer steps and rules out most boxes of bodies that are
  // far from everything.
  const float size = sqrt(fma(q.half[0], q.half[0], fma(q.half[1], q.half[1], q.half[2] * q.half[2])));
  const Ball ball(q.centre, (size + max(q.limit, 0.0f)) * (1.0f + 4e-6f));
  const auto near = [&](const float* level, std::uint32_t parent) LANE_INLINE {
    const float* boxes = box_record(level, parent);
    const M16 touched = touches(boxes, ball);
    return any(touched) ? touched & (body.of_boxes(boxes) < limit) : touched;
  };
  const auto in_tile = [&](std::uint32_t tile)
                           LANE_INLINE { return any(body.of_points(tree.points + std::size_t{48} * tile) < limit); };
  const auto in_block = [&](std::uint32_t block) LANE_INLINE {
    return any_lane(
        near(tree.tile_boxes, block), [&](std::uint32_t i)
                                          __attribute__((always_inline)) { return in_tile(16 * block + i); });
  };
  const auto in_group = [&](std::uint32_t group) LANE_INLINE {
    return any_lane(
        near(tree.block_boxes, group), [&](std::uint32_t i)
                                           __attribute__((always_inline)) { return in_block(16 * group + i); });
  };
  const auto in_region = [&](std::uint32_t region) LANE_INLINE {
    return any_lane(
        near(tree.group_boxes, region), [&](std::uint32_t i)
                                            __attribute__((always_inline)) { return in_group(16 * region + i); });
  };
  for (std::uint32_t top = 0; top < static_cast<std::uint32_t>(tree.regions / 16); ++top) {
    if (any_lane(
            near(tree.region_boxes, top), [&](std::uint32_t i)
                                              __attribute__((always_inline)) { return in_region(16 * top + i); })) {
      return true;
    }
  }
  return false;
}

/// Visits the lanes whose keys are below the limit, the least first; a visit may lower the limit.
template <class F>
LANE_FN void least_first(F16 keys, const float& limit, F&& visit) {
  const F16 lanes = F16::load(kLaneNumbers), far(kFarKey);
  for (;;) {
    const float least = reduce_min(keys);
    if (!(least < limit)) return;
    const auto lane = static_cast<std::uint32_t>(lowest_bit(bits(keys <= F16(least))));
    const F16 it(static_cast<float>(lane));
    keys = select((lanes < it) | (lanes > it), keys, far);
    visit(lane);
  }
}

/// kernels::Kernels::nearest_to_body
LANE_FN std::int64_t find_nearest_to_body(const kernels::TileTree& tree, const kernels::BodyQuery& q) {
  const BodyLanes body(q);
  float limit = distance_key(q.limit);
  std::int64_t nearest = -1;
  const auto keys = [&](const float* level, std::uint32_t parent)
                        LANE_INLINE { return body.of_boxes(box_record(level, parent)); };
  const auto in_tile = [&](std::uint32_t tile) LANE_INLINE {
    const F16 here = body.of_points(tree.points + std::size_t{48} * tile);
    const float least = reduce_min(here);
    if (!(least < limit)) return;
    limit = least;
    nearest = std::int64_t{16} * tile + lowest_bit(bits(here <= F16(least)));
  };
  const auto in_block = [&](std::uint32_t block) LANE_INLINE {
    least_first(keys(tree.tile_boxes, block), limit, [&](std::uint32_t i) LANE_INLINE { in_tile(16 * block + i); });
  };
  const auto in_group = [&](std::uint32_t group) LANE_INLINE {
    least_first(keys(tree.block_boxes, group), limit, [&](std::uint32_t i) LANE_INLINE { in_block(16 * group + i); });
  };
  const auto in_region = [&](std::uint32_t region) LANE_INLINE {
    least_first(keys(tree.group_boxes, region), limit, [&](std::uint32_t i) LANE_INLINE { in_group(16 * region + i); });
  };
  for (std::uint32_t top = 0; top < static_cast<std::uint32_t>(tree.regions / 16); ++top) {
    least_first(keys(tree.region_boxes, top), limit, [&](std::uint32_t i) LANE_INLINE { in_region(16 * top + i); });
  }
  return nearest;
}

}  // namespace handhold::HANDHOLD_LANE
