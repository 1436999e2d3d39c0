#include "handhold/tracker.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "axis.h"
#include "vec3.h"

namespace handhold {
namespace {

constexpr double kGuessStep = 0.015;  ///< m
/// A handle's middle moves along its part from frame to frame, as clutter and noise cut it: that counts so much less.
constexpr double kAlongShare = 0.3;
/// What a radian between the axes and a metre between the radii count beside a metre of distance.
constexpr double kAngleCost = 0.03, kRadiusCost = 1;

Vector3 turned(const Motion& motion, const Vector3& v) {
  Vector3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) out[i] += motion.R[3 * i + k] * v[k];
  return out;
}
Vector3 moved(const Motion& motion, const Vector3& p) {
  return turned(motion, p) + motion.t;
}

void move(const Motion& motion, Handle& h) {
  h.center = moved(motion, h.center);
  h.axis = canonical_axis(turned(motion, h.axis));
  h.approach = turned(motion, h.approach);
  for (Vector3& p : h.path) p = moved(motion, p);
}

void shift(const Vector3& by, Handle& h) {
  h.center = h.center + by;
  for (Vector3& p : h.path) p = p + by;
}

double mix(double old_value, double new_value, double weight) {
  return old_value + weight * (new_value - old_value);
}

[[noreturn]] void fail(const char* name, double value, const char* valid) {
  throw OptionError(std::string(name) + " = " + std::to_string(value) + ": must be " + valid);
}

}  // namespace

void TrackerOptions::validate() const {
  if (!(max_offset > 0 && max_offset <= 10)) fail("max_offset", max_offset, "above 0 and at most 10 m");
  if (!(max_angle > 0 && max_angle <= 1.5708)) fail("max_angle", max_angle, "above 0 and at most 1.5708 rad");
  if (!(max_radius > 0 && max_radius <= 1)) fail("max_radius", max_radius, "above 0 and at most 1");
  if (!(weight > 0 && weight <= 1)) fail("weight", weight, "above 0 and at most 1");
  if (!(keep >= 0 && keep <= 1'000'000)) fail("keep", keep, "between 0 and 1000000");
}

Tracker::Tracker(const TrackerOptions& options) : options_(options) {
  options.validate();
}

/// How far a handle is from where a track is expected, all counted in metres; negative: it is another one.
double Tracker::difference(const Handle& g, const Handle& h) const {
  const Vector3 d = h.center - g.center;
  const double angle = std::acos(std::min(1.0, std::fabs(dot(g.axis, h.axis))));
  const double along = dot(d, g.axis), across = norm(d - along * g.axis);
  const double radii = std::fabs(g.radius - h.radius);
  // Along the part as far as both of them reach.
  const double reach = std::max(options_.max_offset, 0.5 * std::max(g.length, h.length));
  if (!(across <= options_.max_offset && std::fabs(along) <= reach && angle <= options_.max_angle)) return -1;
  if (!(radii <= options_.max_radius * std::max(g.radius, h.radius))) return -1;
  return across + kAlongShare * std::fabs(along) + kAngleCost * angle + kRadiusCost * radii;
}

const std::vector<Track>& Tracker::update(const std::vector<Handle>& handles, const Motion& T_now_last) {
  for (Track& track : tracks_) {
    move(T_now_last, track.handle);
    track.velocity = turned(T_now_last, track.velocity);
    shift(track.velocity, track.handle);
    // What is not seen is not followed far.
    if (track.unseen > 0) track.velocity = 0.5 * track.velocity;
    ++track.unseen;
  }
  pairs_.clear();
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    for (std::size_t i = 0; i < handles.size(); ++i) {
      const double cost = difference(tracks_[t].handle, handles[i]);
      if (cost >= 0) pairs_.push_back({cost, t, i});
    }
  }
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    if (a.cost != b.cost) return a.cost < b.cost;
    return a.track != b.track ? a.track < b.track : a.handle < b.handle;
  });
  taken_.assign(handles.size(), 0);
  const double w = options_.weight;
  for (const Pair& pair : pairs_) {
    Track& track = tracks_[pair.track];
    if (track.unseen == 0 || taken_[pair.handle]) continue;
    taken_[pair.handle] = 1;
    track.unseen = 0, ++track.age;
    const Handle before = track.handle;
    Handle& h = track.handle;
    h = handles[pair.handle];
    const Vector3 away = h.center - before.center;
    h.center = before.center + w * away;
    track.velocity = track.velocity + (w * w / (2 - w)) * away;
    const Vector3 same_way = dot(before.axis, h.axis) < 0 ? -1.0 * h.axis : h.axis;
    h.axis = canonical_axis(normalized(before.axis + w * (same_way - before.axis), h.axis));
    // Across the axis, whatever the mean of both directions is.
    const Vector3 approach = before.approach + w * (h.approach - before.approach);
    h.approach = normalized(approach - dot(approach, h.axis) * h.axis, h.approach);
    h.radius = mix(before.radius, h.radius, w), h.length = mix(before.length, h.length, w);
    h.confidence = mix(before.confidence, h.confidence, w);
  }
  // One that is not seen where another one is seen was a piece of it.
  const auto over = [&](const Track& track) {
    if (track.unseen == 0) return false;
    return track.unseen > options_.keep || std::any_of(tracks_.begin(), tracks_.end(), [&](const Track& other) {
             return other.unseen == 0 && difference(track.handle, other.handle) >= 0;
           });
  };
  ended_.clear();
  for (const Track& track : tracks_) ended_.push_back(over(track));
  std::size_t kept = 0;
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    if (ended_[t]) continue;
    if (kept != t) std::swap(tracks_[kept], tracks_[t]);
    ++kept;
  }
  tracks_.resize(kept);
  for (std::size_t i = 0; i < handles.size(); ++i) {
    if (taken_[i]) continue;
    Track track;
    track.id = next_id_++, track.handle = handles[i], track.age = 1;
    tracks_.push_back(std::move(track));
  }
  return tracks_;
}

void Tracker::guesses(std::vector<Vector3>& places, const Motion& T_next_now) const {
  places.clear();
  for (const Track& track : tracks_) {
    const Handle& h = track.handle;
    const auto next = [&](const Vector3& p) { return moved(T_next_now, p + track.velocity); };
    if (!h.path.empty()) {
      for (const Vector3& p : h.path) {
        if (places.empty() || norm(next(p) - places.back()) >= kGuessStep) places.push_back(next(p));
      }
      continue;
    }
    const int n = std::max(1, static_cast<int>(std::lround(h.length / kGuessStep)));
    for (int i = 0; i < n; ++i) {
      const double along = h.length * ((i + 0.5) / n - 0.5);
      places.push_back(next(h.center + along * h.axis));
    }
  }
}

}  // namespace handhold
