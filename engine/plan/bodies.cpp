#include "bodies.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vec3.h"

namespace handhold::plan {
namespace {

// ---- Distances ------------------------------------------------------------------------------------------------------

/// How far a point is beyond each side of a box about the origin, 0 within; signed as the point is.
Vector3 beyond(const Vector3& p, const Vector3& half) {
  Vector3 out;
  for (int k = 0; k < 3; ++k) out[k] = p[k] - std::clamp(p[k], -half[k], half[k]);
  return out;
}

/// Least squared distance (m^2) of a segment (start + t along, t from 0 to 1) from a box about the origin.
///
/// The squared distance of the point at t is convex, and quadratic between the places where the segment's line crosses
/// the planes of the box's faces. So its slope rises, linearly between those places: they bracket its zero, and between
/// the last two it follows exactly.
double squared_distance(const Vector3& start, const Vector3& along, const Vector3& half) {
  const auto at = [&](double t) { return beyond(start + t * along, half); };
  const auto slope = [&](double t) { return dot(along, at(t)); };
  double low = 0, high = 1, low_slope = slope(0), high_slope = slope(1);
  if (low_slope >= 0) high = 0;
  if (high_slope <= 0) low = 1;
  if (low >= high) {  // least at an end, or the same everywhere
    const Vector3 end = at(high == 0 ? 0 : 1);
    return dot(end, end);
  }
  for (int k = 0; k < 3; ++k) {
    if (along[k] == 0) continue;
    for (const double face : {-half[k], half[k]}) {
      const double t = (face - start[k]) / along[k];
      if (!(t > low && t < high)) continue;
      const double s = slope(t);
      (s < 0 ? low : high) = t;
      (s < 0 ? low_slope : high_slope) = s;
    }
  }
  const double share = low_slope / (low_slope - high_slope);  // low_slope < 0 <= high_slope
  const Vector3 least = at(low + share * (high - low));
  return dot(least, least);
}

/// Least squared distance (m^2) of the edges of one core from another one.
double squared_distance_of_edges(const Core& core, const Core& other) {
  const Pose T_other_core = other.T_base_core.inverse() * core.T_base_core;
  Vector3 side[3];  // from the centre to the middles of three faces
  for (int k = 0; k < 3; ++k) {
    side[k] = core.half[k] * Vector3{T_other_core.R[k], T_other_core.R[3 + k], T_other_core.R[6 + k]};
  }
  const auto edge = [&](int along, const Vector3& middle) {
    return squared_distance(middle - side[along], 2.0 * side[along], other.half);
  };
  if (!core.edged) return edge(2, T_other_core.t);
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vector3 &u = side[(k + 1) % 3], &v = side[(k + 2) % 3];
    for (const Vector3& middle : {u + v, u - v, v - u, -1.0 * u - v}) {
      least = std::min(least, edge(k, T_other_core.t + middle));
      if (least == 0) return 0;
    }
  }
  return least;
}

// ---- Checks ---------------------------------------------------------------------------------------------------------

bool is_pose(const Pose& pose) {
  constexpr double kSlack = 1e-6;  // as Arm::inverse
  const Vector3 x = {pose.R[0], pose.R[3], pose.R[6]}, y = {pose.R[1], pose.R[4], pose.R[7]};
  const Vector3 z = {pose.R[2], pose.R[5], pose.R[8]};
  // False for NaN.
  return norm(cross(x, y) - z) < kSlack && std::fabs(norm(x) - 1) < kSlack && std::fabs(norm(y) - 1) < kSlack &&
         std::fabs(dot(x, y)) < kSlack;
}
bool is_near(const Vector3& v) {
  return std::fabs(v[0]) <= kFarthest && std::fabs(v[1]) <= kFarthest && std::fabs(v[2]) <= kFarthest;
}
bool is_size(double size) {
  return size >= 0 && size <= kFarthest;
}

[[noreturn]] void fail(const char* what, const std::string& name, const char* why) {
  throw std::invalid_argument(what + (name.empty() ? "" : " '" + name + "'") + ": " + why);
}

constexpr const char* kNoPose = "its pose is none: R must be a rotation and t finite";
constexpr const char* kTooFar = "it is too far away; t must be within 1e6 m";

}  // namespace

