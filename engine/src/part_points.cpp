#include "part_points.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "kernels.h"

namespace handhold {
namespace {

constexpr std::size_t kMostPoints = 1000;
constexpr std::size_t kMostFitted = 300;
constexpr double kCosNormal = 0.6427876096865394;  ///< points whose normal is farther from radial are another surface's
constexpr double kNormalBall = 0.008;              ///< m
constexpr float kNormalShared = 0.004f;            ///< m; neighbouring pixels nearer than this share a normal
constexpr double kBehind = 0.3;       ///< of the distance from the axis: points farther behind it are another surface's
constexpr float kBoxSlack = 1.0001f;  ///< for the rounding of boxes

struct Row {
  float x, y, z;
};
Row row_of(const Vector3& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

// Loops on arrays that share no memory: the compiler takes several points at a time.

/// Components of points, relative to `from`, in a direction.
void components(const float* __restrict x, const float* __restrict y, const float* __restrict z, std::size_t n,
                Row from, Row along, float* __restrict out) {
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = along.x * (x[i] - from.x) + along.y * (y[i] - from.y) + along.z * (z[i] - from.z);
  }
}
void lengths(const float* __restrict a, const float* __restrict b, std::size_t n, float* __restrict out) {
  for (std::size_t i = 0; i < n; ++i) out[i] = std::sqrt(a[i] * a[i] + b[i] * b[i]);
}

/// A stretch of a line: what lies on and around the side that the sensor sees.
struct Line {
  Row point, axis, ahead;
  float low, high, most2;
};
/// Which points of a tile are near it.
void test_tile(const float* __restrict p, const Line& l, std::int32_t* __restrict in) {
  for (std::uint32_t k = 0; k < kernels::kTilePoints; ++k) {
    const float x = p[k] - l.point.x, y = p[16 + k] - l.point.y, z = p[32 + k] - l.point.z;
    const float height = l.axis.x * x + l.axis.y * y + l.axis.z * z;
    const float before = l.ahead.x * x + l.ahead.y * y + l.ahead.z * z;  // which is across the axis
    const float distance2 = x * x + y * y + z * z - height * height;
    const auto behind = static_cast<float>(kBehind * kBehind) * distance2;
    in[k] = (p[k] < kernels::kFar) & (height >= l.low) & (height <= l.high) & (distance2 <= l.most2) &
            ((before >= 0) | (before * before <= behind));
  }
}

}  // namespace

CylinderFrame PartPoints::frame(const Cylinder& c) const {
  const Vector3 to_sensor = image_->viewpoint() - c.point;
  CylinderFrame f;
  f.ahead = normalized(to_sensor - dot(to_sensor, c.axis) * c.axis, any_perpendicular(c.axis));
  f.side = cross(c.axis, f.ahead);
  return f;
}

void PartPoints::gather(const Cylinder& c, double low, double high, double sigma) {
  sigma_ = sigma;
  float box[6];
  const Vector3 a = c.point + low * c.axis, b = c.point + high * c.axis;
  for (std::size_t k = 0; k < 3; ++k) {
    box[k] = static_cast<float>(std::min(a[k], b[k])), box[3 + k] = static_cast<float>(std::max(a[k], b[k]));
  }
  const double most = 1.05 * c.radius + cylinder_band(c.radius, sigma_) + 0.006;
  const auto reach = static_cast<float>(most);
  near_.fill(*tiles_, *index_, box, box + 3, reach);
  around_.fill(*tiles_, *index_, box, box + 3, reach + kNormalShared + static_cast<float>(kNormalBall));
  const kernels::Tiles tiles = tiles_->view();
  const kernels::Candidates near = near_.view();
  const Vector3 ahead = frame(c).ahead;
  const Line line{row_of(c.point),         row_of(c.axis),           row_of(ahead),
                  static_cast<float>(low), static_cast<float>(high), static_cast<float>(most * most)};
  ids_.clear();
  for (std::size_t k = 0; k < 3; ++k) box[k] -= reach * kBoxSlack, box[3 + k] += reach * kBoxSlack;
  for (std::int32_t i = 0; i < near.padded; ++i) {
    if (near.boxes[0][i] >= kernels::kFar) continue;
    const float* boxes = tiles.boxes + static_cast<std::size_t>(near.block[i]) * 96;
    for (std::uint32_t t = 0; t < kernels::kBlockTiles; ++t) {
      bool outside = false;
      for (std::size_t k = 0; k < 3; ++k) outside |= boxes[16 * k + t] > box[3 + k] || boxes[48 + 16 * k + t] < box[k];
      if (outside) continue;
      const std::uint32_t tile = near.block[i] * kernels::kBlockTiles + t;
      std::int32_t in[kernels::kTilePoints];
      test_tile(tiles.points + static_cast<std::size_t>(tile) * 48, line, in);
      for (std::uint32_t k = 0; k < kernels::kTilePoints; ++k) {
        if (in[k]) ids_.push_back(16 * tile + k);
      }
    }
  }
  x_.clear(), y_.clear(), z_.clear(), id_.clear();
  const std::size_t stride = std::max<std::size_t>(1, (ids_.size() + kMostPoints - 1) / kMostPoints);
  for (std::size_t i = 0; i < ids_.size(); i += stride) {
    const float* at = tiles.points + static_cast<std::size_t>(ids_[i] / 16) * 48 + ids_[i] % 16;
    x_.push_back(at[0]), y_.push_back(at[16]), z_.push_back(at[32]);
    id_.push_back(ids_[i]);
  }
  known_.assign(id_.size(), 0);
  normal_.resize(id_.size());
}

/// The point's normal, or that of the first one of its 2x2 pixels if it is near. All lines of a frame share them, so
/// whose normal it is must depend on nothing but the point.
Vector3 PartPoints::shared_normal(std::size_t i) {
  std::uint32_t at = id_[i];
  const std::uint32_t first = at & ~std::uint32_t{5};
  const float* tile = tiles_->view().points + static_cast<std::size_t>(at / 16) * 48;
  for (const std::uint32_t other : {first, first + 1, first + 4}) {
    if (other >= at) break;
    const float* p = tile + other % 16;
    const float x = p[0] - x_[i], y = p[16] - y_[i], z = p[32] - z_[i];
    if (x * x + y * y + z * z <= kNormalShared * kNormalShared) {
      at = other;
      break;
    }
  }
  std::uint32_t& of = normals_of_[at / 256];
  if (of == kNone) {
    of = static_cast<std::uint32_t>(normals_.size());
    normals_.emplace_back();
  }
  Normal& n = normals_[of][at % 256];
  if (!n.known) n = {find_normal(at), true};
  return n.direction;
}

/// Normal by the plane of least squares through the points around; zero when there are too few.
Vector3 PartPoints::find_normal(std::uint32_t id) {
  const float* at = tiles_->view().points + static_cast<std::size_t>(id / 16) * 48 + id % 16;
  const float p[3] = {at[0], at[16], at[32]};
  float sum[10];
  kernels::kernels().second_moments(tiles_->view(), around_.view(), p, static_cast<float>(kNormalBall), sum);
  if (sum[0] < 8) return {};
  const float inverse = 1.0f / sum[0];
  const float mx = sum[1] * inverse, my = sum[2] * inverse, mz = sum[3] * inverse;
  Eigen::Matrix3d C;
  C(0, 0) = static_cast<double>(sum[4] * inverse - mx * mx);
  C(1, 0) = C(0, 1) = static_cast<double>(sum[5] * inverse - mx * my);
  C(2, 0) = C(0, 2) = static_cast<double>(sum[6] * inverse - mx * mz);
  C(1, 1) = static_cast<double>(sum[7] * inverse - my * my);
  C(2, 1) = C(1, 2) = static_cast<double>(sum[8] * inverse - my * mz);
  C(2, 2) = static_cast<double>(sum[9] * inverse - mz * mz);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(C * 1e4);
  const Eigen::Vector3d v = solver.eigenvectors().col(0);
  const Vector3 to_sensor =
      image_->viewpoint() - Vector3{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  const Vector3 n{v[0], v[1], v[2]};
  return dot(n, to_sensor) < 0 ? -1.0 * n : n;
}

/// Where the points are, relative to a cylinder.
void PartPoints::locate(const Cylinder& c) {
  const CylinderFrame f = frame(c);
  const std::size_t n = size();
  height_.resize(n), distance_.resize(n), side_.resize(n), ahead_.resize(n);
  const Row from = row_of(c.point);
  components(x_.data(), y_.data(), z_.data(), n, from, row_of(c.axis), height_.data());
  components(x_.data(), y_.data(), z_.data(), n, from, row_of(f.side), side_.data());
  components(x_.data(), y_.data(), z_.data(), n, from, row_of(f.ahead), ahead_.data());
  lengths(side_.data(), ahead_.data(), n, distance_.data());
}

bool PartPoints::outward(std::size_t i, const CylinderFrame& f, double& component) {
  const Vector3& normal = normal_of(i);
  component = side(i) * dot(normal, f.side) + ahead(i) * dot(normal, f.ahead);
  return dot(normal, normal) > 0.5;
}

void PartPoints::mark(const Cylinder& c, double low, double high) {
  const double tolerance = cylinder_band(c.radius, sigma_);
  const std::size_t n = size();
  selected_.resize(n);
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    selected_[count] = static_cast<std::uint32_t>(i);
    count += !((height(i) < low) | (height(i) > high) | (std::fabs(distance(i) - c.radius) > tolerance));
  }
  selected_.resize(count);
  if (!filter_normals_ || c.radius <= kNormalFrom) return;
  const CylinderFrame f = frame(c);
  std::size_t kept = 0;
  for (const std::uint32_t i : selected_) {
    double component = 0;
    const bool other = outward(i, f, component) && component < kCosNormal * distance(i);
    selected_[kept] = i;
    kept += !other;
  }
  selected_.resize(kept);
}

void PartPoints::take(std::size_t most) {
  const std::size_t stride = std::max<std::size_t>(1, (selected_.size() + most - 1) / most);
  const std::size_t n = (selected_.size() + stride - 1) / stride;
  fitted_ = n;
  for (std::vector<float>* values : {&fit_x_, &fit_y_, &fit_z_}) values->resize(n + 15);
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t i = selected_[k * stride];
    fit_x_[k] = x_[i], fit_y_[k] = y_[i], fit_z_[k] = z_[i];
  }
}

std::size_t PartPoints::select(const Cylinder& c, double low, double high) {
  locate(c);
  mark(c, low, high);
  take(kMostFitted);
  return selected_.size();
}

std::size_t PartPoints::narrow(double low, double high) {
  const auto outside = [&](std::uint32_t i) { return !(height(i) >= low && height(i) <= high); };
  selected_.erase(std::remove_if(selected_.begin(), selected_.end(), outside), selected_.end());
  take(kMostPoints);
  return selected_.size();
}

}  // namespace handhold
