// Clouds that tests are made of: shapes of known curvature, what a depth camera makes of them, and degenerate ones. All
// in metres, from a seed, the same on every machine.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace handhold::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using FloatPoints = std::vector<Vector3f>;  ///< m; as a sensor delivers them

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Random numbers from a seed. The distributions of the standard library differ between its vendors; these do not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// In [low, high).
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  /// Normally distributed about zero.
  double normal(double sigma) {
    const double u = 1 - uniform(0, 1), v = uniform(0, 2 * M_PI);
    return sigma * std::sqrt(-2 * std::log(u)) * std::cos(v);
  }
  Vector3d normal3(double sigma) {
    const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
    return {x, y, z};
  }
  /// In 0 .. n-1.
  std::size_t index(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
  Vector3d direction() { return normal3(1).normalized(); }
  Matrix3d rotation() {
    const double angle = uniform(-M_PI, M_PI);
    return Eigen::AngleAxisd(angle, direction()).toRotationMatrix();
  }
  template <class T>
  void shuffle(std::vector<T>& values) {
    for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[index(i)]);
  }

 private:
  std::mt19937_64 engine_;
};

inline std::vector<Vector3d> to_double(const FloatPoints& points) {
  std::vector<Vector3d> doubles;
  for (const Vector3f& p : points) doubles.push_back(p.cast<double>());
  return doubles;
}

inline FloatPoints transformed(FloatPoints points, const Matrix3d& R, const Vector3d& t) {
  for (Vector3f& p : points) p = (R * p.cast<double>() + t).cast<float>();
  return points;
}

inline FloatPoints joined(FloatPoints a, const FloatPoints& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// ---- Shapes about the origin; noise is the standard deviation of each coordinate (m) ------------------------------

/// Side of a cylinder about the z axis, over `arc` radians centred on +x.
inline FloatPoints cylinder(Random& random, int n, double radius, double length, double noise = 0,
                            double arc = 2 * M_PI) {
  FloatPoints points;
  for (int i = 0; i < n; ++i) {
    const double a = random.uniform(-arc / 2, arc / 2), z = random.uniform(-length / 2, length / 2);
    const Vector3d p(radius * std::cos(a), radius * std::sin(a), z);
    points.push_back((p + random.normal3(noise)).cast<float>());
  }
  return points;
}

inline FloatPoints sphere(Random& random, int n, double radius, double noise = 0) {
  FloatPoints points;
  for (int i = 0; i < n; ++i) {
    const Vector3d p = radius * random.direction();
    points.push_back((p + random.normal3(noise)).cast<float>());
  }
  return points;
}

/// Torus about the z axis; `ring` from the centre to the tube's, `tube` the tube's own radius.
inline FloatPoints torus(Random& random, int n, double ring, double tube, double noise = 0) {
  FloatPoints points;
  for (int i = 0; i < n; ++i) {
    const double a = random.uniform(-M_PI, M_PI), b = random.uniform(-M_PI, M_PI);
    const double d = ring + tube * std::cos(b);
    const Vector3d p(d * std::cos(a), d * std::sin(a), tube * std::sin(b));
    points.push_back((p + random.normal3(noise)).cast<float>());
  }
  return points;
}

/// Cone about the z axis with its apex at the origin, from height z0 to z1; slope = radius / height.
inline FloatPoints cone(Random& random, int n, double slope, double z0, double z1, double noise = 0) {
  FloatPoints points;
  for (int i = 0; i < n; ++i) {
    const double a = random.uniform(-M_PI, M_PI), z = random.uniform(z0, z1);
    const Vector3d p(slope * z * std::cos(a), slope * z * std::sin(a), z);
    points.push_back((p + random.normal3(noise)).cast<float>());
  }
  return points;
}

/// z = (kx x^2 + ky y^2) / 2 over a square of side `size`; curvatures kx, ky (1/m) at the origin.
inline FloatPoints paraboloid(Random& random, int n, double kx, double ky, double size, double noise = 0) {
  FloatPoints points;
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform(-size / 2, size / 2), y = random.uniform(-size / 2, size / 2);
    const Vector3d p(x, y, (kx * x * x + ky * y * y) / 2);
    points.push_back((p + random.normal3(noise)).cast<float>());
  }
  return points;
}

/// The square |x|, |y| <= size / 2 at z = 0.
inline FloatPoints plane(Random& random, int n, double size, double noise = 0) {
  return paraboloid(random, n, 0, 0, size, noise);
}

/// Three faces that meet at the origin.
inline FloatPoints box_corner(Random& random, int n, double size, double noise = 0) {
  FloatPoints points;
  for (int i = 0; i < n; ++i) {
    Vector3d p(random.uniform(0, size), random.uniform(0, size), 0);
    std::swap(p[2], p[i % 3]);
    points.push_back((p + random.normal3(noise)).cast<float>());
  }
  return points;
}

/// The x axis, |x| <= length / 2.
inline FloatPoints line(Random& random, int n, double length) {
  FloatPoints points;
  for (int i = 0; i < n; ++i)
    points.emplace_back(static_cast<float>(random.uniform(-length / 2, length / 2)), 0.f, 0.f);
  return points;
}

/// The cube |x|, |y|, |z| <= size / 2, filled.
inline FloatPoints cube(Random& random, int n, double size) {
  FloatPoints points;
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform(-size / 2, size / 2), y = random.uniform(-size / 2, size / 2);
    points.push_back(Vector3d(x, y, random.uniform(-size / 2, size / 2)).cast<float>());
  }
  return points;
}

