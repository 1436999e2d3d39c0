#include "bend.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace handhold {
namespace {

/// How far beside the place one looks: a thin part ends within the first, a thick one has sunk away at the second (m).
constexpr double kBeside[] = {0.010, 0.025};
constexpr double kSame = 0.02;  ///< m; depths that differ by less are of the place
/// Of the height that the thickest part has above the chord, how much counts; beside the noise, in standard deviations.
constexpr double kShare = 0.8, kNoise = 2;
constexpr double kLeast = 0.002;  ///< m

/// Mean inverse depth (1/m) about a pixel; 0: unknown or far. On a plane it is linear in the pixels, whatever its
/// slant.
double inverse_depth(const DepthImage& image, double u, double v) {
  double sum = 0;
  for (const auto& [du, dv] : {std::pair{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    const double z = image.depth_in(u + du, v + dv);
    if (!(z > 0)) return 0;
    sum += 1 / z;
  }
  return 0.2 * sum;
}

}  // namespace

bool bends(const DepthImage& image, const Vector3& place, double reach) {
  const DepthImage::Projected p = image.project(place);
  if (!(p.depth > 0.05)) return true;
  const double u = p.a / p.depth + 0.5, v = p.b / p.depth + 0.5;
  const double here = inverse_depth(image, u, v);
  if (!(here > 0) || std::fabs(1 / here - p.depth) > kSame) return true;
  const double noise = kNoise * depth_noise(p.depth), per_metre = image.focal() / p.depth;
  for (const double w : kBeside) {
    const double height = std::max(kLeast, kShare * w * w / (2 * reach)) + noise;
    const double least = 2 * height * here * here, step = w * per_metre;
    if (step < 2) return true;
    for (const auto& [du, dv] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {0.7071, 0.7071}, {0.7071, -0.7071}}) {
      const double a = inverse_depth(image, u + step * du, v + step * dv);
      const double b = inverse_depth(image, u - step * du, v - step * dv);
      if (2 * here - a - b > least) return true;
    }
  }
  return false;
}

}  // namespace handhold
