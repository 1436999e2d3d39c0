// The cloud as a shaded surface: depth per pixel, holes closed, smoothed, lit. Part of picture.cpp.
#pragma once

#include <array>
#include <limits>

#include "canvas.h"
#include "projection.h"

namespace handhold {

constexpr Color kBackground{0.085f, 0.095f, 0.11f};

/// What a pixel sees: the depth (m; 0: nothing) and which point.
struct DepthMap {
  int width = 0, height = 0;
  std::vector<float> depth;
  std::vector<std::uint32_t> point;

  DepthMap(int w, int h)
      : width(w), height(h), depth(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)), point(depth.size()) {}
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  float at(int x, int y) const { return x < 0 || y < 0 || x >= width || y >= height ? 0.0f : depth[index(x, y)]; }
};

/// An organized cloud, pixel by pixel. factor: pixels of the picture for one of the cloud.
inline DepthMap depth_of_grid(const CloudView& cloud, const Projection& view, double factor, int width, int height) {
  DepthMap image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto u = static_cast<std::size_t>(x / factor), v = static_cast<std::size_t>(y / factor);
      if (u >= cloud.width || v >= cloud.height) continue;
      const std::size_t i = v * cloud.width + u;
      if (!finite_point(cloud.point(i))) continue;
      const double z = view.depth(to_vector(cloud.point(i)));
      if (!(z > 1e-6)) continue;
      image.depth[image.index(x, y)] = static_cast<float>(z);
      image.point[image.index(x, y)] = static_cast<std::uint32_t>(i);
    }
  }
  return image;
}

/// Any cloud: each point as a disc about as wide as the distance between neighbours, the nearest one wins.
inline DepthMap depth_of_points(const CloudView& cloud, const Projection& view, int width, int height) {
  DepthMap image(width, height);
  double u, v, z;
  const auto visible = [&](std::size_t i) {
    return finite_point(cloud.point(i)) && view.project(to_vector(cloud.point(i)), u, v, z) && u > -0.5 && v > -0.5 &&
           u < width - 0.5 && v < height - 0.5;
  };
  // How far points stand apart: the area that they cover, in coarse cells, shared among them.
  constexpr int kCell = 8;
  std::vector<char> cells(static_cast<std::size_t>((width / kCell + 1) * (height / kCell + 1)), 0);
  std::size_t seen = 0, covered = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!visible(i)) continue;
    ++seen;
    char& cell = cells[static_cast<std::size_t>(static_cast<int>(v + 0.5) / kCell * (width / kCell + 1) +
                                                static_cast<int>(u + 0.5) / kCell)];
    covered += cell == 0;
    cell = 1;
  }
  if (seen == 0) return image;
  const double spacing = std::sqrt(static_cast<double>(covered) * kCell * kCell / static_cast<double>(seen));
  const double radius = std::clamp(0.85 * spacing, 0.75, 5.0);
  const int reach = static_cast<int>(std::ceil(radius));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!visible(i)) continue;
    const int cx = static_cast<int>(std::lround(u)), cy = static_cast<int>(std::lround(v));
    for (int y = std::max(cy - reach, 0); y <= std::min(cy + reach, height - 1); ++y) {
      for (int x = std::max(cx - reach, 0); x <= std::min(cx + reach, width - 1); ++x) {
        if ((x - u) * (x - u) + (y - v) * (y - v) > radius * radius) continue;
        float& depth = image.depth[image.index(x, y)];
        if (depth > 0 && depth <= static_cast<float>(z)) continue;
        depth = static_cast<float>(z);
        image.point[image.index(x, y)] = static_cast<std::uint32_t>(i);
      }
    }
  }
  return image;
}

/// Fills pixels that see nothing between neighbours that do; of those the farthest counts, so that edges in front do
/// not grow.
inline void close_holes(DepthMap& image, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    const DepthMap before = image;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        if (before.depth[before.index(x, y)] > 0) continue;
        int count = 0;
        float farthest = 0;
        std::uint32_t point = 0;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            const float z = before.at(x + dx, y + dy);
            if (z <= 0) continue;
            ++count;
            if (z > farthest) farthest = z, point = before.point[before.index(x + dx, y + dy)];
          }
        }
        if (count < 5) continue;
        image.depth[image.index(x, y)] = farthest;
        image.point[image.index(x, y)] = point;
      }
    }
  }
}

