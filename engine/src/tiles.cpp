#include "tiles.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "morton.h"
#include "radix_sort.h"
#include "ranks.h"

namespace handhold {
namespace {

constexpr std::size_t kRankStep = 256;
/// Work between two looks at the clock: some 50 us.
constexpr std::uint32_t kBlocksAtOnce = 16;
constexpr std::size_t kPointsAtOnce = 8192;

typedef float Four __attribute__((vector_size(16), aligned(4), may_alias));

/// Four tightly packed points, x0 y0 z0 x1 | y1 z1 x2 y2 | z2 x3 y3 z3, to their coordinates.
inline void load_packed(const float* p, float* out) {
  const Four a = *reinterpret_cast<const Four*>(p), b = *reinterpret_cast<const Four*>(p + 4);
  const Four c = *reinterpret_cast<const Four*>(p + 8);
  const Four xy = __builtin_shufflevector(b, c, 2, 3, 5, 6);  // x2 y2 x3 y3
  const Four yz = __builtin_shufflevector(a, b, 1, 2, 4, 5);  // y0 z0 y1 z1
  *reinterpret_cast<Four*>(out) = __builtin_shufflevector(a, xy, 0, 3, 4, 6);
  *reinterpret_cast<Four*>(out + 16) = __builtin_shufflevector(yz, xy, 0, 2, 5, 7);
  *reinterpret_cast<Four*>(out + 32) = __builtin_shufflevector(yz, c, 1, 3, 4, 7);
}

/// Number of every `step`-th of n.
std::uint32_t thinned(std::uint32_t n, std::uint32_t step) {
  return (n + step - 1) / step;
}

/// Copies 16x16 pixels, cut off at the image's border, into 16 tiles of 4x4 in Z-order. (u0, v0): the first one, in an
/// image of every `every`-th row and column.
void load_block(const CloudView& cloud, std::uint32_t every, std::uint32_t u0, std::uint32_t v0, float* tiles) {
  const std::size_t step = every * (cloud.point_step / sizeof(float));
  const std::uint32_t width = thinned(cloud.width, every), height = thinned(cloud.height, every);
  const auto pixel = [&](std::uint32_t u, std::uint32_t v) {
    return cloud.point(static_cast<std::size_t>(v * every) * cloud.width + u * every);
  };
  for (std::uint32_t t = 0; t < kernels::kBlockTiles; ++t) {
    const std::uint32_t u = u0 + 4 * ((t & 1) | (t >> 1 & 2)), v = v0 + 4 * ((t >> 1 & 1) | (t >> 2 & 2));
    float* out = tiles + 48 * t;
    if (u + 4 <= width && v + 4 <= height) {
      for (std::uint32_t j = 0; j < 4; ++j) {
        const float* p = pixel(u, v + j);
        if (step == 3) {
          load_packed(p, out + 4 * j);
          continue;
        }
        for (std::uint32_t i = 0; i < 4; ++i, p += step) {
          out[4 * j + i] = p[0];
          out[16 + 4 * j + i] = p[1];
          out[32 + 4 * j + i] = p[2];
        }
      }
      continue;
    }
    for (std::uint32_t j = 0; j < 4; ++j) {
      for (std::uint32_t i = 0; i < 4; ++i) {
        const bool there = u + i < width && v + j < height;
        const float* p = there ? pixel(u + i, v + j) : nullptr;
        for (int k = 0; k < 3; ++k) out[16 * k + 4 * j + i] = there ? p[k] : kernels::kFar;
      }
    }
  }
}

}  // namespace

void order_blocks(std::uint32_t across, std::uint32_t down, std::uint32_t* order) {
  const std::uint32_t n = across * down;
  for (std::uint32_t i = 0; i < n; ++i) order[i] = i;
  std::sort(order, order + n, [across](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t ma = morton2(a % across, a / across), mb = morton2(b % across, b / across);
    return ma != mb ? ma < mb : a < b;
  });
}

void TileStore::allocate(std::uint32_t blocks) {
  blocks_ = blocks;
  const std::size_t n = std::max<std::uint32_t>(blocks, 1);
  points_.require(n * 768);
  boxes_.require(n * 96);
  sums_.require(n * 160);
  full_.require(n);
  tile_rank_.require(n * 16);
  counts_.require(n);
  block_boxes_.require(n * 8);
}

void TileStore::finish_block(std::uint32_t block) {
  const std::size_t b = block;
  float* box = boxes_.data() + 96 * b;
  counts_[b] = static_cast<std::uint32_t>(
      kernels::kernels().finish_block(points_.data() + 768 * b, box, &full_[b], sums_.data() + 160 * b));
  std::uint16_t before = 0;
  for (std::size_t t = 0; t < kernels::kBlockTiles; ++t) {
    tile_rank_[16 * b + t] = before;
    before = static_cast<std::uint16_t>(before + static_cast<std::uint16_t>(sums_[160 * b + t]));
  }
  float* whole = block_boxes_.data() + 8 * b;
  for (int k = 0; k < 3; ++k) {
    float low = box[16 * k], high = box[48 + 16 * k];
    for (int t = 1; t < kernels::kBlockTiles; ++t) {
      low = std::min(low, box[16 * k + t]);
      high = std::max(high, box[48 + 16 * k + t]);
    }
    whole[k] = low;
    whole[4 + k] = high;
  }
  whole[3] = whole[7] = 0;
}

void TileStore::build_organized(const CloudView& cloud, std::uint32_t step, const Budget& budget) {
  const std::uint32_t across = (thinned(cloud.width, step) + 15) / 16, down = (thinned(cloud.height, step) + 15) / 16;
  if (order_width_ != across || order_height_ != down) {
    order_.resize(static_cast<std::size_t>(across) * down);
    order_blocks(across, down, order_.data());
    order_width_ = across, order_height_ = down;
  }
  allocate(static_cast<std::uint32_t>(order_.size()));
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, blocks_, 32), [&](const auto& range) {
    for (std::uint32_t b = range.begin(); b < range.end(); ++b) {
      if (b % kBlocksAtOnce == 0 && budget.spent()) return;
      load_block(cloud, step, order_[b] % across * 16, order_[b] / across * 16,
                 points_.data() + 768 * static_cast<std::size_t>(b));
      finish_block(b);
    }
  });
  budget.check();
}

