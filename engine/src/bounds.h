// Where nearly all points of a cloud are.
#pragma once

#include <cmath>
#include <vector>

#include "handhold/cloud.h"
#include "morton.h"

namespace handhold {

/// Whether a point counts. The kernels leave out what is beyond 1e6 m; false for NaN.
inline bool usable(const float* p) {
  return std::fabs(p[0]) <= 1e6f && std::fabs(p[1]) <= 1e6f && std::fabs(p[2]) <= 1e6f;
}

/// The 2nd and 98th percentile of each coordinate over a fixed subset of a cloud's points (m). A few stray points far
/// away do not move them.
class RobustBounds {
 public:
  /// Without a usable point nothing is changed.
  void find(const CloudView& cloud);
  float low[3] = {}, high[3] = {};
  /// Largest side of the box (m).
  float extent() const;
  /// Cells for the order of the points of an unorganized cloud.
  kernels::MortonCells cells() const;

 private:
  std::vector<float> subset_, values_;
};

}  // namespace handhold