/// What a structured-light camera at the origin, looking along +z, sees of an upright cylinder (radius 3 cm, axis
/// parallel to y, 0.7 m away) in front of a wall 0.85 m away: row-major, depth in steps that grow with the square of
/// the distance, missing pixels at the cylinder's edges and here and there.
inline FloatPoints depth_image(Random& random, int width, int height) {
  constexpr double kRadius = 0.03, kAxisDepth = 0.7, kWall = 0.85;
  const double focal = 525.0 * width / 640;  // px
  FloatPoints points;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const Vector3d ray((column - width / 2.0) / focal, (row - height / 2.0) / focal, 1);
      // |t (x, 1) - (0, axis)|^2 = radius^2 in the plane across the axis
      const double a = ray.x() * ray.x() + 1,
                   root = kAxisDepth * kAxisDepth - a * (kAxisDepth * kAxisDepth - kRadius * kRadius);
      double z = root > 0 ? (kAxisDepth - std::sqrt(root)) / a : kWall;
      const bool grazing = std::abs(root) < 1e-5;
      const double step = 2.85e-3 * z * z;
      z = std::round((z + random.normal(0.3 * step)) / step) * step;
      const bool missing = grazing || random.uniform(0, 1) < 0.02;
      points.push_back(missing ? Vector3f(kNan, kNan, kNan) : Vector3f((z * ray).cast<float>()));
    }
  return points;
}

// ---- Sets of clouds ------------------------------------------------------------------------------------------------

struct NamedCloud {
  std::string name;
  FloatPoints points;
  Vector3f sample;  ///< a place to look at
};

/// Clouds with something to fit about their sample, in a pose of their own: samples lie 0.3 .. 1 m from the origin.
inline std::vector<NamedCloud> ordinary_clouds(std::uint64_t seed, int n) {
  Random random(seed);
  std::vector<NamedCloud> clouds;
  const auto add = [&](const char* name, const FloatPoints& points, const Vector3d& on_surface) {
    const Matrix3d R = random.rotation();
    const Vector3d t = random.uniform(0.3, 1.0) * random.direction();
    const Vector3d off = random.normal3(1e-3);
    clouds.push_back({name, transformed(points, R, t), (R * on_surface + t + off).cast<float>()});
  };
  add("cylinder", cylinder(random, n, 0.02, 0.08), {0.02, 0, 0});
  add("half a noisy cylinder", cylinder(random, n, 0.03, 0.1, 1e-3, M_PI), {0.03, 0, 0});
  add("sphere", sphere(random, n, 0.025), {0.025, 0, 0});
  add("noisy sphere", sphere(random, n, 0.04, 1e-3), {0.04, 0, 0});
  add("torus", torus(random, n, 0.04, 0.01, 5e-4), {0.05, 0, 0});
  add("cone", cone(random, n, 0.4, 0.02, 0.1, 3e-4), {0.024, 0, 0.06});
  add("saddle", paraboloid(random, n, 30, -18, 0.08, 5e-4), {0, 0, 0});
  add("bowl", paraboloid(random, n, 25, 12, 0.08, 1e-3), {0, 0, 0});
  add("noisy plane", plane(random, n, 0.1, 1e-3), {0, 0, 0});
  add("box corner", box_corner(random, n, 0.08, 5e-4), {0.004, 0.003, 0.002});
  add("cube, filled", cube(random, n, 0.06), {0, 0, 0});
  // not moved: the quantization is the camera's
  clouds.push_back({"depth image", depth_image(random, 160, 120), Vector3f(0, 0, 0.67f)});
  return clouds;
}

/// Clouds that define no quadric, or hardly anything at all. The sample is a place where points are, if there are any.
inline std::vector<NamedCloud> degenerate_clouds(std::uint64_t seed) {
  Random random(seed);
  const Matrix3d R = random.rotation();
  const Vector3d t(0.1, -0.2, 0.5);
  const Vector3f at = t.cast<float>();
  std::vector<NamedCloud> clouds;
  clouds.push_back({"empty", {}, at});
  clouds.push_back({"one point", {at}, at});
  clouds.push_back({"identical points", FloatPoints(300, at), at});
  clouds.push_back({"two places", joined(FloatPoints(100, at), FloatPoints(77, at + Vector3f(0.01f, 0, 0))), at});
  clouds.push_back({"line along an axis", transformed(line(random, 200, 0.1), Matrix3d::Identity(), t), at});
  clouds.push_back({"tilted line", transformed(line(random, 200, 0.1), R, t), at});
  clouds.push_back({"plane across an axis", transformed(plane(random, 900, 0.1), Matrix3d::Identity(), t), at});
  clouds.push_back({"tilted plane", transformed(plane(random, 900, 0.1), R, t), at});
  clouds.push_back({"nothing measured", FloatPoints(500, Vector3f(kNan, kNan, kNan)), at});
  return clouds;
}

/// Puts points among `points` that no sensor measured: NaN or infinite in one coordinate or all, or far outside the
/// world.
inline FloatPoints with_bad_points(Random& random, const FloatPoints& points, int every) {
  FloatPoints mixed;
  int n = 0;
  for (const Vector3f& p : points) {
    if (random.index(every) == 0) {
      Vector3f bad = p;
      const float values[] = {kNan, kInfinity, -kInfinity, 1e30f, -2e6f, std::numeric_limits<float>::max()};
      bad[n % 3] = values[n % 6];
      if (n % 4 == 0) bad = Vector3f::Constant(values[n % 6]);
      mixed.push_back(bad);
      ++n;
    }
    mixed.push_back(p);
  }
  return mixed;
}

}  // namespace handhold::test
