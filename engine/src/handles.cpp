#include "handles.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels.h"
#include "vec3.h"

namespace handhold {
namespace {

/// Fate of an affordance; the later one counts.
enum Fate : std::uint8_t { kNotAligned, kTooShort, kLowConfidence, kInHandle };

/// Rises from 0 over 1/2 at `half` towards 1.
double saturating(double x, double half) {
  return half > 0 ? 1 - std::exp2(-x / half) : 1;
}

}  // namespace

/// The same point may be drawn twice: it is evidence once.
void HandleSearch::find_copies(const std::vector<Affordance>& affordances) {
  const auto n = static_cast<std::uint32_t>(affordances.size());
  run_.clear();
  for (std::uint32_t i = 0; i < n; ++i) run_.emplace_back(affordances[i].center[0], i);
  std::sort(run_.begin(), run_.end());
  first_same_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t i = run_[k].second;
    first_same_[i] = i;
    // Those before it at the same place along x, of which few are the same in everything.
    for (std::size_t j = k; j-- > 0 && run_[j].first == run_[k].first;) {
      const Affordance &one = affordances[run_[j].second], &other = affordances[i];
      if (one.center == other.center && one.axis == other.axis) {
        first_same_[i] = first_same_[run_[j].second];
        break;
      }
    }
  }
}

void HandleSearch::load(const std::vector<Affordance>& affordances) {
  const std::size_t n = affordances.size();
  padded_ = static_cast<std::int32_t>((n + 15) / 16 * 16);
  for (auto& a : arrays_) a.require(static_cast<std::size_t>(padded_));
  for (std::size_t i = 0; i < static_cast<std::size_t>(padded_); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      // NaN is aligned with nothing.
      arrays_[k][i] = i < n && first_same_[i] == i ? static_cast<float>(affordances[i].center[k])
                                                   : std::numeric_limits<float>::quiet_NaN();
      arrays_[3 + k][i] = i < n ? static_cast<float>(affordances[i].axis[k]) : 0.0f;
    }
    arrays_[6][i] = i < n ? static_cast<float>(affordances[i].radius) : 0.0f;
  }
  for (auto& c : columns_) c.resize(n);
  far_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < 3; ++k)
      columns_[k][i] = affordances[i].center[k], columns_[3 + k][i] = affordances[i].axis[k];
    columns_[6][i] = affordances[i].radius;
  }
}

kernels::AlignLimits align_limits(const Options& o) {
  return {static_cast<float>(std::sin(o.align_angle)), static_cast<float>(o.align_offset),
          static_cast<float>(o.align_radius)};
}

std::uint32_t HandleSearch::row(std::size_t i, std::uint32_t* bits) const {
  const kernels::AffordanceArrays a{arrays_[0].data(), arrays_[1].data(), arrays_[2].data(), arrays_[3].data(),
                                    arrays_[4].data(), arrays_[5].data(), arrays_[6].data(), padded_};
  const kernels::AlignLimits limits = align_limits(*options_);
  return static_cast<std::uint32_t>(kernels::kernels().align(a, static_cast<std::int32_t>(i), limits, bits));
}

void HandleSearch::count_aligned(std::size_t n) {
  aligned_.assign(n, 0);
  const std::size_t words = static_cast<std::size_t>(padded_ + 31) / 32;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 64), [&](const auto& range) {
    std::vector<std::uint32_t>& bits = row_bits_.local();
    bits.resize(words);
    for (std::size_t i = range.begin(); i < range.end(); ++i) aligned_[i] = row(i, bits.data());
  });
}

