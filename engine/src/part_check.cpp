#include "part_check.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "kernels.h"

namespace handhold {
namespace {

constexpr double kExtension = 0.02;  ///< m; how far beyond its members a part may go on
constexpr std::size_t kMostPoints = 1600;
constexpr std::size_t kMostFitted = 300;
constexpr std::size_t kLeastPoints = 25;
constexpr double kCosNormal = 0.6427876096865394;  ///< points whose normal is farther from radial are another surface's
constexpr double kNormalFrom = 0.010;              ///< m; thinner parts have no reliable normals
constexpr double kNormalBall = 0.008;              ///< m
constexpr double kThinnest = 0.004;                ///< m
constexpr double kWidthSlack = 1.04;
constexpr int kSteps = 10;
// Slices.
constexpr double kSlice = 0.005;       ///< m
constexpr double kLeastDensity = 0.4;  ///< of the median slice
constexpr double kLeastCover = 1.047;  ///< rad
constexpr double kRmsShare = 0.06;
constexpr double kSureCount = 10;  ///< points of a slice beyond which its radius gets no surer: their noise is alike
/// A jump of the radius parts two pieces when it is larger than both.
constexpr double kJump = 0.0012, kJumpShare = 0.06;  ///< m; of the radius
constexpr double kLeastArc = 1.2217;                 ///< rad
constexpr double kMostNormalError = 0.55;            ///< rad
constexpr double kStrap = 0.8;                       ///< of a cylinder's radius: seen narrower than this it is none

/// Points belong to a cylinder within this of its surface (m).
double band(double radius, double sigma) {
  return 0.25 * radius + 2 * sigma;
}

}  // namespace

PartCheck::Frame PartCheck::frame(const Cylinder& c) const {
  const Vector3 to_sensor = image_->viewpoint() - c.point;
  Frame f;
  f.ahead = normalized(to_sensor - dot(to_sensor, c.axis) * c.axis, any_perpendicular(c.axis));
  f.side = cross(c.axis, f.ahead);
  return f;
}

/// Points between `low` and `high` along the axis, on and around the cylinder's side that the sensor sees.
void PartCheck::gather(const Cylinder& c, double low, double high) {
  float box[6];
  const Vector3 a = c.point + low * c.axis, b = c.point + high * c.axis;
  for (std::size_t k = 0; k < 3; ++k) {
    box[k] = static_cast<float>(std::min(a[k], b[k])), box[3 + k] = static_cast<float>(std::max(a[k], b[k]));
  }
  const double most = 1.05 * c.radius + band(c.radius, sigma_) + 0.006;
  const auto reach = static_cast<float>(most);
  near_.fill(*tiles_, *index_, box, box + 3, reach);
  around_.fill(*tiles_, *index_, box, box + 3, reach + static_cast<float>(kNormalBall));
  const kernels::Tiles tiles = tiles_->view();
  const kernels::Candidates near = near_.view();
  const Vector3 ahead = frame(c).ahead;
  ids_.clear();
  for (std::int32_t i = 0; i < near.padded; ++i) {
    if (near.boxes[0][i] >= kernels::kFar) continue;
    for (std::uint32_t t = 0; t < kernels::kBlockTiles; ++t) {
      const std::uint32_t tile = near.block[i] * kernels::kBlockTiles + t;
      const float* p = tiles.points + static_cast<std::size_t>(tile) * 48;
      for (std::uint32_t k = 0; k < kernels::kTilePoints; ++k) {
        if (!(p[k] < kernels::kFar)) continue;
        const Vector3 d =
            Vector3{static_cast<double>(p[k]), static_cast<double>(p[16 + k]), static_cast<double>(p[32 + k])} -
            c.point;
        const double height = dot(d, c.axis);
        if (height < low || height > high) continue;
        const Vector3 across = d - height * c.axis;
        const double distance2 = dot(across, across);
        if (distance2 > most * most || dot(across, ahead) < -0.3 * std::sqrt(distance2)) continue;
        ids_.push_back(16 * tile + k);
      }
    }
  }
  points_.clear();
  const std::size_t stride = std::max<std::size_t>(1, (ids_.size() + kMostPoints - 1) / kMostPoints);
  for (std::size_t i = 0; i < ids_.size(); i += stride) {
    const float* at = tiles.points + static_cast<std::size_t>(ids_[i] / 16) * 48 + ids_[i] % 16;
    points_.x.push_back(at[0]), points_.y.push_back(at[16]), points_.z.push_back(at[32]);
    points_.id.push_back(ids_[i]);
  }
}

/// Normal by the plane of least squares through the points around; zero when there are too few. Neighbouring pixels
/// share one.
const Vector3& PartCheck::normal_of(std::uint32_t id, const float* p) {
  const std::uint32_t k = id % 16, quarter = (k >> 3) * 2 + ((k >> 1) & 1);
  const auto [at, is_new] = normals_.try_emplace(id / 16 * 4 + quarter);
  Vector3& n = at->second;
  if (!is_new) return n;
  const auto capacity = static_cast<std::size_t>(around_.view().padded) * 256 + 16;
  x_.require(capacity), y_.require(capacity), z_.require(capacity);
  const int count = kernels::kernels().collect(tiles_->view(), around_.view(), p, static_cast<float>(kNormalBall),
                                               nullptr, x_.data(), y_.data(), z_.data());
  if (count < 8) return n;
  float sum[9] = {};
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const float x = x_[i], y = y_[i], z = z_[i];
    sum[0] += x, sum[1] += y, sum[2] += z;
    sum[3] += x * x, sum[4] += x * y, sum[5] += x * z, sum[6] += y * y, sum[7] += y * z, sum[8] += z * z;
  }
  const float inverse = 1.0f / static_cast<float>(count);
  const float mx = sum[0] * inverse, my = sum[1] * inverse, mz = sum[2] * inverse;
  Eigen::Matrix3d C;
  C(0, 0) = static_cast<double>(sum[3] * inverse - mx * mx);
  C(1, 0) = C(0, 1) = static_cast<double>(sum[4] * inverse - mx * my);
  C(2, 0) = C(0, 2) = static_cast<double>(sum[5] * inverse - mx * mz);
  C(1, 1) = static_cast<double>(sum[6] * inverse - my * my);
  C(2, 1) = C(1, 2) = static_cast<double>(sum[7] * inverse - my * mz);
  C(2, 2) = static_cast<double>(sum[8] * inverse - mz * mz);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(C * 1e4);
  const Eigen::Vector3d v = solver.eigenvectors().col(0);
  const Vector3 to_sensor =
      image_->viewpoint() - Vector3{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  n = Vector3{v[0], v[1], v[2]};
  if (dot(n, to_sensor) < 0) n = -1.0 * n;
  return n;
}

/// Where the points are, relative to a cylinder.
void PartCheck::locate(const Cylinder& c) {
  const Frame f = frame(c);
  const std::size_t n = points_.size();
  points_.height.resize(n), points_.distance.resize(n), points_.side.resize(n), points_.ahead.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3 d = Vector3{static_cast<double>(points_.x[i]), static_cast<double>(points_.y[i]),
                              static_cast<double>(points_.z[i])} -
                      c.point;
    const double u = dot(d, f.side), v = dot(d, f.ahead);
    points_.height[i] = static_cast<float>(dot(d, c.axis));
    points_.side[i] = static_cast<float>(u), points_.ahead[i] = static_cast<float>(v);
    points_.distance[i] = static_cast<float>(std::sqrt(u * u + v * v));
  }
}

