#include "index.h"

#include <algorithm>
#include <cmath>

namespace handhold {

std::unique_ptr<NeighbourIndex> make_index(IndexKind kind) {
  return kind == IndexKind::kGrid ? make_grid_index() : make_embree_index();
}

void CandidateList::fill(const TileStore& tiles, const NeighbourIndex& index, const float* low, const float* high,
                         float radius) {
  if (found_.words() != (tiles.blocks() + 63) / 64) found_.resize(tiles.blocks());
  float centre[3], half2 = 0;
  for (int k = 0; k < 3; ++k) {
    centre[k] = 0.5f * (low[k] + high[k]);
    const float half = std::max(high[k] - centre[k], centre[k] - low[k]);
    half2 += half * half;
  }
  index.query(centre, (std::sqrt(half2) + radius) * 1.00001f, found_);
  near_.clear();
  near_.reserve(tiles.blocks());  // nothing may throw while the set is read out
  const float limit2 = radius * radius * 1.00001f;
  found_.drain([&](std::uint32_t block) {
    const float* box = tiles.block_box(block);
    float d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const float d = std::max({box[k] - high[k], low[k] - box[4 + k], 0.0f});
      d2 += d * d;
    }
    if (d2 <= limit2) near_.push_back(block);
  });
  padded_ = static_cast<std::int32_t>((near_.size() + 15) / 16 * 16);
  const auto n = static_cast<std::size_t>(padded_);
  if (n > stride_) {
    stride_ = std::max<std::size_t>(2 * n, 256);
    boxes_.require(6 * stride_);
    block_.require(stride_);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const bool there = i < near_.size();
    block_[i] = there ? near_[i] : 0;
    const float* box = there ? tiles.block_box(near_[i]) : nullptr;
    for (std::size_t k = 0; k < 3; ++k) {
      boxes_[k * stride_ + i] = there ? box[k] : kernels::kFar;
      boxes_[(3 + k) * stride_ + i] = there ? box[4 + k] : -kernels::kFar;
    }
  }
}

}  // namespace handhold
