#include "parts.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "bow_groups.h"
#include "chain.h"

namespace handhold {
namespace {

// Members of a group, relative to the seed's radius r.
constexpr double kCosAlign = 0.9396926207859084;  // 20 degrees
constexpr double kOffsetShare = 0.35, kOffset = 0.003;
constexpr double kRadiusShare = 0.3, kRadius = 0.002;
constexpr double kMemberGap = 0.012;  ///< m
constexpr int kMostUses = 1;          ///< a member of so many groups starts no other one
constexpr double kReach = 0.25;       ///< m; members lie within this of the seed along its axis
// Pieces of one part.
constexpr double kCosContinue = 0.9396926207859084;              ///< 20 degrees
constexpr double kOffsetContinue = 0.6;                          ///< of the smaller radius
constexpr double kSameRadiusShare = 0.13, kSameRadius = 0.0008;  ///< m; a larger step is where a part ends
constexpr double kSameRadiusSigmas = 0.5;                        ///< more where the sensor is less sure
constexpr double kStepShare = 0.10, kStep = 0.0025;              ///< where a step was seen
constexpr double kLikely = 0.5;        ///< confidence of what keeps the pieces on its two sides apart
constexpr double kSure = 0.85;         ///< confidence; of surer parts on one place the longest stays
constexpr double kExtends = 0.2;       ///< confidence of a piece that another one grows over
constexpr double kStepGap = 0.02;      ///< m; between two steps
constexpr double kContinueGap = 0.12;  ///< m; clutter in front of a part hides so much
constexpr double kOpenGap = 0.05;      ///< m; a longer gap is not noise: something hides the part there
/// Share of the shorter one's length up to which two parts on one line may overlap.
constexpr double kMostShared = 0.3;
constexpr double kCosAlike = 0.766;  ///< 40 degrees

enum Fate : std::uint8_t { kNotAligned, kUnconfirmed, kLowConfidence, kInHandle };

/// Whether h goes on where g ends, or lies within it: pieces of one part that clutter or noise cut.
bool continues(const PartCandidate& first, const PartCandidate& second) {
  const Handle &g = first.handle, &h = second.handle;
  if (std::fabs(dot(g.axis, h.axis)) < kCosContinue) return false;
  const Vector3 d = h.center - g.center;
  const double along = dot(d, g.axis), offset = kOffsetContinue * std::min(g.radius, h.radius) + kOffset;
  if (norm(d - along * g.axis) > offset && norm(d - dot(d, h.axis) * h.axis) > offset) return false;
  const double gap = std::fabs(along) - 0.5 * (g.length + h.length);
  if (gap > kContinueGap) return false;
  // A handle is taken at its middle: that may not lie behind what hides the part there.
  if (gap > kOpenGap && gap > std::fabs(g.length - h.length)) return false;
  // Where the points showed a step, a small one parts them, and what lies beyond another piece is another part.
  const bool same_way = dot(g.axis, h.axis) > 0, beyond = along > 0;
  const bool step_g = beyond ? first.ends_high : first.ends_low;
  const bool step_h = beyond == same_way ? second.ends_low : second.ends_high, step = step_g || step_h;
  if (step_g && step_h && gap > kStepGap) return false;
  const bool within = std::fabs(along) < 0.5 * g.length;
  const double larger = std::max(g.radius, h.radius), sigma = std::max(first.evidence.sigma, second.evidence.sigma);
  const double same = kSameRadiusShare * larger + kSameRadius + kSameRadiusSigmas * sigma;
  const double most =
      step && !within ? std::min(same, std::max(kStepShare * larger, kStep + kSameRadiusSigmas * sigma)) : same;
  return std::fabs(g.radius - h.radius) <= most;
}

/// Whether h is a part of another radius on g's line.
bool differs(const Handle& g, const Handle& h) {
  if (std::fabs(dot(g.axis, h.axis)) < kCosContinue) return false;
  const Vector3 d = h.center - g.center;
  if (norm(d - dot(d, g.axis) * g.axis) > kOffsetContinue * std::min(g.radius, h.radius) + kOffset) return false;
  return std::fabs(g.radius - h.radius) > kSameRadiusShare * std::max(g.radius, h.radius) + kSameRadius;
}

/// Whether `other` is a part of another radius on the line through both, in the gap between them.
bool parts(const Handle& g, const Handle& h, const Handle& other) {
  if (!differs(g, other)) return false;
  const double to_h = dot(h.center - g.center, g.axis), to_other = dot(other.center - g.center, g.axis);
  if (to_h * to_other < 0) return false;
  return std::fabs(to_other) >= 0.5 * g.length && std::fabs(to_other) <= std::fabs(to_h) - 0.5 * h.length;
}

void add_members(const Handle& from, Handle& to) {
  std::vector<std::uint32_t> members;
  std::set_union(to.affordances.begin(), to.affordances.end(), from.affordances.begin(), from.affordances.end(),
                 std::back_inserter(members));
  to.affordances = std::move(members);
}

/// Makes g as long as both.
void extend(PartCandidate& first, const PartCandidate& second) {
  Handle& g = first.handle;
  const Handle& h = second.handle;
  const bool same_way = dot(g.axis, h.axis) > 0;
  const double along = dot(h.center - g.center, g.axis);
  const double low = std::min(-0.5 * g.length, along - 0.5 * h.length);
  const double high = std::max(0.5 * g.length, along + 0.5 * h.length);
  if (low < -0.5 * g.length) first.ends_low = same_way ? second.ends_low : second.ends_high;
  if (high > 0.5 * g.length) first.ends_high = same_way ? second.ends_high : second.ends_low;
  g.center = g.center + 0.5 * (low + high) * g.axis;
  g.length = high - low;
  add_members(h, g);
}

/// Whether g, which is likelier, explains h.
bool overlaps(const Handle& g, const Handle& h) {
  const Vector3 d = h.center - g.center;
  const double cosine = std::fabs(dot(h.axis, g.axis)), along = dot(d, g.axis), across = norm(d - along * g.axis);
  const double small = std::min(h.radius, g.radius), large = std::max(h.radius, g.radius);
  if (cosine > kCosAlike) {
    const double shared = 0.5 * (g.length + h.length * cosine) - std::fabs(along);
    return across < large + 0.5 * small + 0.006 && shared > kMostShared * std::min(g.length, h.length * cosine);
  }
  const double along_h = dot(d, h.axis), across_h = norm(d - along_h * h.axis);
  return (std::fabs(along) < 0.5 * (g.length + h.length * cosine) - 0.007 && across < large + 0.5 * small) ||
         (std::fabs(along_h) < 0.5 * h.length && across_h < large);
}

/// Whether h is g's, which grows when h goes on where it ends. `likely`: parts that may lie between them, and that g
/// does not grow over.
bool takes(PartCandidate& g, const PartCandidate& h, const std::vector<PartCandidate>& likely,
           const Conditions& conditions) {
  if (!g.handle.path.empty() && of_bow(g.handle, h.handle)) return add_members(h.handle, g.handle), true;
  if (g.handle.path.empty() && !h.handle.path.empty() && of_bow(h.handle, g.handle)) {
    // One of its pieces is surer than the bow's middle. That is where it is held; the piece that is there is fitted
    // better.
    if (norm(g.handle.center - h.handle.center) < 0.5 * g.handle.length &&
        std::fabs(dot(g.handle.axis, h.handle.axis)) > kCosContinue) {
      g.handle.path = h.handle.path;
      return add_members(h.handle, g.handle), true;
    }
    Handle middle = h.handle;
    middle.confidence = g.handle.confidence;
    add_members(g.handle, middle);
    g.handle = std::move(middle);
    return true;
  }
  if (!g.handle.path.empty() || !h.handle.path.empty() || !conditions.continue_parts || !continues(g, h)) {
    return overlaps(g.handle, h.handle);
  }
  for (const PartCandidate& o : likely) {
    if (parts(g.handle, h.handle, o.handle)) return false;
  }
  // What is hardly a part itself makes no other one longer: its middle, where it is held, would move.
  if (h.handle.confidence < kExtends) return true;
  PartCandidate longer = g;
  extend(longer, h);
  const bool over = std::any_of(likely.begin(), likely.end(), [&](const PartCandidate& o) {
    return o.handle.confidence > h.handle.confidence && differs(g.handle, o.handle) &&
           overlaps(longer.handle, o.handle) && !overlaps(g.handle, o.handle);
  });
  if (!over) g = std::move(longer);
  return true;
}

/// Position, axis and radius of affordances, in single precision, as separate arrays.
struct Rows {
  std::vector<float> x, y, z, ax, ay, az, radius;
  explicit Rows(const std::vector<Affordance>& affordances) {
    for (const Affordance& a : affordances) {
      const auto add = [](std::vector<float>& to, double value) { to.push_back(static_cast<float>(value)); };
      add(x, a.center[0]), add(y, a.center[1]), add(z, a.center[2]);
      add(ax, a.axis[0]), add(ay, a.axis[1]), add(az, a.axis[2]);
      add(radius, a.radius);
    }
  }
};

/// Which of them may be members of the seed's group, where single precision is wrong by less than `slack` (m). A loop
/// on arrays that share no memory: the compiler takes several at a time.
void may_be_members(const Rows& rows, std::size_t seed, float slack, std::int32_t* __restrict out) {
  const float* __restrict x = rows.x.data(), * __restrict y = rows.y.data(), * __restrict z = rows.z.data();
  const float* __restrict ax = rows.ax.data(), * __restrict ay = rows.ay.data(), * __restrict az = rows.az.data();
  const float* __restrict radius = rows.radius.data();
  const float x0 = x[seed], y0 = y[seed], z0 = z[seed], ux = ax[seed], uy = ay[seed], uz = az[seed], r0 = radius[seed];
  const float reach = static_cast<float>(kReach) + slack, cosine = static_cast<float>(kCosAlign) - 1e-5f;
  const float offset = static_cast<float>(kOffsetShare) * r0 + static_cast<float>(kOffset) + slack;
  const float change = static_cast<float>(kRadiusShare) * r0 + static_cast<float>(kRadius) + slack;
  const float offset2 = offset * offset;
  for (std::size_t i = 0; i < rows.x.size(); ++i) {
    const float dx = x[i] - x0, dy = y[i] - y0, dz = z[i] - z0;
    const float along = dx * ux + dy * uy + dz * uz;
    const float bx = dx - along * ux, by = dy - along * uy, bz = dz - along * uz;
    out[i] = (std::fabs(along) <= reach) & (std::fabs(ax[i] * ux + ay[i] * uy + az[i] * uz) >= cosine) &
             (bx * bx + by * by + bz * bz <= offset2) & (std::fabs(radius[i] - r0) <= change);
  }
}

}  // namespace

/// Of parts on the same place the likeliest one stays, of sure ones the longest; pieces of one part become one.
void PartSearch::resolve() {
  std::sort(all_.begin(), all_.end(), [](const PartCandidate& a, const PartCandidate& b) {
    const Handle &g = a.handle, &h = b.handle;
    // A short piece in the bend of a bow is as sure as the straight piece beside it, and explains it less.
    const double sure_g = std::min(g.confidence, kSure), sure_h = std::min(h.confidence, kSure);
    if (sure_g != sure_h) return sure_g > sure_h;
    if (g.length != h.length) return g.length > h.length;
    return g.confidence != h.confidence ? g.confidence > h.confidence : g.affordances < h.affordances;
  });
  kept_.clear();
  likely_.clear();
  for (const PartCandidate& candidate : all_) {
    if (candidate.handle.confidence >= kLikely) likely_.push_back(candidate);
  }
  for (PartCandidate& candidate : all_) {
    bool explained = false;
    for (std::size_t i = 0; i < kept_.size() && !explained; ++i) {
      explained = takes(kept_[i], candidate, likely_, conditions_);
    }
    if (!explained) kept_.push_back(std::move(candidate));
  }
  // What has grown meanwhile may reach others.
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    for (std::size_t k = i + 1; k < kept_.size();) {
      if (!takes(kept_[i], kept_[k], likely_, conditions_)) {
        ++k;
        continue;
      }
      kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(k));
      k = i + 1;
    }
  }
}

