// From points to pixels: the projection of the camera that took a cloud, or one to look at it. Part of picture.cpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "handhold/cloud.h"
#include "statistics.h"

namespace handhold {

inline double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vector3 add(const Vector3& a, const Vector3& b, double factor = 1) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}
inline double norm(const Vector3& a) {
  return std::sqrt(dot(a, a));
}
inline Vector3 unit(const Vector3& a) {
  return add({0, 0, 0}, a, 1 / norm(a));
}

/// A pinhole camera in any position: with d = point - eye, the pixel is (a.d / c.d, b.d / c.d) and c.d, c a unit
/// vector, the depth along the camera's axis (m).
struct Projection {
  Vector3 eye{0, 0, 0};
  Vector3 a{1, 0, 0}, b{0, 1, 0}, c{0, 0, 1};

  double depth(const Vector3& point) const { return dot(c, add(point, eye, -1)); }
  /// False for a point that is not in front of the camera.
  bool project(const Vector3& point, double& u, double& v, double& z) const {
    const Vector3 d = add(point, eye, -1);
    z = dot(c, d);
    if (!(z > 1e-6)) return false;
    u = dot(a, d) / z;
    v = dot(b, d) / z;
    return std::isfinite(u) && std::isfinite(v);
  }
  /// Direction to the point that has depth 1 at a pixel: solves a.d = u, b.d = v, c.d = 1.
  Vector3 ray(double u, double v) const {
    const Vector3 bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
    const double scale = 1 / dot(a, bc);
    return add(add(add({0, 0, 0}, bc, u * scale), ca, v * scale), ab, scale);
  }
  /// Directions in which pixels go right and down, across the camera's axis.
  Vector3 a_across() const { return add(a, c, -dot(a, c)); }
  Vector3 b_across() const { return add(b, c, -dot(b, c)); }
  /// The same camera with an image of another size; (0, 0) is the centre of the upper left pixel.
  void resize(double factor) {
    const double shift = (factor - 1) / 2;
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] = factor * a[k] + shift * c[k];
      b[k] = factor * b[k] + shift * c[k];
    }
  }
};

inline bool finite_point(const float* p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}
inline Vector3 to_vector(const float* p) {
  return {p[0], p[1], p[2]};
}

/// Solves an 8 x 8 system by elimination; false when it is singular.
inline bool solve8(double (&m)[8][9]) {
  double largest = 0;
  for (auto& row : m) {
    for (int k = 0; k < 8; ++k) largest = std::max(largest, std::abs(row[k]));
  }
  for (int i = 0; i < 8; ++i) {
    int pivot = i;
    for (int r = i + 1; r < 8; ++r) {
      if (std::abs(m[r][i]) > std::abs(m[pivot][i])) pivot = r;
    }
    if (!(std::abs(m[pivot][i]) > 1e-13 * largest)) return false;
    std::swap(m[i], m[pivot]);
    for (int r = 0; r < 8; ++r) {
      if (r == i) continue;
      const double factor = m[r][i] / m[i][i];
      for (int k = i; k < 9; ++k) m[r][k] -= factor * m[i][k];
    }
  }
  for (int i = 0; i < 8; ++i) m[i][8] /= m[i][i];
  return true;
}