/// Axis, a point of it and the median radius of members_. Short runs take the mean of the members' axes; long ones the
/// direction in which their centres lie, which is then the better known.
HandleSearch::Line HandleSearch::fit_line() {
  double axes[6] = {}, spread[6] = {};  // xx xy xz yy yz zz
  Vector3 mean{};
  const auto add = [](double* sum, double x, double y, double z) {
    sum[0] += x * x, sum[1] += x * y, sum[2] += x * z, sum[3] += y * y, sum[4] += y * z, sum[5] += z * z;
  };
  radii_.clear();
  for (const std::uint32_t i : members_) {
    add(axes, columns_[3][i], columns_[4][i], columns_[5][i]);
    for (std::size_t k = 0; k < 3; ++k) mean[k] += columns_[k][i];
    radii_.push_back(columns_[6][i]);
  }
  const auto n = static_cast<double>(members_.size());
  mean = (1 / n) * mean;
  for (const std::uint32_t i : members_)
    add(spread, columns_[0][i] - mean[0], columns_[1][i] - mean[1], columns_[2][i] - mean[2]);
  const auto solve = [](const double* sum) {
    Eigen::Matrix3d m;
    m << sum[0], sum[1], sum[2], sum[1], sum[3], sum[4], sum[2], sum[4], sum[5];
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m);
  };
  Eigen::Vector3d axis = solve(axes).eigenvectors().col(2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> lie = solve(spread);
  const Eigen::Vector3d direction = lie.eigenvectors().col(2);
  const double length = std::sqrt(12 * std::max(0.0, lie.eigenvalues()[2]) / n);  // of a uniform run
  const double width = std::sqrt(std::max(0.0, lie.eigenvalues()[1]) / n);
  if (length > 0.04 && length > 8 * width && std::fabs(direction.dot(axis)) >= std::cos(options_->align_angle))
    axis = direction;
  const auto middle = radii_.begin() + static_cast<std::ptrdiff_t>(radii_.size() / 2);
  std::nth_element(radii_.begin(), middle, radii_.end());
  return {mean, canonical_axis({axis[0], axis[1], axis[2]}), *middle};
}

/// Which affordances are not of a line's part: far_. All columns at once, so that the compiler takes several rows.
void HandleSearch::find_far(const Line& line) {
  const double sine = std::sin(options_->align_angle), sine2 = sine * sine;
  const double offset2 = options_->align_offset * options_->align_offset, radius = options_->align_radius;
  const double px = line.point[0], py = line.point[1], pz = line.point[2];
  const double vx = line.axis[0], vy = line.axis[1], vz = line.axis[2], r = line.radius;
  const double *cx = columns_[0].data(), *cy = columns_[1].data(), *cz = columns_[2].data();
  const double *ax = columns_[3].data(), *ay = columns_[4].data(), *az = columns_[5].data(), *ar = columns_[6].data();
  double* far = far_.data();
  for (std::size_t i = 0, n = far_.size(); i < n; ++i) {
    const double dx = cx[i] - px, dy = cy[i] - py, dz = cz[i] - pz, t = dx * vx + dy * vy + dz * vz;
    const double ox = dx - t * vx, oy = dy - t * vy, oz = dz - t * vz;
    const double sx = vy * az[i] - vz * ay[i], sy = vz * ax[i] - vx * az[i], sz = vx * ay[i] - vy * ax[i];
    const double over = std::max(sx * sx + sy * sy + sz * sz - sine2, ox * ox + oy * oy + oz * oz - offset2);
    far[i] = std::max(over, std::fabs(ar[i] - r) - radius);
  }
}

/// From the affordances in members_ to the contiguous run about the seed along the line through them. Twice, so that
/// the line of the run decides and not the seed's own noise. False when nothing is left.
bool HandleSearch::grow(std::size_t seed, Line& line) {
  std::vector<std::pair<double, std::uint32_t>>& run = run_;
  const auto along = [&](std::uint32_t i) {
    const Vector3 d = Vector3{columns_[0][i], columns_[1][i], columns_[2][i]} - line.point;
    return dot(d, line.axis);
  };
  for (int pass = 0; pass < 2; ++pass) {
    line = fit_line();
    find_far(line);
    run.clear();
    for (std::uint32_t i = 0; i < far_.size(); ++i) {
      if (!(far_[i] > 0) && !taken_[i]) run.emplace_back(along(i), i);
    }
    if (run.empty()) return false;
    std::sort(run.begin(), run.end());
    // The run that holds the seed, or the entry nearest to it.
    const double t_seed = along(static_cast<std::uint32_t>(seed));
    std::size_t at = 0;
    for (std::size_t i = 1; i < run.size(); ++i) {
      if (std::fabs(run[i].first - t_seed) < std::fabs(run[at].first - t_seed)) at = i;
    }
    std::size_t first = at, last = at;
    while (first > 0 && run[first].first - run[first - 1].first <= options_->handle_gap) --first;
    while (last + 1 < run.size() && run[last + 1].first - run[last].first <= options_->handle_gap) ++last;
    members_.clear();
    for (std::size_t i = first; i <= last; ++i) members_.push_back(run[i].second);
  }
  line = fit_line();
  return true;
}

