#include "bend.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "kernels.h"

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

/// Directions in the image; the opposite ones are looked at, too.
constexpr std::size_t kWays = 4;
constexpr float kWayColumn[kWays] = {1.0f, 0.0f, 0.7071f, 0.7071f}, kWayRow[kWays] = {0.0f, 1.0f, 0.7071f, -0.7071f};

}  // namespace

bool bends(const DepthImage& image, const Vector3& place, double reach) {
  const DepthImage::Projected p = image.project(place);
  if (!(p.depth > 0.05)) return true;
  const double u = p.a / p.depth + 0.5, v = p.b / p.depth + 0.5;
  const double here = inverse_depth(image, u, v);
  if (!(here > 0) || std::fabs(1 / here - p.depth) > kSame) return true;
  const double noise = kNoise * depth_noise(p.depth), per_metre = image.focal() / p.depth;
  // On a plane the inverse depth is linear in the pixels: its second differences tell of a bulge.
  constexpr std::size_t kPairs = std::size(kBeside) * kWays;
  kernels::PlaceQuery q{image.pixels(), image.width(), image.height(), {}, {}};
  static_assert(2 * kPairs == std::size(q.column));
  double most[std::size(kBeside)];
  for (std::size_t i = 0; i < std::size(kBeside); ++i) {
    const double w = kBeside[i], step = w * per_metre;
    if (step < 2) return true;
    most[i] = 2 * (std::max(kLeast, kShare * w * w / (2 * reach)) + noise) * here * here;
    for (std::size_t k = 0; k < kWays; ++k) {
      const std::size_t at = i * kWays + k;
      const float du = static_cast<float>(step) * kWayColumn[k], dv = static_cast<float>(step) * kWayRow[k];
      q.column[at] = static_cast<float>(u) + du, q.row[at] = static_cast<float>(v) + dv;
      q.column[kPairs + at] = static_cast<float>(u) - du, q.row[kPairs + at] = static_cast<float>(v) - dv;
    }
  }
  float beside[2 * kPairs];
  kernels::kernels().inverse_depths(q, beside);
  for (std::size_t at = 0; at < kPairs; ++at) {
    if (2 * here - static_cast<double>(beside[at]) - static_cast<double>(beside[kPairs + at]) > most[at / kWays])
      return true;
  }
  return false;
}

}  // namespace handhold
