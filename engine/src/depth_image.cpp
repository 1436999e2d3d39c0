#include "depth_image.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace handhold {
namespace {

constexpr float kVoid = std::numeric_limits<float>::infinity();
/// Distance between projector and camera of the common sensors (m): how wide their shadows can be.
constexpr double kProjectorBaseline = 0.075;
/// Runs of missing pixels that edges and noise leave (px).
constexpr double kEdgePixels = 8;
constexpr int kColumnPixels = 4;
/// Width of the frame about a cloud that is no image (m, at its median distance).
constexpr double kMargin = 0.15;
/// Work between two looks at the clock: some 50 us.
constexpr std::size_t kPointsAtOnce = 16384;
constexpr int kRowsAtOnce = 32;
constexpr std::size_t kPack = 64;

bool usable(const float* p) {
  return std::fabs(p[0]) <= 1e6f && std::fabs(p[1]) <= 1e6f && std::fabs(p[2]) <= 1e6f;
}
Vector3 point(const float* p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

}  // namespace

bool DepthImage::build(const CloudView& cloud, const Conditions& conditions, const Budget& budget) {
  clear();
  if (!cloud.viewpoint || cloud.size() == 0) return false;
  viewpoint_ = *cloud.viewpoint;
  if (cloud.width >= 16 && cloud.height >= 16 && fit_projection(cloud)) {
    read_organized(cloud, budget);
  } else {
    draw_unorganized(cloud, budget);
  }
  if (empty()) return false;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(inverse_.data()) =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(H_.data()).inverse();
  if (conditions.fill_shadows) fill_shadows(budget);
  if (conditions.fill_void) fill_void(budget);
  return true;
}

/// The homography between the directions of an organized cloud's points and their pixels, by linear least squares
/// (direct linear transformation). It holds in any frame of the cloud, rotated or not.
bool DepthImage::fit_projection(const CloudView& cloud) {
  width_ = static_cast<int>(cloud.width), height_ = static_cast<int>(cloud.height);
  const double half_width = 0.5 * width_, half_height = 0.5 * height_;
  using Row = Eigen::Matrix<double, 9, 1>;
  Eigen::Matrix<double, 9, 9> A = Eigen::Matrix<double, 9, 9>::Zero();
  const std::size_t stride = cloud.size() / 4096 | 1;  // odd: not down one column
  std::vector<std::size_t>& used = used_;
  used.clear();
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    if (!usable(cloud.point(i))) continue;
    const Vector3 d = point(cloud.point(i)) - viewpoint_;
    const double length = norm(d);
    if (!(length > 1e-3)) continue;
    const double u = (static_cast<double>(i % cloud.width) - half_width) / half_width;
    const double v = (static_cast<double>(i / cloud.width) - half_height) / half_height;
    const double x = d[0] / length, y = d[1] / length, z = d[2] / length;
    Row a, b;
    a << x, y, z, 0, 0, 0, -u * x, -u * y, -u * z;
    b << 0, 0, 0, x, y, z, -v * x, -v * y, -v * z;
    A += a * a.transpose() + b * b.transpose();
    used.push_back(i);
  }
  if (used.size() < 50) return false;
  const Row h = Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>>(A).eigenvectors().col(0);
  // Back to pixels.
  for (std::size_t k = 0; k < 3; ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    H_[k] = half_width * (h[at] + h[6 + at]);
    H_[3 + k] = half_height * (h[3 + at] + h[6 + at]);
    H_[6 + k] = h[6 + at];
  }
  const double length = std::sqrt(H_[6] * H_[6] + H_[7] * H_[7] + H_[8] * H_[8]);
  if (!(length > 0)) return false;
  const Projected one = project(point(cloud.point(used.front())));
  const double scale = one.depth < 0 ? -1 / length : 1 / length;
  for (double& value : H_) value *= scale;
  focal_ = norm(Vector3{H_[0], H_[1], H_[2]} -
                (H_[0] * H_[6] + H_[1] * H_[7] + H_[2] * H_[8]) * Vector3{H_[6], H_[7], H_[8]});
  // A cloud that is an image in name only does not fit.
  std::size_t far = 0;
  for (const std::size_t i : used) {
    const Projected p = project(point(cloud.point(i)));
    const double du = p.a / p.depth - static_cast<double>(i % cloud.width);
    const double dv = p.b / p.depth - static_cast<double>(i / cloud.width);
    far += !(p.depth > 0 && du * du + dv * dv < 1.0);
  }
  return far * 20 <= used.size();
}