void HandleSearch::run(const std::vector<Affordance>& affordances, Spares<Handle>& spares, std::vector<Handle>& handles,
                       Funnel& funnel, const std::vector<std::uint32_t>* aligned) {
  spares.take(handles);
  order_.clear();
  const std::size_t n = affordances.size();
  std::vector<std::uint8_t>& fate = fate_;
  fate.assign(n, kNotAligned);
  if (n > 0) {
    find_copies(affordances);
    load(affordances);
    if (aligned) {
      aligned_ = *aligned;
    } else {
      count_aligned(n);
    }
    taken_.assign(n, 0);
    for (std::uint32_t i = 0; i < n; ++i) taken_[i] = first_same_[i] != i;
    spent_.assign(n, 0);
    // Most aligned first; of equally many the first.
    order_.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) order_[i] = std::uint64_t{~aligned_[i]} << 32 | i;
    std::sort(order_.begin(), order_.end());
    bits_.resize(static_cast<std::size_t>(padded_ + 31) / 32);
  }
  const auto least = static_cast<std::size_t>(options_->handle_min_affordances);
  for (const std::uint64_t key : order_) {
    const auto seed = static_cast<std::uint32_t>(key);
    if (taken_[seed] || spent_[seed] || aligned_[seed] < least) continue;
    row(seed, bits_.data());
    members_.clear();
    for (std::uint32_t i = 0; i < n; ++i) {
      if (bits_[i / 32] >> (i % 32) & 1 && !taken_[i]) members_.push_back(i);
    }
    Line line;
    if (members_.size() < least || !grow(seed, line) || members_.size() < least) continue;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    Vector3 normal{};
    for (const std::uint32_t i : members_) {
      const double t = dot(affordances[i].center - line.point, line.axis);
      low = std::min(low, t), high = std::max(high, t);
      normal = normal + affordances[i].normal;
    }
    const double length = high - low;
    if (length < options_->handle_min_length) {
      // The whole run is too short whichever of its members it is looked at from; they may still join another one.
      for (const std::uint32_t i : members_) {
        fate[i] = std::max<std::uint8_t>(fate[i], kTooShort);
        spent_[i] = 1;
      }
      continue;
    }
    Handle& h = spares.add(handles);
    h.path.clear();
    h.arc = h.residual = h.observed_free = h.normal_error = 0;
    h.center = line.point + 0.5 * (low + high) * line.axis;
    h.axis = line.axis;
    h.approach = -1.0 * normalized(normal - dot(normal, line.axis) * line.axis, any_perpendicular(line.axis));
    h.radius = line.radius;
    h.length = length;
    h.confidence = std::sqrt(saturating(static_cast<double>(members_.size()), static_cast<double>(least)) *
                             saturating(length, options_->handle_min_length));
    std::sort(members_.begin(), members_.end());
    h.affordances = members_;
    const bool good = h.confidence >= options_->effective_min_confidence();
    for (const std::uint32_t i : members_) {
      taken_[i] = 1;
      fate[i] = good ? kInHandle : kLowConfidence;
    }
    // What else lies on this part, a little askew or of another radius, is no second handle.
    for (std::uint32_t i = 0; i < n; ++i) {
      if (taken_[i]) continue;
      const Vector3 d = Vector3{columns_[0][i], columns_[1][i], columns_[2][i]} - line.point;
      const double t = dot(d, line.axis);
      if (t < low - options_->handle_gap || t > high + options_->handle_gap) continue;
      const double along =
          columns_[3][i] * line.axis[0] + columns_[4][i] * line.axis[1] + columns_[5][i] * line.axis[2];
      if (norm(d - t * line.axis) <= std::max(line.radius, options_->align_offset) && std::fabs(along) >= 0.7) {
        taken_[i] = 1;
        fate[i] = good ? kInHandle : kLowConfidence;
      }
    }
    if (!good) spares.take(handles, handles.size() - 1);
  }
  std::sort(handles.begin(), handles.end(), [](const Handle& a, const Handle& b) {
    return a.confidence != b.confidence ? a.confidence > b.confidence : a.affordances < b.affordances;
  });
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t f = fate[first_same_[i]];
    ++(f == kNotAligned      ? funnel.not_aligned
       : f == kTooShort      ? funnel.too_short
       : f == kLowConfidence ? funnel.low_confidence
                             : funnel.in_handles);
  }
}

}  // namespace handhold
