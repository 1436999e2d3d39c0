// The two finger boxes against every triangle near them. For one approach both fingers slide in the same beam along u,
// so each triangle, clipped to the beam, forbids one interval of finger positions: no sampling, nothing is too thin.
#include "handhold/grasp_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "ray_caster.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kDirections = 24;      // steps of 15 degrees
constexpr double kNearest = 0.7;     // of the radius: least distance of a finger to the axis
constexpr double kTip = 0.3;         // of the radius: how far the fingertips stand beyond the axis ...
constexpr double kLeastTip = 0.003;  // m; ... but at least this
// The palm joins the fingers behind the part: at their base, or behind a part that is thicker than they are long.
constexpr double kPalm = 1.3;        // of the radius
constexpr double kPalmRoom = 0.005;  // m
constexpr double kSheet = 1e-4;      // m; the palm's thickness: only what passes between the fingers matters
constexpr double kNoLength = 1e-12;  // m

/// How far the direction that came closest got.
enum Stage { kNoRoom, kTooWide, kNoPalm, kNothingThere };
constexpr const char* kReasons[] = {"no room for the fingers", "too wide for the hand", "no room for the palm",
                                    "nothing between the fingers"};

/// Part of a triangle between the planes that bound the fingers' width, seen along the axis.
struct Slice {
  std::array<Point2, 5> points;  // m; about the center, along two directions across the axis
  int size = 0;
  std::int32_t object = -1;
};

/// The part of a triangle with |z| < half; corners are (x, y, z). Empty when it only touches a plane.
Slice slice(const std::array<Vector3, 3>& corners, double half) {
  std::array<Vector3, 5> in = {corners[0], corners[1], corners[2]}, out;
  int n = 3;
  for (const double side : {1.0, -1.0}) {
    int m = 0;
    for (int i = 0; i < n; ++i) {
      const Vector3 &a = in[static_cast<std::size_t>(i)], &b = in[static_cast<std::size_t>((i + 1) % n)];
      const double da = half - side * a[2], db = half - side * b[2];
      if (da > 0) out[static_cast<std::size_t>(m++)] = a;
      if ((da > 0) != (db > 0)) out[static_cast<std::size_t>(m++)] = a + (da / (da - db)) * (b - a);
    }
    in = out;
    n = m;
    if (n < 2) return {};
  }
  Slice result;
  result.size = n;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) result.points[i] = {in[i][0], in[i][1]};
  return result;
}

struct Interval {
  double low, high;
  std::int32_t object;
};

/// A slice in the frame of one approach.
struct Turned {
  std::array<double, 5> s, v;  // m; along the approach, along u
  std::size_t size;
  double low = HUGE_VAL, high = -HUGE_VAL;  // of s
  std::int32_t object;

  Turned(const Slice& slice, const Point2& approach)
      : size(static_cast<std::size_t>(slice.size)), object(slice.object) {
    for (std::size_t i = 0; i < size; ++i) {
      const Point2& p = slice.points[i];
      s[i] = p[0] * approach[0] + p[1] * approach[1];
      v[i] = p[1] * approach[0] - p[0] * approach[1];  // u = axis x approach
      low = std::min(low, s[i]);
      high = std::max(high, s[i]);
    }
  }

  /// Range along u of what lies between two distances along the approach; false when there is none, or it only touches.
  bool range(double from, double to, Interval& range) const {
    if (high <= from || low >= to) return false;
    range = {HUGE_VAL, -HUGE_VAL, object};
    const auto extend = [&range](double at) {
      range.low = std::min(range.low, at);
      range.high = std::max(range.high, at);
    };
    for (std::size_t i = 0, before = size - 1; i < size; before = i++) {
      if (s[i] > from && s[i] < to) extend(v[i]);
      for (const double bound : {from, to}) {
        if ((s[before] < bound && s[i] > bound) || (s[before] > bound && s[i] < bound)) {
          extend(v[before] + (bound - s[before]) / (s[i] - s[before]) * (v[i] - v[before]));
        }
      }
    }
    return range.low <= range.high;
  }
};

/// Distances (m) of a finger's pad to the axis at which it stands free.
struct Free {
  double from, to;
};

