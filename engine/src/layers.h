// A cloud at several densities: balls that hold thousands of points are fitted to some hundreds of them.
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "handhold/cloud.h"
#include "handhold/options.h"
#include "index.h"
#include "tiles.h"

namespace handhold {

/// Points and their index.
struct Layer {
  const TileStore* tiles = nullptr;
  const NeighbourIndex* index = nullptr;
};

/// The full cloud, a quarter and a sixteenth of its points. Reused from frame to frame.
class Layers {
 public:
  static constexpr std::size_t kMost = 3;

  explicit Layers(IndexKind kind) {
    for (Thinned& t : thinned_) t.index = make_index(kind);
  }
  /// Only the full cloud, which outlives this.
  void take(const TileStore& tiles, const NeighbourIndex& index) {
    full_ = {&tiles, &index};
    size_ = 1;
  }
  /// Adds the thinned ones. `cloud`: what the full one was built from.
  void thin(const CloudView& cloud, const Budget& budget = {}) {
    for (; size_ < kMost; ++size_) {
      Thinned& t = thinned_[size_ - 1];
      t.tiles.build_thinned(cloud, *full_.tiles, 1u << size_, budget);
      // Points that are missing in a regular pattern may be those that a thinned image takes.
      if (2 * t.tiles.finite_points() << 2 * size_ < full_.tiles->finite_points()) break;
      budget.check();
      t.index->build(t.tiles);
    }
  }
  /// Layer i holds one of 4^i points.
  std::size_t size() const { return size_; }
  Layer operator[](std::size_t i) const {
    return i == 0 ? full_ : Layer{&thinned_[i - 1].tiles, thinned_[i - 1].index.get()};
  }

 private:
  struct Thinned {
    TileStore tiles;
    std::unique_ptr<NeighbourIndex> index;
  };
  Layer full_;
  std::array<Thinned, kMost - 1> thinned_;
  std::size_t size_ = 0;
};

}  // namespace handhold