/// The projection that takes the points of an organized cloud to their pixels: eight numbers by least squares. It needs
/// no intrinsics and holds for a cloud in any frame, if the viewpoint is right. None when the pixels do not fit it.
inline std::optional<Projection> fit_projection(const CloudView& cloud, const Vector3& eye) {
  struct Sight {
    Vector3 direction;
    double u, v;
  };
  std::vector<Sight> samples;
  Vector3 mean{0, 0, 0};
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / 20011);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (!finite_point(cloud.point(i))) continue;
    const Vector3 d = add(to_vector(cloud.point(i)), eye, -1);
    if (!(norm(d) > 1e-9)) continue;
    samples.push_back({unit(d), static_cast<double>(i % cloud.width), static_cast<double>(i / cloud.width)});
    mean = add(mean, samples.back().direction);
  }
  if (samples.size() < 20 || !(norm(mean) > 0.1 * static_cast<double>(samples.size()))) return std::nullopt;

  // The depth's direction is m + alpha p + beta q: the mean direction and two across it. It remains to solve
  // a.d - u (alpha p.d + beta q.d) = u m.d, and the same for b and v; pixels scaled to about 1.
  const Vector3 m = unit(mean);
  const Vector3 p = unit(std::abs(m[0]) < 0.8 ? cross(m, {1, 0, 0}) : cross(m, {0, 1, 0})), q = cross(m, p);
  const double pixel = std::max(cloud.width, cloud.height);
  double system[8][9] = {};
  for (const Sight& s : samples) {
    const double u = s.u / pixel, v = s.v / pixel;
    const double md = dot(m, s.direction), pd = dot(p, s.direction), qd = dot(q, s.direction);
    const double rows[2][9] = {
        {md, pd, qd, 0, 0, 0, -u * pd, -u * qd, u * md},
        {0, 0, 0, md, pd, qd, -v * pd, -v * qd, v * md},
    };
    for (const auto& row : rows) {
      for (int i = 0; i < 8; ++i) {
        for (int k = 0; k < 9; ++k) system[i][k] += row[i] * row[k];
      }
    }
  }
  if (!solve8(system)) return std::nullopt;
  const auto combine = [&](double x, double y, double z) { return add(add(add({0, 0, 0}, m, x), p, y), q, z); };
  Projection fit;
  fit.eye = eye;
  fit.c = combine(1, system[6][8], system[7][8]);
  const double scale = 1 / norm(fit.c);
  fit.a = combine(pixel * scale * system[0][8], pixel * scale * system[1][8], pixel * scale * system[2][8]);
  fit.b = combine(pixel * scale * system[3][8], pixel * scale * system[4][8], pixel * scale * system[5][8]);
  fit.c = unit(fit.c);
  if (!(std::abs(dot(fit.a, cross(fit.b, fit.c))) > 1e-6)) return std::nullopt;  // all points in a line

  std::size_t near = 0;
  for (const Sight& s : samples) {
    double u, v, z;
    if (fit.project(add(eye, s.direction), u, v, z) && std::hypot(u - s.u, v - s.v) < 2) ++near;
  }
  if (near < samples.size() * 9 / 10) return std::nullopt;
  return fit;
}

/// A camera at the viewpoint that looks at the median point and has nearly all points in its image; from outside when
/// there is no viewpoint, or most of the cloud is behind it. The cloud must have a finite point.
inline Projection look_at_cloud(const CloudView& cloud, int width, int height) {
  std::vector<Vector3> points;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / 50021);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (finite_point(cloud.point(i))) points.push_back(to_vector(cloud.point(i)));
  }
  if (points.empty()) {
    for (std::size_t i = 0; i < cloud.size() && points.empty(); ++i) {
      if (finite_point(cloud.point(i))) points.push_back(to_vector(cloud.point(i)));
    }
  }
  Vector3 middle{};
  std::vector<double> values(points.size());
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = points[i][k];
    middle[k] = quantile(values, 0.5);
  }
  for (std::size_t i = 0; i < points.size(); ++i) values[i] = norm(add(points[i], middle, -1));
  const double radius = std::max(quantile(values, 0.8), 1e-3);

  const auto outside = [&] { return add(middle, unit({0.5, -0.75, 0.55}), 4 * radius); };
  Vector3 eye = cloud.viewpoint ? *cloud.viewpoint : outside();
  std::size_t front = 0;
  for (const Vector3& point : points) front += dot(add(point, eye, -1), add(middle, eye, -1)) > 0;
  if (!(norm(add(middle, eye, -1)) > 0.2 * radius) || front < points.size() * 3 / 4) eye = outside();

  // "Down" in the picture: y in a camera's optical frame, -z in the world's or a robot's.
  const Vector3 forward = unit(add(middle, eye, -1));
  const bool optical = forward[2] > 0.6;
  const Vector3 down = optical ? Vector3{0, 1, 0} : forward[2] < -0.95 ? Vector3{0, -1, 0} : Vector3{0, 0, -1};
  const Vector3 right = unit(cross(down, forward)), below = cross(forward, right);

  std::vector<double> across, along;
  for (const Vector3& point : points) {
    const Vector3 d = add(point, eye, -1);
    const double z = dot(d, forward);
    if (!(z > 1e-6)) continue;
    across.push_back(std::clamp(dot(d, right) / z, -1.5, 1.5));  // beyond that a perspective shows little
    along.push_back(std::clamp(dot(d, below) / z, -1.5, 1.5));
  }
  const double left = quantile(across, 0.003), right_end = quantile(across, 0.997);
  const double top = quantile(along, 0.003), bottom = quantile(along, 0.997);
  const double focal = std::min({0.92 * width / std::max(right_end - left, 1e-9),
                                 0.86 * height / std::max(bottom - top, 1e-9), 4.0 * std::max(width, height)});
  Projection view;
  view.eye = eye;
  view.c = forward;
  const double cx = (width - 1) / 2.0 - focal * (left + right_end) / 2;
  const double cy = 0.46 * height - focal * (top + bottom) / 2;
  view.a = add(add({0, 0, 0}, right, focal), forward, cx);
  view.b = add(add({0, 0, 0}, below, focal), forward, cy);
  return view;
}

}  // namespace handhold