/// What the fingers of one side can do. `taken`: where surfaces are, as distances on this side.
template <class Inside>
std::vector<Free> free_positions(std::vector<Interval>& taken, double from, double to, double thickness,
                                 const Inside& pad_inside, std::int32_t& last_object) {
  std::sort(taken.begin(), taken.end(), [](const Interval& a, const Interval& b) { return a.low < b.low; });
  std::vector<Free> result;
  double at = from;
  // Between two surfaces the finger stands either free or within a solid: one point decides.
  const auto gap = [&](double end) {
    if (end >= at && !pad_inside(at + thickness / 2)) result.push_back({at, end});
  };
  for (const Interval& t : taken) {
    if (t.high <= at) continue;
    if (t.low - thickness > to) break;
    if (t.low - thickness >= at) gap(t.low - thickness);
    at = t.high;
    last_object = t.object;
    if (at > to) return result;
  }
  gap(to);
  return result;
}

/// Pairs of distances (left, right) that the hand can take, closest first.
std::vector<std::array<double, 2>> pairs(const std::vector<Free>& left, const std::vector<Free>& right,
                                         const Hand& hand) {
  std::vector<std::array<double, 2>> result;
  for (const Free& l : left) {
    for (const Free& r : right) {
      if (l.from + r.from > hand.aperture || l.to + r.to < hand.minimum) continue;
      const double more = std::max(0.0, hand.minimum - l.from - r.from), first = std::min(more, l.to - l.from);
      result.push_back({l.from + first, r.from + (more - first)});
    }
  }
  std::sort(result.begin(), result.end(), [](const auto& x, const auto& y) { return x[0] + x[1] < y[0] + y[1]; });
  return result;
}

[[noreturn]] void refuse(const char* what, double value, const char* valid) {
  throw std::invalid_argument("hand: " + std::string(what) + " = " + std::to_string(value) + ": must be " + valid);
}

}  // namespace

void Hand::validate() const {
  if (!(std::isfinite(aperture) && aperture > 0)) refuse("aperture", aperture, "above 0 m");
  if (!(minimum >= 0 && minimum <= aperture)) refuse("minimum", minimum, "between 0 and the aperture (m)");
  if (!(std::isfinite(finger_thickness) && finger_thickness > 0)) {
    refuse("finger_thickness", finger_thickness, "above 0 m");
  }
  if (!(std::isfinite(finger_width) && finger_width > 0)) refuse("finger_width", finger_width, "above 0 m");
  if (!(std::isfinite(finger_depth) && finger_depth > 0)) refuse("finger_depth", finger_depth, "above 0 m");
}

struct GraspCheck::Impl {
  explicit Impl(const Scene& s) : scene(s), caster(scene) {}

  Scene scene;
  RayCaster caster;

  /// What lies in the slab |z| < half (m) around `center`, in the frame e1, e2, a; all of it within `reach` of a, and
  /// more.
  std::vector<Slice> slices(const Vector3& center, const Vector3& e1, const Vector3& e2, const Vector3& a, double half,
                            double reach) const {
    std::vector<Slice> result;
    caster.near(center, std::hypot(reach, half), [&](std::int32_t object, std::uint32_t triangle) {
      const Mesh& mesh = scene.objects[static_cast<std::size_t>(object)].mesh;
      std::array<Vector3, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3 p = mesh.vertices[mesh.triangles[triangle][k]] - center;
        corners[k] = {dot(p, e1), dot(p, e2), dot(p, a)};
      }
      Slice s = slice(corners, half);
      s.object = object;
      if (s.size > 0) result.push_back(s);
    });
    return result;
  }

  bool inside(const Vector3& p) const {
    // A ray may pass an edge and count it twice; three directions in general position outvote one such mistake.
    static constexpr Vector3 kRays[] = {
        {0.5377, 0.2719, 0.7981}, {-0.6123, 0.7459, 0.2621}, {0.1931, -0.8427, -0.5026}};
    int votes = 0;
    for (const Vector3& direction : kRays) {
      int winding = 0;
      for (const Crossing& c : caster.crossings(p, direction)) winding += c.entering ? -1 : 1;
      votes += winding > 0;
    }
    return votes >= 2;
  }
};

