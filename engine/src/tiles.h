// The points of a cloud in tiles of 16 and blocks of 16 tiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "aligned.h"
#include "bounds.h"
#include "budget.h"
#include "handhold/cloud.h"
#include "kernels.h"

namespace handhold {

/// Where the blocks of an organized cloud stand: order[i] is the row-major number of the i-th block's 16x16 pixels
/// among `across` * `down` of them, along the Morton curve over the image.
void order_blocks(std::uint32_t across, std::uint32_t down, std::uint32_t* order);

/// Whether a cloud is taken as an image: a single row or column is none, whatever its height says.
inline bool is_image(const CloudView& cloud) {
  return cloud.width >= 4 && cloud.height >= 4;
}

/// The finite points of one cloud, laid out for the kernels. Reused from frame to frame.
///
/// Organized clouds: a tile is 4x4 pixels, a block 16x16, blocks in Z-order over the image. Unorganized clouds: points
/// in Z-order over space, cut into runs.
class TileStore {
 public:
  /// Builds from a cloud, in parallel in the caller's TBB arena. Points that are not finite are left out.
  /// @throws Budget::Spent, and nothing may be asked of this before another cloud is built
  void build(const CloudView& cloud, const Budget& budget = {});
  /// Builds from a part of the points of `full`, which was built from the same cloud: every step-th row and column of
  /// an image, otherwise every (step * step)-th point in their order along the Morton curve. step >= 1.
  void build_thinned(const CloudView& cloud, const TileStore& full, std::uint32_t step, const Budget& budget = {});

  kernels::Tiles view() const {
    return {points_.data(), boxes_.data(), full_.data(), sums_.data(), static_cast<std::int32_t>(blocks_)};
  }
  std::uint32_t blocks() const { return blocks_; }
  std::size_t finite_points() const { return finite_; }

  /// Box of a block: low x, y, z, 0, high x, y, z, 0 (m). An empty block has low x = kFar.
  const float* block_box(std::uint32_t block) const {
    return block_boxes_.data() + 8 * static_cast<std::size_t>(block);
  }
  bool block_empty(std::uint32_t block) const { return block_box(block)[0] >= kernels::kFar; }

  /// The finite point of that rank (0 .. finite_points()-1) in the order of the tiles.
  void finite_point(std::size_t rank, float* xyz) const;

  /// Bounds that hold nearly all points (m): the 2nd and 98th percentile of each coordinate over a fixed subset. Only
  /// valid with at least one finite point.
  const float* robust_low() const { return bounds_.low; }
  const float* robust_high() const { return bounds_.high; }

 private:
  void build_organized(const CloudView& cloud, std::uint32_t step, const Budget& budget);
  void build_unorganized(const CloudView& cloud, const Budget& budget);
  void allocate(std::uint32_t blocks);
  void finish_block(std::uint32_t block);
  void number_points();

  AlignedArray<float> points_, boxes_, sums_, block_boxes_;
  AlignedArray<std::uint16_t> full_;
  AlignedArray<std::uint16_t> tile_rank_;  ///< [block][16] points of the block in the tiles before
  AlignedArray<std::uint32_t> counts_;
  AlignedArray<std::uint64_t> keys_, other_keys_;
  std::vector<std::uint32_t> order_;       ///< organized: block -> row-major position of its 16x16 pixels
  std::vector<std::uint64_t> first_rank_;  ///< [block + 1] points in the blocks before
  std::vector<std::uint32_t> rank_hint_;   ///< [rank / kRankStep] a block at or before the one that holds the rank
  std::uint32_t order_width_ = 0, order_height_ = 0;
  std::uint32_t blocks_ = 0;
  bool organized_ = false;
  std::size_t finite_ = 0;
  RobustBounds bounds_;
};

}  // namespace handhold
