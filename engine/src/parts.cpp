#include "parts.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

namespace handhold {
namespace {

// Members of a group, relative to the seed's radius r.
constexpr double kCosAlign = 0.9396926207859084;  // 20 degrees
constexpr double kOffsetShare = 0.35, kOffset = 0.003;
constexpr double kRadiusShare = 0.3, kRadius = 0.002;
constexpr double kMemberGap = 0.012;  ///< m
constexpr int kMostUses = 1;          ///< a member of so many groups starts no other one
constexpr double kReach = 0.25;       ///< m; members lie within this of the seed along its axis

enum Fate : std::uint8_t { kNotAligned, kUnconfirmed, kLowConfidence, kInHandle };

/// Which of `n` affordances - position, axis and radius in single precision, each coordinate for itself - may be
/// members of the seed's group, where that is wrong by less than `slack` (m). A loop on arrays that share no memory:
/// the compiler takes several at a time.
void may_be_members(const AlignedArray<float>* rows, std::size_t n, std::size_t seed, float slack,
                    std::int32_t* __restrict out) {
  const float* __restrict x = rows[0].data(), * __restrict y = rows[1].data(), * __restrict z = rows[2].data();
  const float* __restrict ax = rows[3].data(), * __restrict ay = rows[4].data(), * __restrict az = rows[5].data();
  const float* __restrict radius = rows[6].data();
  const float x0 = x[seed], y0 = y[seed], z0 = z[seed], ux = ax[seed], uy = ay[seed], uz = az[seed], r0 = radius[seed];
  const float reach = static_cast<float>(kReach) + slack, cosine = static_cast<float>(kCosAlign) - 1e-5f;
  const float offset = static_cast<float>(kOffsetShare) * r0 + static_cast<float>(kOffset) + slack;
  const float change = static_cast<float>(kRadiusShare) * r0 + static_cast<float>(kRadius) + slack;
  const float offset2 = offset * offset;
  for (std::size_t i = 0; i < n; ++i) {
    const float dx = x[i] - x0, dy = y[i] - y0, dz = z[i] - z0;
    const float along = dx * ux + dy * uy + dz * uz;
    const float bx = dx - along * ux, by = dy - along * uy, bz = dz - along * uz;
    out[i] = (std::fabs(along) <= reach) & (std::fabs(ax[i] * ux + ay[i] * uy + az[i] * uz) >= cosine) &
             (bx * bx + by * by + bz * bz <= offset2) & (std::fabs(radius[i] - r0) <= change);
  }
}

}  // namespace

/// Groups about the best affordances first. An affordance may be in several: which one is right the points decide.
void PartSearch::make_groups(const std::vector<Affordance>& affordances, const Budget& budget) {
  groups_.clear();
  const std::size_t n = affordances.size();
  std::vector<std::uint8_t>& uses = uses_;
  uses.assign(n, 0);
  std::vector<std::uint32_t>& order = order_;
  order.resize(n);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return affordances[a].quality != affordances[b].quality ? affordances[a].quality > affordances[b].quality : a < b;
  });
  const auto least = static_cast<std::size_t>(options_->handle_min_affordances);
  std::vector<std::pair<double, std::uint32_t>>& members = members_;
  for (AlignedArray<float>& row : rows_) row.require(n);
  double farthest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Affordance& a = affordances[i];
    for (std::size_t k = 0; k < 3; ++k) {
      rows_[k][i] = static_cast<float>(a.center[k]), rows_[3 + k][i] = static_cast<float>(a.axis[k]);
    }
    rows_[6][i] = static_cast<float>(a.radius);
    farthest = std::max(farthest, norm(a.center));
  }
  const auto slack = static_cast<float>(1e-5 + 0x1p-20 * farthest);
  AlignedArray<std::int32_t>& near = near_;
  near.require(n);
  for (const std::uint32_t seed : order) {
    if (uses[seed] >= kMostUses) continue;
    if (budget.spent()) break;
    const Affordance& s = affordances[seed];
    members.clear();
    may_be_members(rows_, n, seed, slack, near.data());
    for (std::uint32_t j = 0; j < n; ++j) {
      if (!near[j]) continue;
      const Affordance& a = affordances[j];
      const Vector3 d = a.center - s.center;
      const double along = dot(d, s.axis);
      if (std::fabs(along) > kReach || std::fabs(dot(a.axis, s.axis)) < kCosAlign) continue;
      if (norm(d - along * s.axis) > kOffsetShare * s.radius + kOffset) continue;
      if (std::fabs(a.radius - s.radius) > kRadiusShare * s.radius + kRadius) continue;
      members.emplace_back(along, j);
    }
    if (members.size() < least) continue;
    std::sort(members.begin(), members.end());
    std::size_t at = 0;
    while (members[at].second != seed) ++at;
    std::size_t first = at, last = at;
    while (first > 0 && members[first].first - members[first - 1].first < kMemberGap) --first;
    while (last + 1 < members.size() && members[last + 1].first - members[last].first < kMemberGap) ++last;
    if (last - first + 1 < least) continue;

    PartGroup& group = groups_.next();
    group.clear();
    Vector3 axis{}, center{};
    double weight = 0;
    std::vector<double>&radii = radii_, &widths = widths_;
    radii.clear(), widths.clear();
    for (std::size_t k = first; k <= last; ++k) {
      const Affordance& a = affordances[members[k].second];
      axis = axis + (dot(a.axis, s.axis) < 0 ? -a.quality : a.quality) * a.axis;
      center = center + a.quality * a.center;
      weight += a.quality;
      radii.push_back(a.radius);
      if (a.neighbourhood == 0) widths.push_back(a.radius);
      group.members.push_back(members[k].second);
      if (uses[members[k].second] < kMostUses) ++uses[members[k].second];
    }
    group.straps = widths.size();
    if (2 * group.straps >= radii.size()) std::swap(radii, widths);
    const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
    std::nth_element(radii.begin(), middle, radii.end());
    group.mean = {(1 / weight) * center, normalized(axis), *middle};
    group.low = std::numeric_limits<double>::infinity(), group.high = -group.low;
    for (const std::uint32_t j : group.members) {
      const double h = dot(affordances[j].center - group.mean.point, group.mean.axis);
      group.low = std::min(group.low, h - options_->finger_width / 2);
      group.high = std::max(group.high, h + options_->finger_width / 2);
    }
    std::sort(group.members.begin(), group.members.end());
  }
}

