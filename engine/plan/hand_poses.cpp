// Where the hand may take hold of a handle.
#include "hand_poses.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "bodies.h"
#include "vec3.h"

namespace handhold::plan {
namespace {

constexpr double kPi = 3.141592653589793;

bool is_finite(const Vector3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}
bool is_near(const Vector3& v) {
  return std::fabs(v[0]) <= kFarthest && std::fabs(v[1]) <= kFarthest && std::fabs(v[2]) <= kFarthest;
}

[[noreturn]] void refuse(std::size_t index, const char* what) {
  throw std::invalid_argument("handle " + std::to_string(index) + ": " + what);
}

Vector3 checked_direction(const Vector3& v, std::size_t index, const char* what) {
  if (!is_finite(v) || !(norm(v) > 1e-6)) refuse(index, what);
  return normalized(v);
}

/// The place `shift` (m) along a curved handle from the point of its path that is nearest to its centre; at most its
/// ends. No two points in a row are the same.
HandlePlace place_on(const std::vector<Vector3>& path, const Vector3& center, double shift) {
  std::size_t nearest = 0;  // piece
  double along = 0, best = -1;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Vector3 piece = path[i + 1] - path[i];
    const double square = dot(piece, piece);
    const double share = std::clamp(dot(center - path[i], piece) / square, 0.0, 1.0);
    const double distance = norm(center - path[i] - share * piece);
    if (best < 0 || distance < best) best = distance, nearest = i, along = share * std::sqrt(square);
  }
  const auto length = [&](std::size_t i) { return norm(path[i + 1] - path[i]); };
  along += shift;
  while (along < 0 && nearest > 0) along += length(--nearest);
  while (along > length(nearest) && nearest + 2 < path.size()) along -= length(nearest++);
  const Vector3 axis = normalized(path[nearest + 1] - path[nearest]);
  return {path[nearest] + std::clamp(along, 0.0, length(nearest)) * axis, axis, shift};
}

double angle_between(const Vector3& a, const Vector3& b) {
  return std::atan2(norm(cross(a, b)), dot(a, b));
}

}  // namespace

Handle in_base(const Handle& handle, const Pose& T_base_camera, std::size_t index) {
  Handle ours = handle;
  if (!is_near(handle.center)) refuse(index, "its center must be finite, within 1e6 m");
  if (!(handle.radius >= 0) || !std::isfinite(handle.radius)) refuse(index, "its radius must be at least 0");
  if (!(handle.length >= 0) || !std::isfinite(handle.length)) refuse(index, "its length must be at least 0");
  if (std::isnan(handle.confidence)) refuse(index, "its confidence is not a number");
  ours.center = T_base_camera.point(handle.center);
  ours.axis = T_base_camera.direction(checked_direction(handle.axis, index, "its axis is no direction"));
  ours.approach = T_base_camera.direction(checked_direction(handle.approach, index, "its approach is no direction"));
  ours.path.clear();
  for (const Vector3& point : handle.path) {
    if (!is_near(point)) refuse(index, "its path must be finite, within 1e6 m");
    const Vector3 p = T_base_camera.point(point);
    if (ours.path.empty() || norm(p - ours.path.back()) > 1e-6) ours.path.push_back(p);  // each piece has a direction
  }
  return ours;
}

std::vector<HandlePlace> places_along(const Handle& handle, const std::vector<double>& shares) {
  constexpr double kNear = 0.005;  // m
  std::vector<HandlePlace> places;
  for (const double share : shares) {
    const double shift = share * handle.length / 2;
    const auto is_near = [&](const HandlePlace& other) { return std::fabs(other.shift - shift) < kNear; };
    if (std::any_of(places.begin(), places.end(), is_near)) continue;
    places.push_back(handle.path.size() >= 2 ? place_on(handle.path, handle.center, shift)
                                             : HandlePlace{handle.center + shift * handle.axis, handle.axis, shift});
  }
  return places;
}

std::vector<Approach> approaches_to(const HandlePlace& place, const Vector3& mount, const Vector3& seen,
                                    double angle_step, double max_angle) {
  const Vector3& axis = place.axis;
  const auto across = [&](const Vector3& v) { return v - dot(v, axis) * axis; };
  // On a curved handle `seen` was found elsewhere; it may even run along the axis here.
  const Vector3 towards = normalized(across(seen), any_perpendicular(axis));
  const Vector3 line = across(place.point - mount);
  const Vector3 first = norm(line) > 1e-6 ? normalized(line) : towards;
  const Vector3 side = cross(axis, first);

  std::vector<Approach> approaches;
  constexpr double kSame = 1e-3;  // rad
  const auto add = [&](double angle) {
    const Vector3 direction = std::cos(angle) * first + std::sin(angle) * side;
    if (angle_between(direction, towards) <= std::max(max_angle, kSame)) approaches.push_back({direction, angle, 0});
  };
  const double of_towards = std::atan2(dot(towards, side), dot(towards, first));
  add(0);
  if (std::fabs(of_towards) > kSame) add(of_towards);
  for (int k = 1; k * angle_step < kPi + 1e-9; ++k) {
    add(k * angle_step);
    if (k * angle_step < kPi - 1e-9) add(-k * angle_step);
  }
  return approaches;
}

Approach tilted(const Approach& approach, const Vector3& axis, double tilt) {
  return {std::cos(tilt) * approach.direction + std::sin(tilt) * axis, approach.angle, tilt};
}

Pose hand_pose(const HandlePlace& place, const Vector3& approach, double depth, bool flipped) {
  const Vector3 z = approach, y = (flipped ? -1.0 : 1.0) * normalized(cross(z, place.axis)), x = cross(y, z);
  Pose T;
  T.R = {x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]};
  T.t = place.point + depth * z;
  return T;
}

}  // namespace handhold::plan
