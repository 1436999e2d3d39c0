#include "noise_field.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "random.h"

namespace handhold::sensor {
namespace {

/// Independent sets of random numbers (the second word of the counter).
enum Stream : std::uint32_t { kDepth = 0, kLook = 1, kSmooth = 2 };

constexpr double kTurn = 6.283185307179586;

/// Gaussian window of standard deviation `length` / 2 whose squares add up to 1: white noise keeps its variance, and
/// what comes out correlates over d pixels by exp(-(d / length)^2).
std::vector<float> window(double length) {
  const int reach = static_cast<int>(std::ceil(1.75 * length));
  std::vector<double> taps;
  double squares = 0;
  for (int k = -reach; k <= reach; ++k) {
    taps.push_back(k == 0 ? 1 : std::exp(-2 * (k / length) * (k / length)));
    squares += taps.back() * taps.back();
  }
  std::vector<float> result;
  for (const double tap : taps) result.push_back(static_cast<float>(tap / std::sqrt(squares)));
  return result;
}

double to_uniform_from_normal(double x) {
  return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

}  // namespace

NoiseField::NoiseField(const CameraOptions& options) : width_(options.width), seed_(options.seed) {
  const NoiseOptions& noise = options.noise;
  if (noise.correlation_u == 0 && noise.correlation_v == 0) return;
  const std::vector<float> along_u = window(noise.correlation_u), along_v = window(noise.correlation_v);
  // White noise reaches beyond the image by the windows' size, so that the border is like everything else.
  const auto wide = static_cast<std::uint32_t>(options.width + along_u.size() - 1);
  const auto tall = static_cast<std::uint32_t>(options.height + along_v.size() - 1);
  std::vector<Normals> rows(static_cast<std::size_t>(options.width) * tall);
  tbb::parallel_for(std::uint32_t{0}, tall, [&](std::uint32_t v) {
    std::vector<Normals> white(wide);
    for (std::uint32_t u = 0; u < wide; ++u) {
      const std::array<std::uint32_t, 4> bits = philox({v * wide + u, kSmooth, 0, 0}, seed_);
      for (int pair = 0; pair < 2; ++pair) {
        const double radius = std::sqrt(-2 * std::log(to_uniform(bits[2 * pair])));
        const double angle = kTurn * to_uniform(bits[2 * pair + 1]);
        white[u][2 * pair] = static_cast<float>(radius * std::cos(angle));
        white[u][2 * pair + 1] = static_cast<float>(radius * std::sin(angle));
      }
    }
    for (std::uint32_t u = 0; u < options.width; ++u) {
      Normals sum = {};
      for (std::size_t k = 0; k < along_u.size(); ++k) {
        for (int i = 0; i < 4; ++i) sum[i] += along_u[k] * white[u + k][i];
      }
      rows[static_cast<std::size_t>(v) * options.width + u] = sum;
    }
  });
  smooth_.resize(static_cast<std::size_t>(options.width) * options.height);
  tbb::parallel_for(std::uint32_t{0}, options.height, [&](std::uint32_t v) {
    for (std::uint32_t u = 0; u < options.width; ++u) {
      Normals sum = {};
      for (std::size_t k = 0; k < along_v.size(); ++k) {
        const Normals& normals = rows[(v + k) * options.width + u];
        for (int i = 0; i < 4; ++i) sum[i] += along_v[k] * normals[i];
      }
      smooth_[static_cast<std::size_t>(v) * options.width + u] = sum;
    }
  });
}

Draw NoiseField::at(std::uint32_t u, std::uint32_t v) const {
  const std::uint32_t pixel = v * width_ + u;
  const std::array<std::uint32_t, 4> depth = philox({pixel, kDepth, 0, 0}, seed_);
  const std::array<std::uint32_t, 4> look = philox({pixel, kLook, 0, 0}, seed_);
  Draw draw;
  draw.edge = to_uniform(depth[3]);
  draw.mixture = to_uniform(look[2]);
  if (smooth_.empty()) {
    draw.axial = to_normal(depth[1], depth[2]);
    draw.lateral = {to_normal(look[0], look[1]), to_normal(look[0], look[1] + 0x40000000u)};  // a quarter turn: sine
    draw.dropout = to_uniform(depth[0]);
  } else {
    const Normals& normals = smooth_[pixel];
    draw.axial = normals[0];
    draw.lateral = {normals[1], normals[2]};
    draw.dropout = to_uniform_from_normal(normals[3]);
  }
  return draw;
}

}  // namespace handhold::sensor
