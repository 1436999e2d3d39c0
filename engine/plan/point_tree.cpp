#include "point_tree.h"

#include <algorithm>

namespace handhold::plan {
namespace {

constexpr std::size_t kRecord = 96;  // floats of sixteen boxes

/// Fills the boxes of one level, sixteen to a record: box(i) gives the low and the high corner of the i-th of `count`.
/// The records are as many as it takes. Returns their number.
template <class BoxOf>
std::size_t fill_level(AlignedArray<float>& level, std::size_t count, BoxOf&& box) {
  const std::size_t records = (count + 15) / 16;
  level.require(kRecord * records);
  for (std::size_t i = 0; i < 16 * records; ++i) {
    float corners[6] = {kernels::kFar, kernels::kFar, kernels::kFar, -kernels::kFar, -kernels::kFar, -kernels::kFar};
    if (i < count) box(i, corners);
    for (std::size_t k = 0; k < 6; ++k) level[kRecord * (i / 16) + 16 * k + i % 16] = corners[k];
  }
  return records;
}

/// The box about sixteen.
void box_about(const float* record, float* corners) {
  for (std::size_t k = 0; k < 3; ++k) {
    corners[k] = *std::min_element(record + 16 * k, record + 16 * k + 16);
    corners[3 + k] = *std::max_element(record + 48 + 16 * k, record + 48 + 16 * k + 16);
  }
}

}  // namespace

void PointTree::build(const CloudView& cloud) {
  tiles_.build(cloud);
  const std::size_t groups = fill_level(block_boxes_, tiles_.blocks(), [&](std::size_t block, float* corners) {
    const float* box = tiles_.block_box(static_cast<std::uint32_t>(block));
    std::copy_n(box, 3, corners), std::copy_n(box + 4, 3, corners + 3);
  });
  const auto about = [](const AlignedArray<float>& level) {
    return [boxes = level.data()](std::size_t i, float* corners) { box_about(boxes + kRecord * i, corners); };
  };
  const std::size_t regions = fill_level(group_boxes_, groups, about(block_boxes_));
  regions_ = static_cast<std::int32_t>(16 * fill_level(region_boxes_, regions, about(group_boxes_)));
}

Vector3 PointTree::point(std::int64_t number) const {
  const float* p = tiles_.view().points + 48 * (number / 16) + number % 16;
  return {static_cast<double>(p[0]), static_cast<double>(p[16]), static_cast<double>(p[32])};
}

}  // namespace handhold::plan