bool PartSearch::run(const std::vector<Affordance>& affordances, const TileStore& tiles, const NeighbourIndex& index,
                     const DepthImage& image, Spares<Handle>& spares, std::vector<Handle>& handles, Funnel& funnel,
                     const Budget& budget) {
  std::atomic<bool> done{true};
  spares.take(handles);
  // Side by side: each takes one thread.
  tbb::parallel_invoke([&] { make_groups(affordances, budget); },
                       [&] {
                         bow_groups_.clear();
                         if (conditions_.bows) bow_search_.run(affordances, image, bow_groups_, bows_, budget);
                       });
  all_groups_.clear();
  for (const PartGroup& group : groups_) all_groups_.push_back(&group);
  for (const PartGroup& group : bow_groups_) all_groups_.push_back(&group);
  found_.resize(std::max(found_.size(), all_groups_.size()));
  for (Recycled<PartCandidate>& found : found_) found.clear();
  // The longest first, so that none of them is the last one to end.
  first_.resize(all_groups_.size());
  std::iota(first_.begin(), first_.end(), 0u);
  std::sort(first_.begin(), first_.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double la = all_groups_[a]->high - all_groups_[a]->low, lb = all_groups_[b]->high - all_groups_[b]->low;
    return la != lb ? la > lb : a < b;
  });
  for (PartCheck& check : checks_) check.begin(*options_, tiles, index, image, conditions_);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, first_.size(), 1),
      [&](const auto& range) {
        bool exists = false;
        PartCheck& check = checks_.local(exists);
        if (!exists) check.begin(*options_, tiles, index, image, conditions_);
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          const std::uint32_t g = first_[i];
          if (budget.spent()) {
            done.store(false, std::memory_order_relaxed);
            return;
          }
          check.run(*all_groups_[g], affordances, found_[g]);
        }
      },
      tbb::simple_partitioner());
  std::vector<std::uint8_t>& fate = fate_;
  fate.assign(affordances.size(), kNotAligned);
  all_.clear();
  for (std::size_t g = 0; g < all_groups_.size(); ++g) {
    for (const std::uint32_t i : all_groups_[g]->members) fate[i] = kUnconfirmed;
    for (const PartCandidate& candidate : found_[g]) all_.push_back(&candidate);
  }
  for (const PartCandidate* candidate : all_) {
    const Handle& h = candidate->handle;
    const std::uint8_t to = h.confidence < options_->effective_min_confidence() ? kLowConfidence : kInHandle;
    for (const std::uint32_t i : h.affordances) fate[i] = std::max(fate[i], to);
  }
  resolver_.run(all_, conditions_.continue_parts, kept_);
  for (const PartCandidate& candidate : kept_) {
    if (candidate.handle.confidence < options_->effective_min_confidence()) continue;
    Handle& h = spares.add(handles);
    h = candidate.handle;
    if (h.path.empty()) continue;
    h.length = 0;
    for (std::size_t i = 0; i + 1 < h.path.size(); ++i) h.length += norm(h.path[i + 1] - h.path[i]);
  }
  if (conditions_.join_curved) chains_.join_curved(handles, spares);
  for (const std::uint8_t f : fate) {
    ++(f == kNotAligned      ? funnel.not_aligned
       : f == kUnconfirmed   ? funnel.unconfirmed
       : f == kLowConfidence ? funnel.low_confidence
                             : funnel.in_handles);
  }
  return done && !budget.spent();
}

}  // namespace handhold
