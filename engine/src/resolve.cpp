#include "resolve.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "bow_groups.h"

namespace handhold {
namespace {

constexpr double kCosContinue = 0.9396926207859084;              ///< 20 degrees
constexpr double kOffsetContinue = 0.6, kOffset = 0.003;         ///< of the smaller radius, and m
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

/// Where g would end if it were as long as both (m; along its axis, from its center).
std::pair<double, double> both_ends(const Handle& g, const Handle& h) {
  const double along = dot(h.center - g.center, g.axis);
  return {std::min(-0.5 * g.length, along - 0.5 * h.length), std::max(0.5 * g.length, along + 0.5 * h.length)};
}

/// A straight part, whatever it was found by.
struct Stretch {
  Vector3 center, axis;
  double radius, length;
};
Stretch stretch_of(const Handle& h) {
  return {h.center, h.axis, h.radius, h.length};
}

/// Whether g, which is likelier, explains h.
bool overlaps(const Stretch& g, const Stretch& h) {
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

}  // namespace

void Resolver::add_members(const Handle& from, Handle& to) {
  members_.clear();
  std::set_union(to.affordances.begin(), to.affordances.end(), from.affordances.begin(), from.affordances.end(),
                 std::back_inserter(members_));
  to.affordances = members_;
}

/// Makes g as long as both.
void Resolver::extend(PartCandidate& first, const PartCandidate& second) {
  Handle& g = first.handle;
  const Handle& h = second.handle;
  const bool same_way = dot(g.axis, h.axis) > 0;
  const auto [low, high] = both_ends(g, h);
  if (low < -0.5 * g.length) first.ends_low = same_way ? second.ends_low : second.ends_high;
  if (high > 0.5 * g.length) first.ends_high = same_way ? second.ends_high : second.ends_low;
  g.center = g.center + 0.5 * (low + high) * g.axis;
  g.length = high - low;
  add_members(h, g);
}

/// Whether h is g's, which grows when h goes on where it ends.
bool Resolver::takes(PartCandidate& g, const PartCandidate& h) {
  if (!g.handle.path.empty() && of_bow(g.handle, h.handle)) return add_members(h.handle, g.handle), true;
  if (g.handle.path.empty() && !h.handle.path.empty() && of_bow(h.handle, g.handle)) {
    // One of its pieces is surer than the bow's middle. That is where it is held; the piece that is there is fitted
    // better.
    if (norm(g.handle.center - h.handle.center) < 0.5 * g.handle.length &&
        std::fabs(dot(g.handle.axis, h.handle.axis)) > kCosContinue) {
      g.handle.path = h.handle.path;
      return add_members(h.handle, g.handle), true;
    }
    const double confidence = g.handle.confidence;
    add_members(h.handle, g.handle);
    g.handle = h.handle;
    g.handle.affordances = members_;
    g.handle.confidence = confidence;
    return true;
  }
  if (!g.handle.path.empty() || !h.handle.path.empty() || !continue_parts_ || !continues(g, h)) {
    return overlaps(stretch_of(g.handle), stretch_of(h.handle));
  }
  for (const PartCandidate* o : likely_) {
    if (parts(g.handle, h.handle, o->handle)) return false;
  }
  // What is hardly a part itself makes no other one longer: its middle, where it is held, would move.
  if (h.handle.confidence < kExtends) return true;
  // Where g would be then.
  const auto [low, high] = both_ends(g.handle, h.handle);
  const Vector3 middle = g.handle.center + 0.5 * (low + high) * g.handle.axis;
  const Stretch longer{middle, g.handle.axis, g.handle.radius, high - low};
  const bool over = std::any_of(likely_.begin(), likely_.end(), [&](const PartCandidate* o) {
    return o->handle.confidence > h.handle.confidence && differs(g.handle, o->handle) &&
           overlaps(longer, stretch_of(o->handle)) && !overlaps(stretch_of(g.handle), stretch_of(o->handle));
  });
  if (!over) extend(g, h);
  return true;
}

void Resolver::run(std::vector<const PartCandidate*>& all, bool continue_parts, Recycled<PartCandidate>& kept) {
  continue_parts_ = continue_parts;
  std::sort(all.begin(), all.end(), [](const PartCandidate* a, const PartCandidate* b) {
    const Handle &g = a->handle, &h = b->handle;
    // A short piece in the bend of a bow is as sure as the straight piece beside it, and explains it less.
    const double sure_g = std::min(g.confidence, kSure), sure_h = std::min(h.confidence, kSure);
    if (sure_g != sure_h) return sure_g > sure_h;
    if (g.length != h.length) return g.length > h.length;
    return g.confidence != h.confidence ? g.confidence > h.confidence : g.affordances < h.affordances;
  });
  kept.clear();
  likely_.clear();
  for (const PartCandidate* candidate : all) {
    if (candidate->handle.confidence >= kLikely) likely_.push_back(candidate);
  }
  for (const PartCandidate* candidate : all) {
    bool explained = false;
    for (std::size_t i = 0; i < kept.size() && !explained; ++i) explained = takes(kept[i], *candidate);
    if (!explained) kept.next() = *candidate;
  }
  // What has grown meanwhile may reach others.
  for (std::size_t i = 0; i < kept.size(); ++i) {
    for (std::size_t k = i + 1; k < kept.size();) {
      if (!takes(kept[i], kept[k])) {
        ++k;
        continue;
      }
      kept.erase(k);
      k = i + 1;
    }
  }
  std::sort(kept.begin(), kept.end(), [](const PartCandidate& a, const PartCandidate& b) {
    const Handle &g = a.handle, &h = b.handle;
    return g.confidence != h.confidence ? g.confidence > h.confidence : g.affordances < h.affordances;
  });
}

}  // namespace handhold
