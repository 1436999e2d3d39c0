// The points of a cloud under a tree of boxes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "aligned.h"
#include "kernels.h"
#include "tiles.h"

namespace handhold::plan {

/// The points of a TileStore, and boxes about its blocks and about groups of sixteen of them, which are neighbours
/// along the store's Z-order. Some 75 groups hold a picture of 640 x 480.
///
/// Queries begin with all groups. Beginning with all blocks takes longer (collision_bench), and an index of balls
/// (NeighbourIndex) is too coarse for bodies that are long: the ball about a forearm holds most of a table.
class PointTree {
 public:
  /// Runs in the caller's TBB arena; reuses memory.
  void build(const CloudView& cloud);

  kernels::TileTree view() const {
    const kernels::Tiles tiles = tiles_.view();
    return {tiles.points, tiles.boxes, block_boxes_.data(), group_boxes_.data(), groups_};
  }
  std::size_t points() const { return tiles_.finite_points(); }
  /// The point of that number, as Kernels::nearest_to_body gives it (m, frame of the cloud).
  Vector3 point(std::int64_t number) const;

 private:
  TileStore tiles_;
  AlignedArray<float> block_boxes_, group_boxes_;
  std::int32_t groups_ = 0;
};

}  // namespace handhold::plan