void DepthImage::read_organized(const CloudView& cloud, const Budget& budget) {
  depth_.resize(cloud.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cloud.size(), 16384), [&](const auto& range) {
    const auto h6 = static_cast<float>(H_[6]), h7 = static_cast<float>(H_[7]), h8 = static_cast<float>(H_[8]);
    const float vx = static_cast<float>(viewpoint_[0]), vy = static_cast<float>(viewpoint_[1]),
                vz = static_cast<float>(viewpoint_[2]);
    // Coordinates side by side first: the compiler takes several points at a time then.
    float x[kPack], y[kPack], z[kPack];
    for (std::size_t i = range.begin(); i < range.end();) {
      if (i % kPointsAtOnce == 0 && budget.spent()) return;
      const std::size_t n = std::min(kPack, range.end() - i);
      for (std::size_t k = 0; k < n; ++k) {
        const float* p = cloud.point(i + k);
        x[k] = p[0], y[k] = p[1], z[k] = p[2];
      }
      float* __restrict out = depth_.data() + i;
      for (std::size_t k = 0; k < n; ++k) {
        const float depth = h6 * (x[k] - vx) + h7 * (y[k] - vy) + h8 * (z[k] - vz);
        out[k] = (depth > 0) & (depth < 1e6f) ? depth : 0.0f;  // false for NaN
      }
      i += n;
    }
  });
  budget.check();
}

/// A z-buffer whose pixels are as large as it takes for most of them to get a point.
void DepthImage::draw_unorganized(const CloudView& cloud, const Budget& budget) {
  Vector3 forward{};
  std::vector<Vector3>& directions = directions_;
  std::vector<double>& distances = distances_;
  directions.clear(), distances.clear();
  const std::size_t stride = cloud.size() / 8192 | 1;
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    if (!usable(cloud.point(i))) continue;
    const Vector3 d = point(cloud.point(i)) - viewpoint_;
    if (!(norm(d) > 1e-3)) continue;
    directions.push_back(normalized(d));
    distances.push_back(norm(d));
    forward = forward + directions.back();
  }
  if (directions.size() < 10 || !(norm(forward) > 1e-6)) return;
  forward = normalized(forward);
  const Vector3 right = any_perpendicular(forward), down = cross(forward, right);
  // Extent of the view: all but the outermost directions.
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2),
                   distances.end());
  std::vector<double>&us = us_, &vs = vs_;
  us.clear(), vs.clear();
  for (const Vector3& d : directions) {
    const double z = dot(d, forward);
    if (z < 0.17) continue;  // beyond 80 degrees
    us.push_back(dot(d, right) / z);
    vs.push_back(dot(d, down) / z);
  }
  if (us.size() < 10) return;
  const auto [u_low, u_high] = std::minmax_element(us.begin(), us.end());
  const auto [v_low, v_high] = std::minmax_element(vs.begin(), vs.end());
  // With a margin, so that what stands at the border of the cloud has something beside it: nothing.
  const double margin = kMargin / distances[distances.size() / 2];
  const double u0 = *u_low - margin, v0 = *v_low - margin;
  const double du = *u_high - u0 + margin, dv = *v_high - v0 + margin;
  // Share of the view that holds points, on a coarse grid.
  constexpr int kGrid = 48;
  std::vector<char>& hit = hit_;
  hit.assign(kGrid * kGrid, 0);
  for (std::size_t i = 0; i < us.size(); ++i) {
    const int a = std::min(kGrid - 1, static_cast<int>((us[i] - u0) / du * kGrid));
    const int b = std::min(kGrid - 1, static_cast<int>((vs[i] - v0) / dv * kGrid));
    hit[static_cast<std::size_t>(b * kGrid + a)] = 1;
  }
  const double share = static_cast<double>(std::count(hit.begin(), hit.end(), 1)) / (kGrid * kGrid);
  const double points = static_cast<double>(us.size()) * static_cast<double>(stride);
  const double pixel = std::max(std::sqrt(2.0 * share * du * dv / points), std::max(du, dv) / 2048);
  width_ = static_cast<int>(du / pixel) + 1, height_ = static_cast<int>(dv / pixel) + 1;
  focal_ = 1 / pixel;
  for (std::size_t k = 0; k < 3; ++k) {
    H_[k] = (right[k] - u0 * forward[k]) / pixel;
    H_[3 + k] = (down[k] - v0 * forward[k]) / pixel;
    H_[6 + k] = forward[k];
  }
  depth_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0.0f);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (i % kPointsAtOnce == 0) budget.check();
    if (!usable(cloud.point(i))) continue;
    const Projected p = project(point(cloud.point(i)));
    const double u = p.a / p.depth + 0.5, v = p.b / p.depth + 0.5;
    if (!(p.depth > 0.02 && u >= 0 && v >= 0 && u < width_ && v < height_)) continue;
    float& z = depth_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)];
    const auto depth = static_cast<float>(p.depth);
    if (z == 0.0f || depth < z) z = depth;
  }
}

