#include "point_tree.h"

#include <algorithm>

namespace handhold::plan {
namespace {

/// Sixteen boxes, all empty.
void clear(float* boxes) {
  std::fill(boxes, boxes + 48, kernels::kFar);
  std::fill(boxes + 48, boxes + 96, -kernels::kFar);
}

}  // namespace

void PointTree::build(const CloudView& cloud) {
  tiles_.build(cloud);
  const std::uint32_t blocks = tiles_.blocks(), tops = (blocks + 255) / 256;
  groups_ = static_cast<std::int32_t>(16 * tops);
  block_boxes_.require(std::size_t{96} * 16 * tops);
  group_boxes_.require(std::size_t{96} * tops);
  for (std::size_t top = 0; top < tops; ++top) {
    float* above = group_boxes_.data() + 96 * top;
    clear(above);
    for (std::size_t g = 0; g < 16; ++g) {
      float* boxes = block_boxes_.data() + 96 * (16 * top + g);
      clear(boxes);
      for (std::size_t b = 0; b < 16; ++b) {
        const std::size_t block = 16 * (16 * top + g) + b;
        if (block >= blocks) break;
        const float* box = tiles_.block_box(static_cast<std::uint32_t>(block));
        for (std::size_t k = 0; k < 3; ++k) {
          boxes[16 * k + b] = box[k], boxes[48 + 16 * k + b] = box[4 + k];
          above[16 * k + g] = std::min(above[16 * k + g], box[k]);
          above[48 + 16 * k + g] = std::max(above[48 + 16 * k + g], box[4 + k]);
        }
      }
    }
  }
}

Vector3 PointTree::point(std::int64_t number) const {
  const float* p = tiles_.view().points + 48 * (number / 16) + number % 16;
  return {static_cast<double>(p[0]), static_cast<double>(p[16]), static_cast<double>(p[32])};
}

}  // namespace handhold::plan