/// Marks the points between `low` and `high` that lie on the cylinder; `locate` comes before.
void PartCheck::mark(const Cylinder& c, double low, double high) {
  const double tolerance = band(c.radius, sigma_);
  const Frame f = frame(c);
  points_.on.assign(points_.size(), 0);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const double height = static_cast<double>(points_.height[i]), distance = static_cast<double>(points_.distance[i]);
    if (height < low || height > high || std::fabs(distance - c.radius) > tolerance) continue;
    if (c.radius > kNormalFrom) {
      const float p[3] = {points_.x[i], points_.y[i], points_.z[i]};
      const Vector3& normal = normal_of(points_.id[i], p);
      const double outward = static_cast<double>(points_.side[i]) * dot(normal, f.side) +
                             static_cast<double>(points_.ahead[i]) * dot(normal, f.ahead);
      if (dot(normal, normal) > 0.5 && outward < kCosNormal * distance) continue;
    }
    points_.on[i] = 1;
  }
}

/// Marked points, not more than a fit needs, for refine_cylinder and arc_of. Returns how many are marked.
std::size_t PartCheck::select(const Cylinder& c, double low, double high) {
  locate(c);
  mark(c, low, high);
  selected_.clear();
  for (std::uint32_t i = 0; i < points_.size(); ++i) {
    if (points_.on[i]) selected_.push_back(i);
  }
  const std::size_t stride = std::max<std::size_t>(1, (selected_.size() + kMostFitted - 1) / kMostFitted);
  fit_x_.clear(), fit_y_.clear(), fit_z_.clear();
  for (std::size_t i = 0; i < selected_.size(); i += stride) {
    fit_x_.push_back(points_.x[selected_[i]]), fit_y_.push_back(points_.y[selected_[i]]);
    fit_z_.push_back(points_.z[selected_[i]]);
  }
  return selected_.size();
}