/// Groups about the best affordances first. An affordance may be in several: which one is right the points decide.
void PartSearch::make_groups(const std::vector<Affordance>& affordances) {
  groups_.clear();
  const std::size_t n = affordances.size();
  std::vector<std::uint8_t> uses(n, 0);
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return affordances[a].quality != affordances[b].quality ? affordances[a].quality > affordances[b].quality : a < b;
  });
  const auto least = static_cast<std::size_t>(options_->handle_min_affordances);
  std::vector<std::pair<double, std::uint32_t>> members;
  const Rows rows(affordances);
  double farthest = 0;
  for (const Affordance& a : affordances) farthest = std::max(farthest, norm(a.center));
  const auto slack = static_cast<float>(1e-5 + 0x1p-20 * farthest);
  std::vector<std::int32_t> near(n);
  for (const std::uint32_t seed : order) {
    if (uses[seed] >= kMostUses) continue;
    const Affordance& s = affordances[seed];
    members.clear();
    may_be_members(rows, seed, slack, near.data());
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

    PartGroup group;
    Vector3 axis{}, center{};
    double weight = 0;
    std::vector<double> radii, widths;
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
    if (2 * group.straps >= radii.size()) radii = std::move(widths);
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
    groups_.push_back(std::move(group));
  }
}

