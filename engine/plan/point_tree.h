// The points of a cloud under a tree of boxes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "aligned.h"
#include "kernels.h"
#include "tiles.h"

namespace handhold::plan {

/// The points of a TileStore, and boxes about its blocks, about groups of sixteen of them, which are neighbours along
/// the store's Z-order, and about regions of sixteen groups: a picture of 640 x 480 has five.
///
/// On an arm's path (collision_bench, within 15 mm) a whole query takes twice the time that Embree (NeighbourIndex)
/// takes to find the blocks at the ball about a body, before any of them is looked into; and Embree's ball does not
/// shrink, as the search for the nearest point needs.
class PointTree {
 public:
  /// Runs in the caller's TBB arena; reuses memory.
  void build(const CloudView& cloud);

  kernels::TileTree view() const {
    const kernels::Tiles tiles = tiles_.view();
    return {tiles.points, tiles.boxes, block_boxes_.data(), group_boxes_.data(), region_boxes_.data(), regions_};
  }
  std::size_t points() const { return tiles_.finite_points(); }
  /// The point of that number, as Kernels::nearest_to_body gives it (m, frame of the cloud).
  Vector3 point(std::int64_t number) const;

 private:
  TileStore tiles_;
  AlignedArray<float> block_boxes_, group_boxes_, region_boxes_;
  std::int32_t regions_ = 0;
};

}  // namespace handhold::plan
