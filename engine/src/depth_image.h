// What the sensor saw, as a depth image: which places are known to be empty.
//
// A point in space is free when the sensor saw something behind it, occupied when what it saw there lies at that depth,
// and unknown otherwise. Organized clouds are depth images already; only their projection has to be found. Others are
// drawn into a z-buffer from the viewpoint.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "budget.h"
#include "candidate.h"
#include "conditions.h"
#include "handhold/cloud.h"
#include "vec3.h"

namespace handhold {

using kernels::depth_noise;

/// A change of depth between neighbouring pixels beyond this is a step from one surface to another (m), where the
/// standard deviation of depth is `sigma` (m).
inline double depth_step(double sigma) {
  return 0.003 + 3 * sigma;
}

class DepthImage {
 public:
  enum class Seen : std::uint8_t { kFree, kUnknown, kOccupied };

  /// Position in the image, homogeneous: column = a / depth, row = b / depth. Linear in the point, so that sums of
  /// projected vectors are projections of sums.
  struct Projected {
    double a, b, depth;
    Projected operator+(const Projected& o) const { return {a + o.a, b + o.b, depth + o.depth}; }
    friend Projected operator*(double s, const Projected& p) { return {s * p.a, s * p.b, s * p.depth}; }
  };

  /// False when the cloud has no viewpoint or no points: nothing is known then.
  /// @throws Budget::Spent; it is empty or half done then
  bool build(const CloudView& cloud, const Conditions& conditions = {}, const Budget& budget = {});
  void clear() { depth_.clear(); }
  bool empty() const { return depth_.empty(); }

  Projected project(const Vector3& p) const { return project_direction(p - viewpoint_); }
  Projected project_direction(const Vector3& d) const {
    return {H_[0] * d[0] + H_[1] * d[1] + H_[2] * d[2], H_[3] * d[0] + H_[4] * d[1] + H_[5] * d[2],
            H_[6] * d[0] + H_[7] * d[1] + H_[8] * d[2]};
  }
  /// The point that is seen at (column, row) and depth (m).
  Vector3 unproject(double column, double row, double depth) const {
    const double u = depth * column, v = depth * row;
    return viewpoint_ + Vector3{inverse_[0] * u + inverse_[1] * v + inverse_[2] * depth,
                                inverse_[3] * u + inverse_[4] * v + inverse_[5] * depth,
                                inverse_[6] * u + inverse_[7] * v + inverse_[8] * depth};
  }
  /// Depth (m) of the pixel that [u, u + 1) x [v, v + 1) about the position is; 0: unknown or outside of the image.
  double depth_in(double u, double v) const {
    if (!(u >= 0 && v >= 0 && u < width_ && v < height_)) return 0;
    return static_cast<double>(
        depth_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)]);
  }
  /// Depths that differ by up to `tolerance` (m) count as the same.
  Seen look(const Projected& p, double tolerance) const {
    if (!(p.depth > 0.02)) return Seen::kUnknown;
    const double u = p.a / p.depth + 0.5, v = p.b / p.depth + 0.5;
    const double seen = depth_in(u, v);
    if (seen > p.depth + tolerance) return Seen::kFree;
    return seen > p.depth - tolerance ? Seen::kOccupied : Seen::kUnknown;
  }
  Seen look(const Vector3& p, double tolerance) const { return look(project(p), tolerance); }

  const Vector3& viewpoint() const { return viewpoint_; }
  /// Row-major pixels (m); 0: unknown, infinity: nothing within the sensor's range.
  const float* pixels() const { return depth_.data(); }
  int width() const { return width_; }
  int height() const { return height_; }
  /// Focal length (px): an object at depth z spans focal() * size / z pixels.
  double focal() const { return focal_; }

 private:
  bool fit_projection(const CloudView& cloud);
  void read_organized(const CloudView& cloud, const Budget& budget);
  void draw_unorganized(const CloudView& cloud, const Budget& budget);
  void fill_shadows(const Budget& budget);
  void fill_void(const Budget& budget);

  Vector3 viewpoint_{};
  std::array<double, 9> H_{};  ///< (column * depth, row * depth, depth) = H (p - viewpoint); third row of length 1
  std::array<double, 9> inverse_{};  ///< of H
  double focal_ = 0;
  int width_ = 0, height_ = 0;
  std::vector<float> depth_;  ///< m; 0: unknown, infinity: nothing within the sensor's range
  std::vector<float> filled_;
  /// Missing pixels side by side.
  struct Run {
    int row, begin, end;
    std::size_t region;  ///< another run of the same region, or itself; of the last one also holds:
    std::size_t pixels;  ///< of the region
    bool border;         ///< some of them are at the image's border
  };
  std::vector<Run> runs_;
  std::vector<std::size_t> used_;  ///< pixels that the projection is fitted to
  std::vector<Vector3> directions_;
  std::vector<double> distances_, us_, vs_;
  std::vector<char> hit_;
};

}  // namespace handhold
