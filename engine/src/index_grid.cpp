// A uniform grid over the blocks: the yardstick for the BVH.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "index.h"

namespace handhold {
namespace {

constexpr float kCell = 0.05f;           // m
constexpr std::int64_t kManyCells = 64;  // a block over more cells stands in a list of its own
constexpr std::int64_t kBias = 1 << 20;  // makes cell numbers of +-50 km positive; what lies beyond is clamped

std::int64_t cell(float x) {
  return static_cast<std::int64_t>(std::floor(std::clamp(x / kCell, -1.0e6f, 1.0e6f))) + kBias;
}
std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::uint64_t>(z << 42 | y << 21 | x);
}

class GridIndex final : public NeighbourIndex {
 public:
  void build(const TileStore& tiles) override {
    entries_.clear();
    large_.clear();
    for (int k = 0; k < 3; ++k) low_[k] = 2 * kBias, high_[k] = -1;
    for (std::uint32_t b = 0; b < tiles.blocks(); ++b) {
      if (tiles.block_empty(b)) continue;
      const float* box = tiles.block_box(b);
      std::int64_t a[3], z[3], n = 1;
      for (int k = 0; k < 3; ++k) a[k] = cell(box[k]), z[k] = cell(box[4 + k]), n *= z[k] - a[k] + 1;
      if (n > kManyCells) {
        large_.push_back(b);
        continue;
      }
      for (int k = 0; k < 3; ++k) low_[k] = std::min(low_[k], a[k]), high_[k] = std::max(high_[k], z[k]);
      for (std::int64_t w = a[2]; w <= z[2]; ++w)
        for (std::int64_t v = a[1]; v <= z[1]; ++v)
          for (std::int64_t u = a[0]; u <= z[0]; ++u) entries_.emplace_back(key(u, v, w), b);
    }
    std::sort(entries_.begin(), entries_.end());
  }

  void query(const float* centre, float radius, BlockSet& found) const override {
    for (const std::uint32_t b : large_) found.insert(b);
    std::int64_t a[3], z[3];
    for (int k = 0; k < 3; ++k) {
      a[k] = std::max(cell(centre[k] - radius), low_[k]);
      z[k] = std::min(cell(centre[k] + radius), high_[k]);
      if (a[k] > z[k]) return;
    }
    if ((z[1] - a[1] + 1) * (z[2] - a[2] + 1) > static_cast<std::int64_t>(entries_.size())) {
      for (const auto& [k, b] : entries_) found.insert(b);
      return;
    }
    // Cells along x are neighbours in the sorted list.
    for (std::int64_t w = a[2]; w <= z[2]; ++w) {
      for (std::int64_t v = a[1]; v <= z[1]; ++v) {
        const std::uint64_t last = key(z[0], v, w);
        auto it = std::lower_bound(entries_.begin(), entries_.end(), std::pair(key(a[0], v, w), std::uint32_t{0}));
        for (; it != entries_.end() && it->first <= last; ++it) found.insert(it->second);
      }
    }
  }

 private:
  std::vector<std::pair<std::uint64_t, std::uint32_t>> entries_;  ///< (cell, block), sorted
  std::vector<std::uint32_t> large_;
  std::int64_t low_[3] = {}, high_[3] = {};
};

}  // namespace

std::unique_ptr<NeighbourIndex> make_grid_index() {
  return std::make_unique<GridIndex>();
}

}  // namespace handhold