GraspCheck::GraspCheck(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
GraspCheck::~GraspCheck() = default;

bool GraspCheck::inside(const Vector3& p) const {
  return impl_->inside(p);
}

GraspVerdict GraspCheck::check(const Vector3& center, const Vector3& axis, double radius, const Hand& hand) const {
  return search(center, axis, radius, hand, false);
}

bool GraspCheck::fits(const Vector3& center, const Vector3& axis, double radius, const Hand& hand) const {
  return search(center, axis, radius, hand, true).fits;
}

GraspVerdict GraspCheck::search(const Vector3& center, const Vector3& axis, double radius, const Hand& hand,
                                bool any) const {
  hand.validate();
  if (!std::isfinite(dot(center, center)) || !std::isfinite(radius) || radius < 0) {
    throw std::invalid_argument("grasp check: center and radius must be finite and the radius not negative");
  }
  if (!std::isfinite(norm(axis)) || !(norm(axis) > kNoLength)) {
    throw std::invalid_argument("grasp check: the axis must be a direction; it has no length");
  }
  const double nearest = kNearest * radius, farthest = hand.aperture - nearest;
  if (nearest > farthest) return {false, {0, 0, 0}, 0, kReasons[kTooWide], -1};
  const double tip = std::max(kLeastTip, kTip * radius), base = tip - hand.finger_depth;
  const double palm = std::min(base, -(kPalm * radius + kPalmRoom));

  const Vector3 a = unit(axis);
  const Vector3 e1 = unit(std::abs(a[0]) < 0.8 ? cross(a, {1, 0, 0}) : cross(a, {0, 1, 0})), e2 = cross(a, e1);
  const std::vector<Slice> slices = impl_->slices(center, e1, e2, a, hand.finger_width / 2,
                                                  std::hypot(farthest + hand.finger_thickness, std::max(tip, -palm)));

  GraspVerdict verdict;
  Stage best = kNoRoom;
  std::vector<int> in_the_way(impl_->scene.objects.size(), 0);
  std::vector<Interval> taken[2], behind;
  for (int step = 0; step < kDirections; ++step) {
    const double angle = 2 * kPi * step / kDirections;
    const Point2 p = {std::cos(angle), std::sin(angle)}, u = {-p[1], p[0]};  // u = axis x approach
    const Vector3 approach = p[0] * e1 + p[1] * e2, across = u[0] * e1 + u[1] * e2;
    taken[0].clear();
    taken[1].clear();
    behind.clear();
    for (const Slice& slice : slices) {
      const Turned turned(slice, p);
      Interval range;
      if (turned.range(palm - kSheet, palm, range)) behind.push_back(range);
      if (!turned.range(base, tip, range)) continue;
      if (range.high > 0) taken[0].push_back(range);
      if (range.low < 0) taken[1].push_back({-range.high, -range.low, range.object});
    }
    std::vector<Free> free[2];
    for (int side = 0; side < 2; ++side) {
      const Vector3 middle = center + ((tip + base) / 2) * approach, outwards = (side == 0 ? 1.0 : -1.0) * across;
      std::int32_t last = -1;
      free[side] = free_positions(
          taken[side], nearest, farthest, hand.finger_thickness,
          [&](double distance) { return impl_->inside(middle + distance * outwards); }, last);
      if (free[side].empty() && last >= 0) ++in_the_way[static_cast<std::size_t>(last)];
    }
    if (free[0].empty() || free[1].empty()) continue;
    best = std::max(best, kTooWide);
    for (const auto& [left, right] : pairs(free[0], free[1], hand)) {
      // Round parts have the same opening all around: the first direction stays, whatever rounding does.
      if (verdict.fits && left + right > verdict.opening - 1e-6) break;
      const auto between = std::find_if(behind.begin(), behind.end(), [left = left, right = right](const Interval& b) {
        return b.high > -right && b.low < left;
      });
      if (between != behind.end()) {
        best = std::max(best, kNoPalm);
        ++in_the_way[static_cast<std::size_t>(between->object)];
      } else if (impl_->inside(center) || impl_->caster.blocked(center - right * across, center + left * across)) {
        verdict = {true, approach, left + right, "", -1};
        if (any) return verdict;
      } else {
        best = kNothingThere;
      }
    }
  }
  if (verdict.fits) return verdict;
  verdict.reason = kReasons[best];
  const auto most = std::max_element(in_the_way.begin(), in_the_way.end());
  if ((best == kNoRoom || best == kNoPalm) && most != in_the_way.end() && *most > 0) {
    verdict.blocked_by = static_cast<std::int32_t>(most - in_the_way.begin());
  }
  return verdict;
}

}  // namespace handhold::sensor