Core core_of(const Body& body) {
  Core core;
  core.T_base_core = body.T_base_body;
  switch (body.kind) {
    case Shape::Kind::kCapsule:
      core.half[2] = 0.5 * body.length;
      core.radius = body.radius;
      break;
    case Shape::Kind::kSphere:
      core.radius = body.radius;
      break;
    case Shape::Kind::kBox:
      core.half = 0.5 * body.size;
      core.edged = true;
      break;
  }
  return core;
}

double reach(const Core& core) {
  return norm(core.half) + core.radius;
}

double distance(const Core& core, const Vector3& point) {
  const auto& R = core.T_base_core.R;
  const Vector3 d = point - core.T_base_core.t;
  Vector3 excess, out;
  for (int k = 0; k < 3; ++k) {
    excess[k] = std::fabs(R[k] * d[0] + R[3 + k] * d[1] + R[6 + k] * d[2]) - core.half[k];
    out[k] = std::max(excess[k], 0.0);
  }
  const double inside = std::min(std::max({excess[0], excess[1], excess[2]}), 0.0);
  return norm(out) + inside - core.radius;
}

double distance(const Core& a, const Core& b) {
  // Where two boxes overlap, an edge of one of them passes through the other; where they do not, an edge of one of them
  // holds a point that is nearest to the other.
  double squared = a.edged && !b.edged ? squared_distance_of_edges(b, a) : squared_distance_of_edges(a, b);
  if (a.edged && b.edged) squared = std::min(squared, squared_distance_of_edges(b, a));
  constexpr double kTouch = 1e-12;  // m; rounding: bodies this near touch
  const double d = std::sqrt(squared) - a.radius - b.radius;
  return d > kTouch ? d : 0;
}

void check(const Pose& pose, const char* what) {
  if (!is_pose(pose) || !std::isfinite(norm(pose.t))) fail(what, {}, kNoPose);
  if (!is_near(pose.t)) fail(what, {}, kTooFar);
}

void check(const Body& body, const char* what, const std::string& name) {
  const bool has_radius = body.kind != Shape::Kind::kBox;
  if (has_radius && !is_size(body.radius)) fail(what, name, "its radius must be from 0 to 1e6 m");
  if (body.kind == Shape::Kind::kCapsule && !is_size(body.length)) {
    fail(what, name, "its length must be from 0 to 1e6 m");
  }
  if (!has_radius && !(is_size(body.size[0]) && is_size(body.size[1]) && is_size(body.size[2]))) {
    fail(what, name, "its size must be from 0 to 1e6 m along each edge");
  }
  const Pose& pose = body.T_base_body;
  if (!is_pose(pose) || !std::isfinite(norm(pose.t))) fail(what, name, kNoPose);
  if (!is_near(pose.t)) fail(what, name, kTooFar);
}

// ---- Bodies ---------------------------------------------------------------------------------------------------------

Body placed(const Shape& shape, const Pose& T_base_link) {
  return {shape.kind, shape.radius, shape.length, shape.size, T_base_link * shape.T_link_shape};
}

std::vector<Body> bodies_of(const Arm& arm, const JointVector& q) {
  const std::vector<Pose> links = arm.link_poses(q);
  std::vector<Body> bodies;
  bodies.reserve(arm.shapes().size());
  for (const Shape& shape : arm.shapes()) bodies.push_back(placed(shape, links[shape.link]));
  return bodies;
}

double distance(const Body& body, const Vector3& point) {
  return distance(core_of(body), point);
}

double distance(const Body& a, const Body& b) {
  return distance(core_of(a), core_of(b));
}

}  // namespace handhold::plan