void PartCheck::fill_slices(const Cylinder& c, double low, std::size_t n) {
  slices_.assign(n, {});
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!points_.on[i]) continue;
    const int at = static_cast<int>((static_cast<double>(points_.height[i]) - low) / kSlice);
    Slice& s = slices_[static_cast<std::size_t>(std::clamp(at, 0, static_cast<int>(n) - 1))];
    const double distance = static_cast<double>(points_.distance[i]), e = distance - c.radius;
    const double angle = std::atan2(static_cast<double>(points_.side[i]), static_cast<double>(points_.ahead[i]));
    s.count += 1, s.square += e * e, s.distance += distance;
    s.low = std::min(s.low, angle), s.high = std::max(s.high, angle);
  }
}

/// Log of the rms distance from the two planes along the axis that explain the selected points best, over `residual`.
/// Edges of boxes, blurred by the sensor, look round to a cylinder alone.
double PartCheck::corner_gain(double residual) {
  section_.clear();
  for (const std::uint32_t i : selected_) {
    section_.push_back({static_cast<double>(points_.side[i]), static_cast<double>(points_.ahead[i])});
  }
  std::sort(section_.begin(), section_.end());
  const std::size_t n = section_.size();
  section_sums_.assign(n + 1, {});
  for (std::size_t i = 0; i < n; ++i) {
    const double u = section_[i][0], v = section_[i][1];
    const std::array<double, 6> terms = {1, u, v, u * u, u * v, v * v};
    for (std::size_t k = 0; k < 6; ++k) section_sums_[i + 1][k] = section_sums_[i][k] + terms[k];
  }
  // Sum of squared distances from the line of least squares through points [a, b).
  const auto line = [&](std::size_t a, std::size_t b) {
    double s[6];
    for (std::size_t k = 0; k < 6; ++k) s[k] = section_sums_[b][k] - section_sums_[a][k];
    const double uu = s[3] - s[1] * s[1] / s[0], uv = s[4] - s[1] * s[2] / s[0], vv = s[5] - s[2] * s[2] / s[0];
    return std::max(0.0, 0.5 * (uu + vv - std::hypot(uu - vv, 2 * uv)));
  };
  double least = std::numeric_limits<double>::infinity();
  for (int k = 2; k <= 14; ++k) {
    const std::size_t at = n * static_cast<std::size_t>(k) / 16;
    if (at < 4 || n - at < 4) continue;
    least = std::min(least, line(0, at) + line(at, n));
  }
  if (!(least < std::numeric_limits<double>::infinity())) return 0;
  return std::log((std::sqrt(least / static_cast<double>(n)) + 1e-5) / (residual + 1e-5));
}

