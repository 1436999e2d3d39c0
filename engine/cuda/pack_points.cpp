#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstring>

#include "cuda_frame.h"

namespace handhold {

void pack_points(const CloudView& cloud, float* xyz) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cloud.size(), 16384), [&](const auto& range) {
    float* to = xyz + 3 * range.begin();
    if (cloud.point_step == 3 * sizeof(float)) {
      std::memcpy(to, cloud.point(range.begin()), 3 * sizeof(float) * range.size());
      return;
    }
    for (std::size_t i = range.begin(); i < range.end(); ++i, to += 3) {
      const float* p = cloud.point(i);
      to[0] = p[0], to[1] = p[1], to[2] = p[2];
    }
  });
}

}  // namespace handhold