void TileStore::build_unorganized(const CloudView& cloud, const Budget& budget) {
  const kernels::MortonCells cells = bounds_.cells();
  const std::size_t n = cloud.size();
  keys_.require(n);
  other_keys_.require(n);
  std::size_t finite = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (i % kPointsAtOnce == 0) budget.check();
    const float* p = cloud.point(i);
    if (!usable(p)) continue;
    // 33 bits of key, 31 of index: sizes are checked when the cloud comes in.
    keys_[finite++] = cells.number(p) << 31 | i;
  }
  const std::uint64_t* sorted = radix_sort(keys_.data(), other_keys_.data(), finite, 31, 3 * cells.bits);
  allocate(static_cast<std::uint32_t>((finite + 255) / 256));
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, blocks_, 32), [&](const auto& range) {
    for (std::uint32_t b = range.begin(); b < range.end(); ++b) {
      if (b % kBlocksAtOnce == 0 && budget.spent()) return;
      float* block = points_.data() + 768 * static_cast<std::size_t>(b);
      for (std::size_t j = 0; j < 256; ++j) {
        const std::size_t at = 256 * static_cast<std::size_t>(b) + j;
        float* out = block + 48 * (j / 16) + j % 16;
        if (at < finite) {
          const float* p = cloud.point(sorted[at] & 0x7fffffff);
          out[0] = p[0], out[16] = p[1], out[32] = p[2];
        } else {
          out[0] = out[16] = out[32] = kernels::kFar;
        }
      }
      finish_block(b);
    }
  });
  budget.check();
}

void TileStore::build(const CloudView& cloud, const Budget& budget) {
  bounds_.find(cloud);
  organized_ = is_image(cloud);
  if (organized_) {
    build_organized(cloud, 1, budget);
  } else {
    build_unorganized(cloud, budget);
  }
  number_points();
}

void TileStore::build_thinned(const CloudView& cloud, const TileStore& full, std::uint32_t step, const Budget& budget) {
  std::copy(full.bounds_.low, full.bounds_.low + 3, bounds_.low);
  std::copy(full.bounds_.high, full.bounds_.high + 3, bounds_.high);
  organized_ = full.organized_;
  if (organized_) {
    build_organized(cloud, step, budget);
    number_points();
    return;
  }
  const std::size_t area = static_cast<std::size_t>(step) * step, finite = (full.finite_ + area - 1) / area;
  allocate(static_cast<std::uint32_t>((finite + 255) / 256));
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, blocks_, 32), [&](const auto& range) {
    for (std::uint32_t b = range.begin(); b < range.end(); ++b) {
      if (b % kBlocksAtOnce == 0 && budget.spent()) return;
      float* block = points_.data() + 768 * static_cast<std::size_t>(b);
      for (std::size_t j = 0; j < 256; ++j) {
        const std::size_t at = 256 * static_cast<std::size_t>(b) + j, from = area * at;
        float* out = block + 48 * (j / 16) + j % 16;
        // All but the last one of these blocks are full.
        const float* p = at < finite ? full.points_.data() + 48 * (from / 16) + from % 16 : nullptr;
        for (std::size_t k = 0; k < 3; ++k) out[16 * k] = p ? p[16 * k] : kernels::kFar;
      }
      finish_block(b);
    }
  });
  budget.check();
  number_points();
}

/// What finite_point needs.
void TileStore::number_points() {
  first_rank_.resize(blocks_ + 1);
  first_rank_[0] = 0;
  for (std::uint32_t b = 0; b < blocks_; ++b) first_rank_[b + 1] = first_rank_[b] + counts_[b];
  finite_ = static_cast<std::size_t>(first_rank_[blocks_]);
  rank_hint_.resize(finite_ / kRankStep + 1);
  std::uint32_t b = 0;
  for (std::size_t i = 0; i < rank_hint_.size(); ++i) {
    while (b + 1 < blocks_ && first_rank_[b + 1] <= i * kRankStep) ++b;
    rank_hint_[i] = b;
  }
}

void TileStore::finite_point(std::size_t rank, float* xyz) const {
  std::uint32_t b = rank_hint_[rank / kRankStep];
  while (first_rank_[b + 1] <= rank) ++b;
  kernels::point_of_rank(points_.data() + 768 * static_cast<std::size_t>(b),
                         tile_rank_.data() + 16 * static_cast<std::size_t>(b), full_[b],
                         static_cast<std::uint32_t>(rank - first_rank_[b]), xyz);
}

}  // namespace handhold
