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
static_assert(kMostColumns % 16 == 0);
/// Depths that differ by less count as the same surface (m).
constexpr double kTolerance = 0.003;
/// Play of a hand about the part, for the noise of the part's own points (m).
constexpr double kPlay = 0.002;

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

  // The fingertips stand a little beyond the axis, so that the part is held and not pinched away.
  const double tip = std::min(std::max(0.003, 0.3 * radius), radius), top = 0.5 * radius;
  const double nearest = std::max(0.002, 0.8 * radius);
  const double farthest =
      std::min(options_->hand_aperture / 2 + kPlay, std::max(1.35 * radius, radius + 0.004) + kPlay);
  const int finger = std::max(1, static_cast<int>(std::lround(options_->finger_thickness / kStep)));
  const int first = static_cast<int>(nearest / kStep);
  const int columns = std::min(kMostColumns, static_cast<int>(farthest / kStep) + finger + 1 - first);
  if (columns < finger) return grip;

  const double lowest = 0.5 * (top + tip) / kDepths - tip;
  const DepthImage::Projected up = image_->project_direction(((top + tip) / kDepths) * grip.from);
  const DepthImage::Projected along = image_->project_direction(0.35 * width * axis);
  kernels::FreeQuery query;
  query.depth = image_->pixels(), query.width = image_->width(), query.height = image_->height();
  query.columns = columns, query.rows = kDepths, query.layers = kWidths;
  query.tolerance = static_cast<float>(kTolerance);
  const auto to_float = [](const DepthImage::Projected& p, float* to) {
    to[0] = static_cast<float>(p.a), to[1] = static_cast<float>(p.b), to[2] = static_cast<float>(p.depth);
  };
  to_float(up, query.up), to_float(along, query.along);
  double found[2] = {0, 0}, distance[2] = {0, 0};
  for (int k = 0; k < 2; ++k) {
    const Vector3 out = k == 0 ? left : -1.0 * left;
    to_float(image_->project(center + ((first + 0.5) * kStep) * out + lowest * grip.from - (0.35 * width) * axis),
             query.corner);
    to_float(image_->project_direction(kStep * out), query.out);
    std::array<float, kMostColumns> free;
    kernels::kernels().free_places(query, free.data());
    int sum = 0;
    bool open = false;
    for (int c = 0; c < columns; ++c) {
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
  for (int i = 0; i < kAngles && !grip.fits; ++i) grip = at(center, axis, radius, width, angle(i));
  return grip;
}

}  // namespace handhold
