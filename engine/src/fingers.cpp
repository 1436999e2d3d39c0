#include "fingers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels.h"

namespace handhold {
namespace {

/// Steps of a finger's distance from the axis (m), and samples of its depth and width.
constexpr double kStep = 0.0015;
constexpr int kDepths = 6, kWidths = 3;
constexpr int kMostColumns = 96;
/// Most fingers find their place in the first columns, so that few look at all of them.
constexpr std::size_t kColumnsAtOnce = 16;
static_assert(kMostColumns % kColumnsAtOnce == 0);
/// Depths that differ by less count as the same surface (m).
constexpr double kTolerance = 0.003;
/// Play of a hand about the part, for the noise of the part's own points (m).
constexpr double kPlay = 0.002;

using Columns = std::array<float, kMostColumns>;

/// Counts places about one slice of a part: boxes with sides along the axis, along the approach and across both.
class Places {
 public:
  Places(const DepthImage& image, const Vector3& center, const Vector3& axis, double width)
      : image_(&image), first_(center - (0.35 * width) * axis) {
    query_.depth = image.pixels(), query_.width = image.width(), query_.height = image.height();
    query_.layers = kWidths;
    set(query_.along, image.project_direction(0.35 * width * axis));
  }

  /// `count` equal parts of the stretch from `low` to `high` (m from the axis) in a direction (unit).
  struct Side {
    Vector3 direction;
    double low, high;
    int count;
    double step() const { return (high - low) / count; }
    Vector3 first() const { return (low + 0.5 * step()) * direction; }
  };
  void box(const Side& columns, const Side& rows) {
    query_.rows = rows.count;
    set(query_.out, image_->project_direction(columns.step() * columns.direction));
    set(query_.up, image_->project_direction(rows.step() * rows.direction));
    set(query_.corner, image_->project(first_ + columns.first() + rows.first()));
  }

  /// Columns [first, first + 16): places of each behind which the sensor saw something, or nothing at all.
  void free(int first, Columns& columns) { count(first, kTolerance, columns); }
  /// Places of each column at which it saw nothing: free, or out of its sight.
  void not_seen(int first, Columns& columns) {
    Columns behind;
    count(first, kTolerance, columns);
    count(first, -kTolerance, behind);
    const auto all = static_cast<float>(query_.rows * query_.layers);
    for (auto c = static_cast<std::size_t>(first); c < static_cast<std::size_t>(first) + kColumnsAtOnce; ++c) {
      columns[c] += all - behind[c];
    }
  }

 private:
  static void set(float* to, const DepthImage::Projected& p) {
    to[0] = static_cast<float>(p.a), to[1] = static_cast<float>(p.b), to[2] = static_cast<float>(p.depth);
  }
  void count(int first, double tolerance, Columns& columns) {
    query_.first = first, query_.columns = first + static_cast<int>(kColumnsAtOnce);
    query_.tolerance = static_cast<float>(tolerance);
    kernels::kernels().free_places(query_, columns.data());
  }

  const DepthImage* image_;
  Vector3 first_;
  kernels::FreeQuery query_{};
};

}  // namespace

Grip FingerTest::at(const Vector3& center, const Vector3& axis, double radius, double width, double angle) const {
  Grip grip;
  const Vector3 to_sensor = image_->viewpoint() - center;
  const Vector3 v = to_sensor - dot(to_sensor, axis) * axis;
  if (!(norm(v) > 1e-6)) return grip;
  const Vector3 ahead = normalized(v), side = cross(axis, ahead);
  grip.angle = angle;
  grip.from = std::cos(angle) * ahead + std::sin(angle) * side;
  const Vector3 left = cross(axis, grip.from);

  // Fingers that do not reach the axis push the part away. The tips stand a little beyond it, so that the part is held
  // and not pinched away, unless the palm stops at the part before.
  const double depth = options_->finger_depth;
  if (radius > depth + kPlay) return grip;
  const double tip = std::min({std::max(0.003, 0.3 * radius), radius, std::max(0.0, depth - radius)});
  const double top = std::min(0.5 * radius, depth - tip);
  const double nearest = std::max(0.002, 0.8 * radius);
  const double farthest =
      std::min(options_->hand_aperture / 2 + kPlay, std::max(1.35 * radius, radius + 0.004) + kPlay);
  const int finger = std::max(1, static_cast<int>(std::lround(options_->finger_thickness / kStep)));
  const int first = static_cast<int>(nearest / kStep);
  const int columns = std::min(kMostColumns, static_cast<int>(farthest / kStep) + finger + 1 - first);
  if (columns < finger) return grip;

  const Vector3 outward[2] = {left, -1.0 * left};
  Places places(*image_, center, axis, width);
  double found[2] = {0, 0}, distance[2] = {0, 0};
  for (int k = 0; k < 2; ++k) {
    places.box({outward[k], first * kStep, (first + columns) * kStep, columns}, {grip.from, -tip, top, kDepths});
    Columns free;
    int sum = 0;
    bool open = false;
    for (int c = 0; c < columns; ++c) {
      if (c % static_cast<int>(kColumnsAtOnce) == 0) {
        conditions_.seen_empty ? places.free(c, free) : places.not_seen(c, free);
      }
      sum += static_cast<int>(free[static_cast<std::size_t>(c)]);
      if (c >= finger) sum -= static_cast<int>(free[static_cast<std::size_t>(c - finger)]);
      if (c + 1 < finger) continue;
      const double share = static_cast<double>(sum) / (kDepths * kWidths * finger);
      if (share >= options_->min_free) {
        open = true;
        found[k] = share;
        distance[k] = (first + c + 1 - finger) * kStep;
        break;
      }
    }
    if (!open) return grip;
  }
  grip.free = std::min(found[0], found[1]);
  grip.opening = distance[0] + distance[1];
  grip.fits = grip.opening <= options_->hand_aperture + 2 * kPlay;
  return grip;
}

Grip FingerTest::any(const Vector3& center, const Vector3& axis, double radius, double width) const {
  Grip grip;
  for (int i = 0; i < angles() && !grip.fits; ++i) grip = at(center, axis, radius, width, angle(i));
  return grip;
}

}  // namespace handhold