/// Looks at the piece between `low` and `high` of a line: the longest run of slices that are of one part and that the
/// hand can hold from one direction.
bool PartCheck::measure(Cylinder c, double low, double high, bool cut, const PartGroup& group,
                        const std::vector<Affordance>& affordances, PartCandidate& found) {
  if (cut) {
    // The fit was to several pieces of different radii.
    if (select(c, low, high) < kLeastPoints) return false;
    Cylinder fit = c;
    refine_cylinder({fit_x_.data(), fit_y_.data(), fit_z_.data(), fit_x_.size()}, sigma_, kSteps, fit);
    if (std::fabs(dot(fit.axis, c.axis)) > 0.95 && std::fabs(fit.radius - c.radius) < 0.35 * c.radius) {
      fit.point = fit.point + dot(c.point - fit.point, fit.axis) * fit.axis;
      if (dot(fit.axis, c.axis) < 0) fit.axis = -1.0 * fit.axis;
      c = fit;
    }
  }
  if (2 * c.radius > kWidthSlack * options_->hand_aperture || c.radius < kThinnest) return false;
  if (2 * c.radius < options_->hand_minimum) return false;
  if (select(c, low, high) < kLeastPoints) return false;
  const auto n = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround((high - low) / kSlice)));
  fill_slices(c, low, n);
  // What a slice of this part usually holds: how dense the cloud is here needs no other measure.
  usual_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const double middle = low + (static_cast<double>(i) + 0.5) * kSlice;
    if (middle > group.low && middle < group.high) usual_.push_back(slices_[i].count);
  }
  if (usual_.empty()) {
    for (const Slice& s : slices_) usual_.push_back(s.count);
  }
  const auto median = usual_.begin() + static_cast<std::ptrdiff_t>(usual_.size() / 2);
  std::nth_element(usual_.begin(), median, usual_.end());
  const double usual = *median;

  const FingerTest fingers(*options_, *image_);
  std::size_t best_length = 0, best_first = 0;
  double best_free = 0;
  Vector3 from{};
  std::vector<char> pass(n);
  std::vector<double> free(n);
  for (int k = 0; k < FingerTest::kAngles; ++k) {
    std::fill(pass.begin(), pass.end(), 0);
    std::fill(free.begin(), free.end(), 0.0);
    Vector3 towards{};
    for (std::size_t i = 0; i < n; ++i) {
      const Slice& s = slices_[i];
      if (s.count < std::max(1.0, kLeastDensity * usual) || s.high - s.low < kLeastCover ||
          std::sqrt(s.square / s.count) > kRmsShare * c.radius + sigma_) {
        continue;
      }
      const Grip grip = fingers.at(c.point + (low + (static_cast<double>(i) + 0.5) * kSlice) * c.axis, c.axis, c.radius,
                                   kSlice, FingerTest::angle(k));
      if (!grip.fits) continue;
      pass[i] = 1;
      free[i] = grip.free;
      towards = grip.from;
    }
    for (std::size_t i = 1; i + 1 < n; ++i) {
      if (!pass[i] && pass[i - 1] == 1 && pass[i + 1] == 1) pass[i] = 2;
    }
    std::size_t run = 0;
    for (std::size_t i = 0; i <= n; ++i) {
      if (i < n && pass[i]) {
        ++run;
        continue;
      }
      if (run > best_length) {
        best_length = run, best_first = i - run, from = towards;
        best_free = std::accumulate(free.begin() + static_cast<std::ptrdiff_t>(best_first),
                                    free.begin() + static_cast<std::ptrdiff_t>(i), 0.0) /
                    static_cast<double>(run);
      }
      run = 0;
    }
  }
  const double length = static_cast<double>(best_length) * kSlice;
  if (length < std::max(options_->handle_min_length, 0.8 * c.radius) - 1e-9) return false;
  const double begin = low + static_cast<double>(best_first) * kSlice, end = begin + length;
  const double middle = 0.5 * (begin + end);

  // The slices of the run: how straight it is, and how even.
  Evidence& e = found.evidence;
  double sides = 0, sides2 = 0, w = 0, wi = 0, wii = 0, wr = 0, wri = 0, wrr = 0, used = 0;
  for (std::size_t i = best_first; i < best_first + best_length; ++i) {
    const Slice& s = slices_[i];
    if (!(s.count > 0)) continue;
    const double mid = c.radius * 0.5 * (std::sin(s.low) + std::sin(s.high)), r = s.distance / s.count,
                 x = static_cast<double>(i), weight = std::min(s.count, kSureCount);
    sides += mid, sides2 += mid * mid, used += 1;
    w += weight, wi += weight * x, wii += weight * x * x, wr += weight * r, wri += weight * r * x,
        wrr += weight * r * r;
  }
  if (!(used > 0)) return false;
  e.bend = std::sqrt(std::max(0.0, sides2 / used - sides / used * (sides / used)));
  const double var_x = wii / w - wi / w * (wi / w), cov = wri / w - wr / w * (wi / w),
               var_r = wrr / w - wr / w * (wr / w);
  e.waviness = std::sqrt(std::max(0.0, var_r - (var_x > 1e-9 ? cov * cov / var_x : 0.0)));

  double inner = 0, outer = 0;
  const double tolerance = band(c.radius, sigma_);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto height = static_cast<double>(points_.height[i]), distance = static_cast<double>(points_.distance[i]);
    if (height < begin || height > end) {
      points_.on[i] = 0;
      continue;
    }
    inner += distance < c.radius - tolerance;
    outer += distance > c.radius + tolerance && static_cast<double>(points_.ahead[i]) > 0.5 * distance;
  }
  const Frame f = frame(c);
  double square = 0, error = 0;
  std::size_t normals = 0;
  selected_.clear(), fit_x_.clear(), fit_y_.clear(), fit_z_.clear();
  for (std::uint32_t i = 0; i < points_.size(); ++i) {
    if (!points_.on[i]) continue;
    const double distance = static_cast<double>(points_.distance[i]);
    square += (distance - c.radius) * (distance - c.radius);
    selected_.push_back(i);
    fit_x_.push_back(points_.x[i]), fit_y_.push_back(points_.y[i]), fit_z_.push_back(points_.z[i]);
    if (c.radius <= kNormalFrom) continue;
    const float p[3] = {points_.x[i], points_.y[i], points_.z[i]};
    const Vector3& normal = normal_of(points_.id[i], p);
    if (!(dot(normal, normal) > 0.5) || !(distance > 0)) continue;
    const double outward = static_cast<double>(points_.side[i]) * dot(normal, f.side) +
                           static_cast<double>(points_.ahead[i]) * dot(normal, f.ahead);
    error += std::acos(std::clamp(outward / distance, -1.0, 1.0));
    ++normals;
  }
  const std::size_t count = selected_.size();
  if (count < kLeastPoints / 2) return false;
  e.residual = std::sqrt(square / static_cast<double>(count));
  e.arc = arc_of({fit_x_.data(), fit_y_.data(), fit_z_.data(), count}, c, f.ahead);
  e.normal_error = normals ? error / static_cast<double>(normals) : 0;
  if (e.arc < kLeastArc || e.normal_error > kMostNormalError) return false;
  e.inner = inner / static_cast<double>(count), e.outer = outer / static_cast<double>(count);
  e.corner_gain = corner_gain(e.residual);

  Handle& handle = found.handle;
  handle.affordances.clear();
  double radius_sum = 0, radius_square = 0;
  e.axis_spread = e.quality = 0;
  for (const std::uint32_t i : group.members) {
    const Affordance& a = affordances[i];
    const double height = dot(a.center - c.point, c.axis);
    if (height < begin - kSlice || height > end + kSlice) continue;
    handle.affordances.push_back(i);
    const double cosine = dot(a.axis, c.axis);
    e.axis_spread += std::sqrt(std::max(0.0, 1 - cosine * cosine));
    e.quality += a.quality;
    radius_sum += a.radius, radius_square += a.radius * a.radius;
  }
  e.members = static_cast<double>(handle.affordances.size());
  if (handle.affordances.empty()) return false;
  const double mean_radius = radius_sum / e.members;
  e.radius_spread = std::sqrt(std::max(0.0, radius_square / e.members - mean_radius * mean_radius)) / c.radius;
  e.axis_spread /= e.members, e.quality /= e.members;

  // A strap is flatter than any cylinder through it: what is seen of it across the axis tells its size.
  usual_.clear();
  for (const std::uint32_t i : selected_) usual_.push_back(static_cast<double>(points_.side[i]));
  std::sort(usual_.begin(), usual_.end());
  const double left = usual_[count * 2 / 100], right = usual_[count - 1 - count * 2 / 100];
  const double half_width = 0.5 * (right - left) + 0.5 * norm(image_->viewpoint() - c.point) / image_->focal();
  const bool strap = half_width < kStrap * c.radius;
  handle.center = c.point + middle * c.axis;
  if (strap) handle.center = handle.center + 0.5 * (left + right) * f.side + (c.radius - half_width) * f.ahead;
  handle.axis = canonical_axis(c.axis);
  handle.approach = -1.0 * from;
  handle.radius = strap ? half_width : c.radius;
  handle.length = length;
  handle.arc = e.arc, handle.residual = e.residual, handle.observed_free = best_free;
  handle.normal_error = e.normal_error;
  e.length = length, e.radius = handle.radius, e.sigma = sigma_, e.free = best_free;
  handle.confidence = confidence(e);
  return true;
}

