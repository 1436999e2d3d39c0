// Places beside a part that a depth image shows to be empty.
#pragma once

#include <cmath>
#include <vector>

#include "reference/neighbours.h"

namespace handhold::reference {

/// A depth image (m, row-major; 0: unknown, infinity: nothing there).
struct Depths {
  int width = 0, height = 0;
  std::vector<float> value;
};

enum class Place { kNotFree, kFree, kBorder };

/// What the image says of a place (column * depth, row * depth, depth). kBorder: within `eps` px of a pixel's border,
/// or within `eps` m of where the answer changes, so that rounding decides.
inline Place look(const Depths& image, const Vector3d& place, double tolerance, double eps) {
  const double depth = place[2];
  if (std::abs(depth - 0.02) < eps) return Place::kBorder;
  if (!(depth > 0.02)) return Place::kNotFree;
  const double u = place[0] / depth + 0.5, v = place[1] / depth + 0.5;
  if (!(u >= -eps && v >= -eps && u < image.width + eps && v < image.height + eps)) return Place::kNotFree;
  if (std::abs(u - std::round(u)) < eps || std::abs(v - std::round(v)) < eps) return Place::kBorder;
  const double seen =
      image.value[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(u)];
  if (std::abs(seen - depth - tolerance) < eps) return Place::kBorder;
  return seen > depth + tolerance ? Place::kFree : Place::kNotFree;
}

}  // namespace handhold::reference