void PartSearch::run(const std::vector<Affordance>& affordances, const TileStore& tiles, const NeighbourIndex& index,
                     const DepthImage& image, std::vector<Handle>& handles, Funnel& funnel) {
  make_groups(affordances);
  if (conditions_.bows) find_bows(affordances, image, groups_, bows_);
  found_.resize(std::max(found_.size(), groups_.size()));
  for (std::vector<PartCandidate>& found : found_) found.clear();
  for (PartCheck& check : checks_) check.begin(*options_, tiles, index, image, conditions_);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, groups_.size(), 1),
      [&](const auto& range) {
        bool exists = false;
        PartCheck& check = checks_.local(exists);
        if (!exists) check.begin(*options_, tiles, index, image, conditions_);
        for (std::size_t g = range.begin(); g < range.end(); ++g) check.run(groups_[g], affordances, found_[g]);
      },
      tbb::simple_partitioner());
  std::vector<std::uint8_t> fate(affordances.size(), kNotAligned);
  all_.clear();
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    for (const std::uint32_t i : groups_[g].members) fate[i] = kUnconfirmed;
    for (PartCandidate& candidate : found_[g]) all_.push_back(std::move(candidate));
  }
  for (const PartCandidate& candidate : all_) {
    const Handle& h = candidate.handle;
    const std::uint8_t to = h.confidence < options_->effective_min_confidence() ? kLowConfidence : kInHandle;
    for (const std::uint32_t i : h.affordances) fate[i] = std::max(fate[i], to);
  }
  resolve();
  handles.clear();
  for (const PartCandidate& candidate : kept_) {
    if (candidate.handle.confidence < options_->effective_min_confidence()) continue;
    handles.push_back(candidate.handle);
    Handle& h = handles.back();
    if (h.path.empty()) continue;
    h.length = 0;
    for (std::size_t i = 0; i + 1 < h.path.size(); ++i) h.length += norm(h.path[i + 1] - h.path[i]);
  }
  if (conditions_.join_curved) join_curved(handles);
  for (const std::uint8_t f : fate) {
    ++(f == kNotAligned      ? funnel.not_aligned
       : f == kUnconfirmed   ? funnel.unconfirmed
       : f == kLowConfidence ? funnel.low_confidence
                             : funnel.in_handles);
  }
}

}  // namespace handhold
