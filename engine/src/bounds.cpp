#include "bounds.h"

#include <algorithm>
#include <cstddef>

namespace handhold {
namespace {

constexpr std::size_t kSubset = 2048;

}  // namespace

void RobustBounds::find(const CloudView& cloud) {
  // Every stride-th usable point; denser when most points are missing.
  const std::size_t n = cloud.size();
  // Odd, so that it does not walk down one column of an image.
  for (std::size_t stride = n / kSubset | 1;; stride = stride / 16 | 1) {
    subset_.clear();
    for (std::size_t i = 0; i < n; i += stride) {
      const float* p = cloud.point(i);
      if (usable(p)) subset_.insert(subset_.end(), p, p + 3);
    }
    if (stride == 1 || subset_.size() >= 3 * (kSubset / 16)) break;
  }
  const std::size_t count = subset_.size() / 3;
  if (count == 0) return;
  values_.resize(count);
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < count; ++i) values_[i] = subset_[3 * i + k];
    const std::size_t first = count / 50, last = count - 1 - first;
    std::nth_element(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(first), values_.end());
    low[k] = values_[first];
    std::nth_element(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(last), values_.end());
    high[k] = values_[last];
  }
}

float RobustBounds::extent() const {
  return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
}

kernels::MortonCells RobustBounds::cells() const {
  // Cells of 8 mm where they cover the cloud in 7 bits a coordinate; otherwise 11 bits and cells as large as it takes.
  const float covered = 1.25f * std::max(0.0f, extent());
  const bool small = covered <= 127 * 0.008f;
  kernels::MortonCells cells;
  cells.bits = small ? 7 : 11;
  cells.size = small ? 0.008f : std::max(0.004f, covered / 2047.0f);
  const float last = static_cast<float>((1 << cells.bits) - 1);
  for (int k = 0; k < 3; ++k) cells.origin[k] = 0.5f * (low[k] + high[k]) - 0.5f * cells.size * last;
  return cells;
}

}  // namespace handhold
