#include "cloud_filter.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels.h"
#include "vec3.h"

namespace handhold::plan {
namespace {

using Range = tbb::blocked_range<std::size_t>;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// Points that are compared with the robot together: neighbours of one row of an image, mostly.
constexpr std::size_t kRun = 64;
/// Rows that one thread does in a go.
constexpr std::size_t kBatchRows = 16;
/// What a kernel may read behind the last pixel.
constexpr std::size_t kBehind = 16;

bool is_finite(const float* p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

struct Box {
  Vector3 low = {1e30, 1e30, 1e30}, high = {-1e30, -1e30, -1e30};
  void add(const float* p) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], static_cast<double>(p[k])), high[k] = std::max(high[k], static_cast<double>(p[k]));
    }
  }
  double squared_distance(const Vector3& p) const {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const double out = std::max({low[k] - p[k], p[k] - high[k], 0.0});
      sum += out * out;
    }
    return sum;
  }
};

}  // namespace

CloudView CloudFilter::run(const CloudView& cloud, const std::vector<Core>& own, const CloudObstacleOptions& options) {
  // In a single column everything would be a speck; it is no picture.
  const bool specks = cloud.organized() && cloud.width > 1 && options.speck_neighbours > 0;
  if (!specks && own.empty()) return cloud;
  xyz_.resize(3 * cloud.size());
  specks ? leave_out_specks(cloud, options) : copy(cloud);
  if (!own.empty()) leave_out_own(own, options.own_margin);
  return {xyz_.data(), 12, cloud.width, cloud.height, cloud.viewpoint};
}

void CloudFilter::copy(const CloudView& cloud) {
  tbb::parallel_for(Range(0, cloud.size(), 8192), [&](const Range& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) std::copy_n(cloud.point(i), 3, xyz_.data() + 3 * i);
  });
}

void CloudFilter::leave_out_specks(const CloudView& cloud, const CloudObstacleOptions& options) {
  const std::size_t width = cloud.width, height = cloud.height, stride = width + 2, padded = (width + 15) / 16 * 16;
  for (std::vector<float>& c : coordinates_) c.resize(stride * (height + 2) + kBehind);
  tbb::parallel_for(Range(0, height + 2, 16), [&](const Range& range) {
    for (std::size_t row = range.begin(); row < range.end(); ++row) {
      for (std::size_t k = 0; k < 3; ++k) {
        float* out = coordinates_[k].data() + stride * row;
        out[0] = out[stride - 1] = kNan;
        if (row == 0 || row == height + 1) {
          std::fill(out, out + stride, kNan);
          continue;
        }
        for (std::size_t u = 0; u < width; ++u) out[u + 1] = cloud.point((row - 1) * width + u)[k];
      }
    }
  });
  const auto limit2 = static_cast<float>(options.speck_distance * options.speck_distance);
  const auto least = static_cast<float>(options.speck_neighbours);
  counts_.resize((height + kBatchRows - 1) / kBatchRows * padded);
  tbb::parallel_for(Range(0, counts_.size() / padded), [&](const Range& range) {
    for (std::size_t batch = range.begin(); batch < range.end(); ++batch) {
      float* near = counts_.data() + padded * batch;
      for (std::size_t v = kBatchRows * batch; v < std::min(height, kBatchRows * (batch + 1)); ++v) {
        const std::size_t first = stride * (v + 1) + 1;
        const float *x = coordinates_[0].data() + first, *y = coordinates_[1].data() + first;
        const float* z = coordinates_[2].data() + first;
        kernels::kernels().near_pixels(
            {x, y, z, static_cast<std::int32_t>(width), static_cast<std::int32_t>(stride), limit2}, near);
        float* out = xyz_.data() + 3 * width * v;
        for (std::size_t u = 0; u < width; ++u) {
          out[3 * u] = near[u] >= least ? x[u] : kNan;
          out[3 * u + 1] = y[u], out[3 * u + 2] = z[u];
        }
      }
    }
  });
}

void CloudFilter::leave_out_own(const std::vector<Core>& own, double margin) {
  const std::size_t points = xyz_.size() / 3;
  tbb::parallel_for(Range(0, (points + kRun - 1) / kRun, 64), [&](const Range& range) {
    for (std::size_t run = range.begin(); run < range.end(); ++run) {
      float *first = xyz_.data() + 3 * kRun * run, *last = xyz_.data() + 3 * std::min(points, kRun * (run + 1));
      Box box;
      for (const float* p = first; p != last; p += 3) {
        if (is_finite(p)) box.add(p);
      }
      for (const Core& body : own) {
        const double most = reach(body) + margin, most2 = most * most;
        const Vector3& centre = body.T_base_core.t;
        if (box.squared_distance(centre) > most2) continue;
        for (float* p = first; p != last; p += 3) {
          const Vector3 point = {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
          const Vector3 away = point - centre;
          if (dot(away, away) <= most2 && distance(body, point) <= margin) p[0] = kNan;
        }
      }
    }
  });
}

}  // namespace handhold::plan
