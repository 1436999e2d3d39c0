#include "handles.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

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
  order_.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) order_[i] = i;
  const auto key = [&](std::uint32_t i) { return std::tie(affordances[i].center, affordances[i].axis); };
  std::sort(order_.begin(), order_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  first_same_.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool same = i > 0 && key(order_[i]) == key(order_[i - 1]);
    first_same_[order_[i]] = same ? first_same_[order_[i - 1]] : order_[i];
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
}

void HandleSearch::row(std::size_t i, std::uint32_t* bits) const {
  const kernels::AffordanceArrays a{arrays_[0].data(), arrays_[1].data(), arrays_[2].data(), arrays_[3].data(),
                                    arrays_[4].data(), arrays_[5].data(), arrays_[6].data(), padded_};
  const kernels::AlignLimits limits{static_cast<float>(std::sin(options_->align_angle)),
                                    static_cast<float>(options_->align_offset),
                                    static_cast<float>(options_->align_radius)};
  kernels::kernels().align(a, static_cast<std::int32_t>(i), limits, bits);
}

void HandleSearch::count_aligned(std::size_t n) {
  aligned_.assign(n, 0);
  const std::size_t words = static_cast<std::size_t>(padded_ + 31) / 32;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 64), [&](const auto& range) {
    std::vector<std::uint32_t>& bits = row_bits_.local();
    bits.resize(words);
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      row(i, bits.data());
      for (const std::uint32_t w : bits) aligned_[i] += static_cast<std::uint32_t>(__builtin_popcount(w));
    }
  });
}

/// Axis, a point of it and the median radius of members_. Short runs take the mean of the members' axes; long ones the
/// direction in which their centres lie, which is then the better known.
HandleSearch::Line HandleSearch::fit_line(const std::vector<Affordance>& affordances) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero(), spread = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  std::vector<double>& radii = radii_;
  radii.clear();
  for (const std::uint32_t i : members_) {
    const Affordance& a = affordances[i];
    const Eigen::Vector3d v(a.axis[0], a.axis[1], a.axis[2]), c(a.center[0], a.center[1], a.center[2]);
    axes += v * v.transpose();
    mean += c;
    radii.push_back(a.radius);
  }
  const auto n = static_cast<double>(members_.size());
  mean /= n;
  for (const std::uint32_t i : members_) {
    const Affordance& a = affordances[i];
    const Eigen::Vector3d d = Eigen::Vector3d(a.center[0], a.center[1], a.center[2]) - mean;
    spread += d * d.transpose();
  }
  Eigen::Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>().compute(axes).eigenvectors().col(2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> lie(spread);
  const Eigen::Vector3d direction = lie.eigenvectors().col(2);
  const double length = std::sqrt(12 * std::max(0.0, lie.eigenvalues()[2]) / n);  // of a uniform run
  const double width = std::sqrt(std::max(0.0, lie.eigenvalues()[1]) / n);
  if (length > 0.04 && length > 8 * width && std::fabs(direction.dot(axis)) >= std::cos(options_->align_angle))
    axis = direction;
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  return {{mean[0], mean[1], mean[2]}, canonical_axis({axis[0], axis[1], axis[2]}), *middle};
}

/// From the affordances in members_ to the contiguous run about the seed along the line through them. Twice, so that
/// the line of the run decides and not the seed's own noise. False when nothing is left.
bool HandleSearch::grow(const std::vector<Affordance>& affordances, std::size_t seed, Line& line) {
  const double sine = std::sin(options_->align_angle);
  std::vector<std::pair<double, std::uint32_t>>& run = run_;
  for (int pass = 0; pass < 2; ++pass) {
    line = fit_line(affordances);
    run.clear();
    for (std::uint32_t i = 0; i < affordances.size(); ++i) {
      if (taken_[i]) continue;
      const Affordance& a = affordances[i];
      const Vector3 d = a.center - line.point;
      const double t = dot(d, line.axis);
      if (norm(cross(line.axis, a.axis)) > sine || norm(d - t * line.axis) > options_->align_offset) continue;
      if (std::fabs(a.radius - line.radius) > options_->align_radius) continue;
      run.emplace_back(t, i);
    }
    if (run.empty()) return false;
    std::sort(run.begin(), run.end());
    // The run that holds the seed, or the entry nearest to it.
    const double t_seed = dot(affordances[seed].center - line.point, line.axis);
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
  line = fit_line(affordances);
  return true;
}

void HandleSearch::run(const std::vector<Affordance>& affordances, Spares<Handle>& spares, std::vector<Handle>& handles,
                       Funnel& funnel) {
  spares.take(handles);
  order_.clear();
  const std::size_t n = affordances.size();
  std::vector<std::uint8_t>& fate = fate_;
  fate.assign(n, kNotAligned);
  if (n > 0) {
    find_copies(affordances);
    load(affordances);
    count_aligned(n);
    taken_.assign(n, 0);
    for (std::uint32_t i = 0; i < n; ++i) taken_[i] = first_same_[i] != i;
    spent_.assign(n, 0);
    order_.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) order_[i] = i;
    std::sort(order_.begin(), order_.end(), [this](std::uint32_t a, std::uint32_t b) {
      return aligned_[a] != aligned_[b] ? aligned_[a] > aligned_[b] : a < b;
    });
    bits_.resize(static_cast<std::size_t>(padded_ + 31) / 32);
  }
  const auto least = static_cast<std::size_t>(options_->handle_min_affordances);
  for (const std::uint32_t seed : order_) {
    if (taken_[seed] || spent_[seed] || aligned_[seed] < least) continue;
    row(seed, bits_.data());
    members_.clear();
    for (std::uint32_t i = 0; i < n; ++i) {
      if (bits_[i / 32] >> (i % 32) & 1 && !taken_[i]) members_.push_back(i);
    }
    Line line;
    if (members_.size() < least || !grow(affordances, seed, line) || members_.size() < least) continue;
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
      const Vector3 d = affordances[i].center - line.point;
      const double t = dot(d, line.axis);
      const bool on_part = t >= low - options_->handle_gap && t <= high + options_->handle_gap &&
                           norm(d - t * line.axis) <= std::max(line.radius, options_->align_offset);
      if (on_part && std::fabs(dot(affordances[i].axis, line.axis)) >= 0.7) {
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
