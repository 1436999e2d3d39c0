// Which point of a block has a given rank among its finite points.
#pragma once

#include <cstddef>
#include <cstdint>

#include "candidate.h"
#include "kernels.h"

namespace handhold::kernels {

/// points, before and full: of the block; before[t]: finite points in the tiles before tile t. xyz: m
HANDHOLD_SHARED void point_of_rank(const float* points, const std::uint16_t* before, std::uint16_t full,
                                   std::uint32_t rank, float* xyz) {
  // The last tile that starts at or before the rank; empty ones share their successor's start.
  std::uint32_t t = 0;
  for (std::uint32_t i = 1; i < kBlockTiles; ++i) t += before[i] <= rank;
  std::uint32_t left = rank - before[t];
  const float* tile = points + 48 * static_cast<std::size_t>(t);
  std::uint32_t i = left;
  if (!(full >> t & 1)) {
    for (i = 0; i + 1 < kTilePoints; ++i) {
      if (tile[i] < kFar && left-- == 0) break;
    }
  }
  xyz[0] = tile[i], xyz[1] = tile[16 + i], xyz[2] = tile[32 + i];
}

}  // namespace handhold::kernels
