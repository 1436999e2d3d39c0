// A cloud as short as a page can have it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "handhold/cloud.h"

namespace handhold {

/// Points as whole numbers: x = lower + q / 65535 * size.
struct PageCloud {
  Vector3 lower = {0, 0, 0}, size = {0, 0, 0};  ///< m; the box of all points shown
  std::size_t points = 0;                       ///< shown
  std::size_t far = 0;                          ///< left out: they stand alone, far from the others
  std::size_t step = 1;                         ///< every step-th finite point is shown
  std::string positions;                        ///< 3 numbers of 16 bits a point, the low byte first
  std::string colors;                           ///< red, green, blue of each point; empty: none

  /// Appends the three numbers of a point, brought into the box.
  void append(const Vector3& point, std::string& numbers) const;
};

PageCloud page_cloud(const CloudView& cloud, const std::vector<std::uint32_t>& rgb);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace handhold
