// What an arm must keep clear of: the points that a depth camera saw, and bodies that are known. Part of
// handhold::plan.
//
//   plan::Obstacles obstacles;
//   obstacles.set_cloud(cloud.view(), T_base_camera);
//   obstacles.add("table", table);
//   const std::vector<plan::Pose> links = arm.link_poses(q);
//   for (const plan::Shape& s : arm.shapes()) hit |= obstacles.within(plan::placed(s, links[s.link]), 0.01);
//
// Metres; the frame `base` is the arm's base link.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "handhold/arm.h"
#include "handhold/cloud.h"

namespace handhold::plan {

/// A convex body at its place.
struct Body {
  Shape::Kind kind = Shape::Kind::kSphere;
  double radius = 0;         ///< m; of a capsule or sphere
  double length = 0;         ///< m; of a capsule's segment, on z about the origin
  Vector3 size = {0, 0, 0};  ///< m; edges of a box
  Pose T_base_body;
};
Body placed(const Shape& shape, const Pose& T_base_link);
/// All of an arm's shapes in a posture, hand open.
std::vector<Body> bodies_of(const Arm& arm, const JointVector& q);

/// Distance (m) of a point (base frame) from a body's surface; negative inside.
double distance(const Body& body, const Vector3& point);
/// Distance (m) between two bodies, to rounding; 0 when they touch or overlap.
double distance(const Body& a, const Body& b);

struct CloudObstacleOptions {
  /// Of an organized cloud (not of a single column): a point that fewer than this many of its eight neighbours in the
  /// image are near to (within speck_distance) is no obstacle. Sensors make up such points between a thing and its
  /// background, where fingers go.
  int speck_neighbours = 3;      ///< 0 .. 8; 0: every point counts
  double speck_distance = 0.01;  ///< m, > 0
  /// What the camera saw of the robot itself: points within own_margin of these bodies (base frame) are no obstacles.
  std::vector<Body> own = {};
  double own_margin = 0.02;  ///< m, >= 0
};

/// Queries are const and may run on several threads at once; whatever changes the obstacles may not overlap them.
class Obstacles {
 public:
  Obstacles();
  ~Obstacles();
  Obstacles(Obstacles&&) noexcept;
  Obstacles& operator=(Obstacles&&) noexcept;

  /// Takes the finite points of a cloud, instead of those of the cloud before; reuses memory. Points with a coordinate
  /// beyond 1e6 m are left out. Runs in the caller's TBB arena.
  /// @throws std::invalid_argument for a cloud view or pose that is none, an option out of range or a bad own body
  void set_cloud(const CloudView& cloud, const Pose& T_base_cloud, const CloudObstacleOptions& options = {});
  /// Points that are obstacles.
  std::size_t points() const;

  /// Adds a body that is known: a table, a wall. @throws std::invalid_argument for a size that is negative or not
  /// finite, a pose that is none, or either beyond 1e6 m
  void add(const std::string& name, const Body& body);
  void clear_bodies();

  /// What is nearest to a body.
  struct Nearest {
    double distance = std::numeric_limits<double>::infinity();  ///< m; as the functions `distance` above
    bool is_point = false;                                      ///< of the cloud, otherwise a known body
    Vector3 point = {0, 0, 0};                                  ///< m; base frame; that point
    std::size_t body = 0;  ///< index of that body, in the order in which they were added
  };
  /// What is nearest, if it is nearer than `limit` (m); otherwise its distance is `limit` and nothing else is said.
  /// Exact to 1e-5 m for bodies within 10 m of the camera: points are single precision, in the cloud's frame.
  /// @throws std::invalid_argument for a bad body as add(), or a limit or margin that is NaN, here and below
  Nearest nearest(const Body& body, double limit = std::numeric_limits<double>::infinity()) const;
  /// Whether a point is nearer than `margin` (m), or a known body is nearer or overlaps; faster than nearest().
  bool within(const Body& body, double margin) const;
  const std::string& name(std::size_t body) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handhold::plan