void PartCheck::run(const PartGroup& group, const std::vector<Affordance>& affordances,
                    std::vector<PartCandidate>& found) {
  Cylinder c = group.mean;
  double low = group.low, high = group.high;
  normals_.clear();
  sigma_ = depth_noise(norm(image_->viewpoint() - c.point));
  gather(c, low - kExtension, high + kExtension);
  for (int pass = 0; pass < 2; ++pass) {
    if (select(c, low, high) < kLeastPoints) return;
    Cylinder fit = c;
    refine_cylinder({fit_x_.data(), fit_y_.data(), fit_z_.data(), fit_x_.size()}, sigma_, kSteps, fit);
    if (std::fabs(dot(fit.axis, c.axis)) < 0.9 || std::fabs(fit.radius - c.radius) > 0.35 * c.radius + 0.003) break;
    // Heights keep their origin.
    fit.point = fit.point + dot(c.point - fit.point, fit.axis) * fit.axis;
    if (dot(fit.axis, c.axis) < 0) fit.axis = -1.0 * fit.axis;
    c = fit;
  }
  if (c.radius < kThinnest) return;
  low -= kExtension, high += kExtension;
  if (select(c, low, high) < kLeastPoints) return;
  const auto n = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil((high - low) / kSlice)));
  fill_slices(c, low, n);
  profile_.assign(n, {});
  for (std::size_t i = 0; i < n; ++i) {
    const Slice& s = slices_[i];
    if (s.count < 3) continue;
    profile_[i] = {std::min(s.count, kSureCount) / (sigma_ * sigma_), s.distance / s.count};
  }
  pieces_.clear();
  cut_profile(profile_, kSlice, std::max(kJump, kJumpShare * c.radius), profile_scratch_, pieces_);
  const bool cut = pieces_.size() > 1;
  for (const ProfilePiece& piece : pieces_) {
    const double from = low + static_cast<double>(piece.first) * kSlice,
                 to = low + static_cast<double>(piece.last) * kSlice;
    if (to - from < options_->handle_min_length - 1e-9) continue;
    double weight = 0, sum = 0;
    for (std::size_t i = piece.first; i < piece.last; ++i) {
      weight += profile_[i].weight, sum += profile_[i].weight * profile_[i].radius;
    }
    if (!(weight > 0)) continue;
    Cylinder own = c;
    if (cut) own.radius = sum / weight;
    PartCandidate candidate;
    if (measure(own, from, to, cut, group, affordances, candidate)) found.push_back(std::move(candidate));
  }
}

}  // namespace handhold