/// Averages depths that belong together. A sensor's noise is coarser than the surface, and normals are slopes: without
/// this the picture shows the noise. Depths farther apart than `jump` (share of the depth) do not mix.
inline std::vector<float> smooth_depth(const DepthMap& image, int reach, float jump) {
  std::vector<float> now = image.depth, next(now.size());
  for (int pass = 0; pass < 4; ++pass) {  // rows, columns, and both again: close to a round window at its cost
    const int step_x = pass % 2 == 0, step_y = 1 - step_x;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const std::size_t i = image.index(x, y);
        const float z = now[i];
        next[i] = z;
        if (z <= 0) continue;
        const float per_jump = 1 / (jump * z);
        float sum = 0, weight = 0;
        for (int k = -reach; k <= reach; ++k) {
          const int u = x + k * step_x, v = y + k * step_y;
          if (u < 0 || v < 0 || u >= image.width || v >= image.height) continue;
          const float other = now[image.index(u, v)];
          const float apart = std::abs(other - z) * per_jump;
          if (other <= 0 || apart >= 1) continue;
          const float w = (1 - apart * apart) * static_cast<float>(reach + 1 - std::abs(k));
          sum += w * other;
          weight += w;
        }
        next[i] = sum / weight;
      }
    }
    now.swap(next);
  }
  return now;
}

class Shader {
 public:
  Shader(const Projection& view, const DepthMap& image, double scale)
      : view_(view),
        image_(image),
        reach_(std::max(1, static_cast<int>(std::lround(2 * scale)))),
        smooth_(smooth_depth(image, std::max(2, static_cast<int>(std::lround(4 * scale))), kJump)) {
    std::vector<double> depths;
    for (std::size_t i = 0; i < smooth_.size(); i += 7) {
      if (smooth_[i] > 0) depths.push_back(smooth_[i]);
    }
    if (depths.empty()) return;
    near_ = static_cast<float>(quantile(depths, 0.02));
    far_ = static_cast<float>(quantile(depths, 0.98));
  }

  /// own: the point's colour, if there is one.
  Color operator()(int x, int y, const Color* own) const {
    const float z = smooth_[image_.index(x, y)];
    const float t = far_ > near_ ? std::clamp((z - near_) / (far_ - near_), 0.0f, 1.0f) : 0.0f;
    const float light = lighting(x, y) * rim(x, y, z);
    if (own) return scaled(mix(*own, Color{0.55f, 0.57f, 0.6f}, 0.06f), 0.45f + 0.62f * light);
    return scaled(mix(Color{0.93f, 0.91f, 0.875f}, Color{0.42f, 0.49f, 0.575f}, t), 0.16f + 0.84f * light);
  }

 private:
  static constexpr float kJump = 0.02f;  // of the depth: 16 mm at 0.8 m

  float depth(int x, int y) const {
    return x < 0 || y < 0 || x >= image_.width || y >= image_.height ? 0.0f : smooth_[image_.index(x, y)];
  }

  // Slope of the surface along a direction in the image, from the neighbours that belong to it.
  bool tangent(int x, int y, int dx, int dy, Vector3& out) const {
    const float z = depth(x, y);
    const auto same = [&](float other) { return other > 0 && std::abs(other - z) < kJump * z; };
    const float before = depth(x - dx, y - dy), after = depth(x + dx, y + dy);
    const int from = same(before) ? -1 : 0, to = same(after) ? 1 : 0;
    if (from == to) return false;
    const auto position = [&](int k, float zk) { return add({0, 0, 0}, view_.ray(x + k * dx, y + k * dy), zk); };
    out = add(position(to, to ? after : z), position(from, from ? before : z), -1);
    return true;
  }

  float lighting(int x, int y) const {
    Vector3 right, below;
    if (!tangent(x, y, reach_, 0, right) || !tangent(x, y, 0, reach_, below)) return 0.55f;
    Vector3 normal = cross(below, right);
    const Vector3 ray = view_.ray(x, y);
    if (!(norm(normal) > 0)) return 0.55f;
    normal = unit(normal);
    if (dot(normal, ray) > 0) normal = add({0, 0, 0}, normal, -1);
    // A lamp behind the camera's upper left, and the camera's own light.
    const Vector3 to_lamp = unit(
        add(add(add({0, 0, 0}, unit(view_.c), -0.75), unit(view_.a_across()), -0.45), unit(view_.b_across()), -0.65));
    const double lamp = std::max(0.0, dot(normal, to_lamp));
    const double head = std::max(0.0, -dot(normal, unit(ray)));
    return static_cast<float>(0.14 + 0.62 * lamp + 0.26 * head);
  }

  // Darkens what lies behind an edge: it sets parts off from one another where shading cannot.
  float rim(int x, int y, float z) const {
    float sum = 0;
    for (const auto& d : {std::array<int, 2>{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}) {
      for (int ring = 1; ring <= 2; ++ring) {
        const float other = depth(x + d[0] * reach_ * ring, y + d[1] * reach_ * ring);
        if (other > 0) sum += std::clamp((z - other) / z - 0.008f, 0.0f, 0.03f);
      }
    }
    return std::exp(-2.6f * sum);
  }

  const Projection& view_;
  const DepthMap& image_;
  int reach_;
  std::vector<float> smooth_;
  float near_ = 0, far_ = 0;
};

}  // namespace handhold