/// Missing pixels between two measured ones of a row get the farther depth when the run is no wider than the
/// projector's shadow can be: what hides the projector's light there is the nearer surface's edge, and the space in
/// front of the farther one was seen. Short runs in a column, too.
void DepthImage::fill_shadows(const Budget& budget) {
  filled_ = depth_;
  const auto width = static_cast<std::size_t>(width_);
  tbb::parallel_for(tbb::blocked_range<int>(0, height_, 16), [&](const auto& range) {
    for (int row = range.begin(); row < range.end(); ++row) {
      if (row % kRowsAtOnce == 0 && budget.spent()) return;
      const float* from = depth_.data() + static_cast<std::size_t>(row) * width;
      float* to = filled_.data() + static_cast<std::size_t>(row) * width;
      for (int x = 0; x < width_;) {
        if (from[x] > 0) {
          ++x;
          continue;
        }
        const int first = x;
        while (x < width_ && !(from[x] > 0)) ++x;
        if (first == 0 || x == width_) continue;
        const float near = std::min(from[first - 1], from[x]), far = std::max(from[first - 1], from[x]);
        const double shadow =
            focal_ * kProjectorBaseline * (1 / static_cast<double>(near) - 1 / static_cast<double>(far));
        if (x - first <= shadow + kEdgePixels) std::fill(to + first, to + x, far);
      }
    }
  });
  budget.check();
  // A few rows at a time, so that the cache holds what a column needs.
  depth_ = filled_;
  tbb::parallel_for(tbb::blocked_range<int>(0, width_, 64), [&](const auto& range) {
    for (int y = 1; y + 1 < height_; ++y) {
      if (y % kRowsAtOnce == 0 && budget.spent()) return;
      for (int x = range.begin(); x < range.end(); ++x) {
        const std::size_t at = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
        if (filled_[at] > 0 || !(filled_[at - width] > 0)) continue;  // the first of a run
        int end = y;
        while (end < height_ && end - y <= kColumnPixels &&
               !(filled_[at + static_cast<std::size_t>(end - y) * width] > 0))
          ++end;
        if (end == height_ || end - y > kColumnPixels) continue;
        const float far = std::max(filled_[at - width], filled_[at + static_cast<std::size_t>(end - y) * width]);
        for (int k = y; k < end; ++k) depth_[at + static_cast<std::size_t>(k - y) * width] = far;
      }
    }
  });
  budget.check();
}

/// Large regions without measurements at the border are where the sensor looked past everything.
void DepthImage::fill_void(const Budget& budget) {
  const std::size_t enough = depth_.size() / 150;
  // Runs of missing pixels, row by row, joined to regions with those of the row above that they touch.
  runs_.clear();
  const auto region = [&](std::size_t i) {
    while (runs_[i].region != i) i = runs_[i].region = runs_[runs_[i].region].region;
    return i;
  };
  std::size_t above = 0, above_end = 0;
  for (int y = 0; y < height_; ++y) {
    if (y % kRowsAtOnce == 0) budget.check();
    const float* row = depth_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
    const std::size_t first = runs_.size();
    for (int x = 0; x < width_; ++x) {
      if (row[x] > 0) continue;
      const int begin = x;
      while (x < width_ && !(row[x] > 0)) ++x;
      const bool border = begin == 0 || x == width_ || y == 0 || y + 1 == height_;
      runs_.push_back({y, begin, x, runs_.size(), static_cast<std::size_t>(x - begin), border});
      for (; above < above_end && runs_[above].end <= begin; ++above) {
      }
      for (std::size_t i = above; i < above_end && runs_[i].begin < x; ++i) {
        const std::size_t a = region(i), b = region(runs_.size() - 1);
        if (a == b) continue;
        runs_[a].region = b, runs_[b].pixels += runs_[a].pixels, runs_[b].border |= runs_[a].border;
      }
    }
    above = first, above_end = runs_.size();
  }
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const Run& whole = runs_[region(i)];
    if (!whole.border || whole.pixels < enough) continue;
    float* row = depth_.data() + static_cast<std::size_t>(runs_[i].row) * static_cast<std::size_t>(width_);
    std::fill(row + runs_[i].begin, row + runs_[i].end, kVoid);
  }
}

}  // namespace handhold
