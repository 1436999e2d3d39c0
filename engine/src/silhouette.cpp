#include "silhouette.h"

#include <algorithm>
#include <cmath>

namespace handhold {
namespace {

/// How far from the place itself the surface may be, beside its noise (m).
constexpr double kNear = 0.006;

}  // namespace

SilhouetteSide silhouette_side(const DepthImage& image, const Vector3& place, const Vector3& side, const Vector3& ahead,
                               double reach, double sigma) {
  SilhouetteSide result;
  const DepthImage::Projected from = image.project(place), along = image.project_direction(side);
  if (!(from.depth > 0.02)) return result;
  const double u0 = from.a / from.depth, v0 = from.b / from.depth;
  const double per_metre =
      std::hypot(along.a - u0 * along.depth, along.b - v0 * along.depth) / from.depth;  // pixels, at the place
  if (!(per_metre > 1)) return result;
  const Vector3 to_place = place - image.viewpoint();
  // How far ahead of the place what is seen beside it lies. Along a part that points towards the sensor depth changes
  // from pixel to pixel; across its axis it does not.
  const double lever = dot(to_place, ahead), noise = sigma * std::fabs(lever) / norm(to_place);
  const double jump = depth_step(noise), metres = 1 / per_metre;
  const auto seen = [&](int k, double& at, double& height) {
    at = k * metres;
    const DepthImage::Projected p = from + at * along;
    if (!(p.depth > 0.02)) return false;
    const double inverse = 1 / p.depth;
    const double z = image.depth_in(p.a * inverse + 0.5, p.b * inverse + 0.5);
    // side is across ahead.
    height = (z * inverse - 1) * lever;
    return z > 0;
  };
  double last = 0;
  if (!seen(0, result.at, last) || std::fabs(last) > kNear + 3 * noise) return result;
  double before = last;
  const int pixels = std::max(2, static_cast<int>(reach * per_metre));
  for (int k = 1; k <= pixels; ++k) {
    double at = 0, height = 0;
    const bool known = seen(k, at, height);
    result.at = at - 0.5 * metres;
    if (!known || height > last + jump) return result;
    // A pixel on the edge may mix both depths.
    if (height < last - jump || height < before - jump) {
      result.kind = SilhouetteSide::kStep;
      if (height >= last - jump) result.at -= 0.5 * metres;
      const double edge = std::max(last, before);
      double fall = std::max(0.0, edge - height);
      for (std::size_t i = 0; i < kLooksBeyond; ++i) {
        const int more = i == 0 ? 1 : std::max(1, static_cast<int>(std::lround(kBeyondStep[i - 1] * per_metre)));
        double there = 0, beyond = 0;
        if (seen(k + more, there, beyond)) fall = edge - beyond;
        result.fall[i] = fall;
      }
      return result;
    }
    before = last, last = height;
  }
  result.kind = SilhouetteSide::kSurface;
  return result;
}

}  // namespace handhold
