// Which blocks of points lie near a place.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "aligned.h"
#include "handhold/options.h"
#include "kernels.h"
#include "tiles.h"

namespace handhold {

/// A set of block numbers, read out in ascending order: what an index finds does not depend on how it searches, and the
/// sums that follow add up in one order for every index and every number of threads.
class BlockSet {
 public:
  void resize(std::uint32_t blocks) {
    words_.assign((blocks + 63) / 64, 0);
    first_ = words_.size(), last_ = 0;
  }
  void insert(std::uint32_t block) {
    const std::size_t w = block / 64;
    words_[w] |= std::uint64_t{1} << (block % 64);
    if (w < first_) first_ = w;
    if (w >= last_) last_ = w + 1;
  }
  /// Calls visit(block) for each in ascending order, and empties the set.
  template <class Visit>
  void drain(Visit&& visit) {
    for (std::size_t w = first_; w < last_; ++w) {
      for (std::uint64_t rest = words_[w]; rest; rest &= rest - 1) {
        visit(static_cast<std::uint32_t>(64 * w + static_cast<std::size_t>(__builtin_ctzll(rest))));
      }
      words_[w] = 0;
    }
    first_ = words_.size(), last_ = 0;
  }
  std::size_t words() const { return words_.size(); }

 private:
  std::vector<std::uint64_t> words_;
  std::size_t first_ = 0, last_ = 0;
};

/// An index over the blocks of a TileStore. Queries may run on many threads at once; building may not overlap them.
class NeighbourIndex {
 public:
  virtual ~NeighbourIndex() = default;
  /// Indexes the non-empty blocks; the store must outlive the queries.
  virtual void build(const TileStore& tiles) = 0;
  /// Adds every block whose box touches the ball (m), and perhaps some that do not.
  virtual void query(const float* centre, float radius, BlockSet& found) const = 0;
};

/// Embree BVH with one user primitive a block.
std::unique_ptr<NeighbourIndex> make_embree_index();
/// Uniform grid of 50 mm cells.
std::unique_ptr<NeighbourIndex> make_grid_index();
std::unique_ptr<NeighbourIndex> make_index(IndexKind kind);

/// The blocks near a group of places, as the kernels want them. One per thread, reused.
class CandidateList {
 public:
  /// Fetches the blocks whose box lies within `radius` of the box [low, high] (m). The list is the same for every
  /// index.
  void fill(const TileStore& tiles, const NeighbourIndex& index, const float* low, const float* high, float radius);
  kernels::Candidates view() const {
    kernels::Candidates c{};
    for (int k = 0; k < 6; ++k) c.boxes[k] = boxes_.data() + static_cast<std::size_t>(k) * stride_;
    c.block = block_.data();
    c.padded = padded_;
    return c;
  }

 private:
  BlockSet found_;
  std::vector<std::uint32_t> near_;
  AlignedArray<float> boxes_;
  AlignedArray<std::uint32_t> block_;
  std::size_t stride_ = 0;
  std::int32_t padded_ = 0;
};

}  // namespace handhold
