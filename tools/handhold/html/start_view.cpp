#include "start_view.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "projection.h"

namespace handhold {
namespace {

constexpr int kWidth = 1280, kHeight = 960;  // px; of the picture that look_at_cloud() fills

/// At most `most` points, evenly over the cloud.
std::vector<Vector3> some_points(const CloudView& cloud, std::size_t most) {
  std::vector<Vector3> points;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / most);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (finite_point(cloud.point(i))) points.push_back(to_vector(cloud.point(i)));
  }
  return points;
}

/// The normal, on the side of `up`, of the plane with most points, if it holds a fifth of them and leans less than 70
/// degrees from `up`: of a table or a floor, not of a wall. RANSAC with a fixed seed.
Vector3 up_of_plane(const std::vector<Vector3>& points, const Vector3& up, double tolerance) {
  constexpr int kTries = 400;
  constexpr double kLeast = 0.34;  // cosine
  if (points.size() < 100) return up;
  std::uint64_t state = 1;
  const auto draw = [&]() -> const Vector3& {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return points[(state >> 33) % points.size()];
  };
  Vector3 best = up;
  std::size_t most = points.size() / 5;
  for (int i = 0; i < kTries; ++i) {
    const Vector3 &p = draw(), &q = draw(), &r = draw();
    Vector3 normal = cross(add(q, p, -1), add(r, p, -1));
    if (!(norm(normal) > 1e-6)) continue;
    normal = unit(normal);
    if (dot(normal, up) < 0) normal = add({0, 0, 0}, normal, -1);
    if (dot(normal, up) < kLeast) continue;
    const double offset = dot(normal, p);
    const auto inside = [&](const Vector3& x) { return std::abs(dot(normal, x) - offset) < tolerance; };
    const auto count = static_cast<std::size_t>(std::count_if(points.begin(), points.end(), inside));
    if (count > most) {
      most = count;
      best = normal;
    }
  }
  return best;
}

}  // namespace

StartView start_view(const CloudView& cloud) {
  StartView view;
  const std::vector<Vector3> points = some_points(cloud, 4000);
  if (points.empty()) return view;
  const Projection camera = look_at_cloud(cloud, kWidth, kHeight);
  std::vector<double> depths;
  for (const Vector3& point : points) depths.push_back(std::max(camera.depth(point), 0.0));
  const double depth = std::max(quantile(depths, 0.5), 1e-3);
  const Vector3 middle = unit(camera.ray((kWidth - 1) / 2.0, (kHeight - 1) / 2.0));
  view.eye = camera.eye;
  view.target = add(camera.eye, middle, depth);
  view.down = unit(camera.b_across());
  view.angle = 2 * std::atan(kHeight / (2 * norm(camera.b_across())));
  view.up = up_of_plane(points, add({0, 0, 0}, view.down, -1), 0.01 * depth);
  return view;
}

}  // namespace handhold
