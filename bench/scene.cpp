#include "scene.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <random>
#include <stdexcept>

#ifdef HANDHOLD_HAVE_IO
#include "handhold/io.h"
#endif

namespace handhold::bench {
namespace {

using Eigen::Vector3d;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Cylinder {
  Vector3d base;  // m
  Vector3d axis;  // unit
  double radius, length;
};
struct Ball {
  Vector3d center;
  double radius;
};

// Distance along `ray` (from the origin) to the nearer side of the mantle or the cap, infinity for none.
double hit(const Cylinder& cylinder, const Vector3d& ray) {
  const auto height = [&](double t) { return cylinder.axis.dot(t * ray - cylinder.base); };
  double nearest = kInfinity;
  const Vector3d d = ray - cylinder.axis.dot(ray) * cylinder.axis;
  const Vector3d o = cylinder.base - cylinder.axis.dot(cylinder.base) * cylinder.axis;
  const double a = d.squaredNorm(), b = d.dot(o), c = o.squaredNorm() - cylinder.radius * cylinder.radius;
  if (b * b > a * c) {
    const double t = (b - std::sqrt(b * b - a * c)) / a;
    if (t > 0 && height(t) >= 0 && height(t) <= cylinder.length) nearest = t;
  }
  const double slope = cylinder.axis.dot(ray);
  for (const double cap : {0.0, cylinder.length}) {
    const double t = (cap + cylinder.axis.dot(cylinder.base)) / slope;
    const Vector3d at_cap = t * ray - cylinder.base - cap * cylinder.axis;
    if (t > 0 && at_cap.squaredNorm() <= cylinder.radius * cylinder.radius) nearest = std::min(nearest, t);
  }
  return nearest;
}

double hit(const Ball& ball, const Vector3d& ray) {
  const double a = ray.squaredNorm(), b = ray.dot(ball.center);
  const double c = ball.center.squaredNorm() - ball.radius * ball.radius;
  return b * b > a * c ? (b - std::sqrt(b * b - a * c)) / a : kInfinity;
}

}  // namespace

Cloud make_scene(std::uint32_t width, std::uint32_t height) {
  // The camera looks down at the table by 40 degrees; `up` leaves the table.
  const double tilt = 40 * M_PI / 180;
  const Vector3d up(0, -std::cos(tilt), -std::sin(tilt)), right(1, 0, 0), away = up.cross(right);
  const Vector3d table(0, 0.1, 0.85);
  const auto on_table = [&](double x, double y, double z) { return Vector3d(table + x * right + y * away + z * up); };

  const Cylinder cylinders[] = {
      {on_table(-0.20, 0.00, 0.00), up, 0.033, 0.20},                                  // bottle
      {on_table(-0.20, 0.00, 0.20), up, 0.014, 0.06},                                  // and its neck
      {on_table(-0.05, 0.12, 0.00), up, 0.025, 0.15},                                  // beaker
      {on_table(0.05, -0.10, 0.05), right, 0.012, 0.16},                               // bar above the table
      {on_table(0.05, -0.10, 0.00), up, 0.010, 0.05},                                  // its posts
      {on_table(0.21, -0.10, 0.00), up, 0.010, 0.05},                                  //
      {on_table(0.12, 0.10, 0.00), (up + 0.5 * right).normalized(), 0.018, 0.18},      // leaning stick
      {on_table(-0.12, -0.12, 0.02), (right + 0.3 * away).normalized(), 0.020, 0.10},  // lying tin
      {on_table(0.28, 0.20, 0.00), up, 0.060, 0.12},                                   // too wide for a hand
  };
  const Ball balls[] = {{on_table(0.02, 0.02, 0.035), 0.035}};

  Cloud cloud;
  cloud.width = width;
  cloud.height = height;
  cloud.xyz.reserve(3 * cloud.size());
  const double focal = 525.0 * width / 640.0;
  std::mt19937 random(20);
  std::normal_distribution<double> noise(0, 1);
  for (std::uint32_t v = 0; v < height; ++v)
    for (std::uint32_t u = 0; u < width; ++u) {
      const Vector3d ray((u - 0.5 * (width - 1)) / focal, (v - 0.5 * (height - 1)) / focal, 1);
      double z = up.dot(table) / up.dot(ray);
      if (!(z > 0) || z > 1.6) z = kInfinity;
      for (const Cylinder& cylinder : cylinders) z = std::min(z, hit(cylinder, ray));
      for (const Ball& ball : balls) z = std::min(z, hit(ball, ray));
      z += noise(random) * (0.0004 + 0.0009 * z * z);
      for (int k = 0; k < 3; ++k)
        cloud.xyz.push_back(std::isfinite(z) ? static_cast<float>(z * ray[k])
                                             : std::numeric_limits<float>::quiet_NaN());
    }
  return cloud;
}

Cloud load_scene(const std::string& path, std::string* name) {
  std::string file = path;
  if (file.empty())
    if (const char* variable = std::getenv("HANDHOLD_BENCH_CLOUD")) file = variable;
  const std::string sample_scene = HANDHOLD_DATA "/table_scene.pcd";
  if (file.empty() && std::filesystem::exists(sample_scene)) file = sample_scene;
#ifdef HANDHOLD_HAVE_IO
  if (!file.empty()) {
    if (name) *name = std::filesystem::path(file).stem().string();
    return read_cloud(file);
  }
#else
  if (!path.empty()) throw std::runtime_error(path + ": cannot be read, this build has no cloud reader (handhold_io)");
#endif
  if (name) *name = "synthetic";
  return make_scene();
}

std::vector<std::array<float, 3>> draw_samples(const CloudView& cloud, int count, std::uint64_t seed) {
  std::vector<std::uint32_t> finite;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float* p = cloud.point(i);
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) finite.push_back(std::uint32_t(i));
  }
  std::vector<std::array<float, 3>> samples;
  std::mt19937_64 random(seed);
  for (int i = 0; i < count && !finite.empty(); ++i) {
    const float* p = cloud.point(finite[random() % finite.size()]);
    samples.push_back({p[0], p[1], p[2]});
  }
  return samples;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const std::size_t half = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + half, values.end());
  if (values.size() % 2) return values[half];
  return 0.5 * (values[half] + *std::max_element(values.begin(), values.begin() + half));
}

}  // namespace handhold::bench
