// Arms, handles and scenes that the planner's tests share.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arm_helpers.h"
#include "handhold/planner.h"
#include "handhold/sensor.h"
#include "vec3.h"

namespace handhold::plan {

inline const Vector3 kX = {1, 0, 0}, kY = {0, 1, 0}, kZ = {0, 0, 1};
inline Vector3 column(const Pose& T, int k) {
  return {T.R[k], T.R[3 + k], T.R[6 + k]};
}

// ---- A gantry -------------------------------------------------------------------------------------------------------

/// A wrist that slides along x, y, z and turns about z, y, x, and a gripper 0.1 m before it: its joints follow from the
/// hand's pose with pencil and paper. A weight of 0.1 m hangs on the z slide, at (-0.2, 0, 0.2) from the wrist.
inline constexpr double kWristToTip = 0.1;
struct Gantry {
  double x_limit = 2;    ///< m; of the slide along x, both ways
  double velocity = 1;   ///< m/s, rad/s
  std::string fixed;     ///< collision elements of the link that does not move
  double opening = 0.1;  ///< m
};
inline std::string collision_box(const Vector3& at, const Vector3& size) {
  const auto text = [](const Vector3& v) {
    return std::to_string(v[0]) + " " + std::to_string(v[1]) + " " + std::to_string(v[2]);
  };
  return "<collision><origin xyz=\"" + text(at) + "\"/><geometry><box size=\"" + text(size) +
         "\"/></geometry></collision>";
}
inline std::string gantry_urdf(const Gantry& gantry) {
  std::string urdf = "<robot name=\"gantry\"><link name=\"base\">" + gantry.fixed + "</link>";
  std::string parent = "base";
  const auto joint = [&](const std::string& name, const std::string& type, const std::string& axis, double limit,
                         const std::string& body) {
    urdf += "<link name=\"" + name + "_link\">" + body + "</link><joint name=\"" + name + "\" type=\"" + type +
            "\"><parent link=\"" + parent + "\"/><child link=\"" + name + "_link\"/><axis xyz=\"" + axis +
            "\"/><limit lower=\"" + std::to_string(-limit) + "\" upper=\"" + std::to_string(limit) +
            "\" effort=\"1\" velocity=\"" + std::to_string(gantry.velocity) + "\"/></joint>";
    parent = name + "_link";
  };
  joint("x", "prismatic", "1 0 0", gantry.x_limit, "");
  joint("y", "prismatic", "0 1 0", 1, "");
  joint("z", "prismatic", "0 0 1", 1, collision_box({-0.2, 0, 0.2}, {0.1, 0.1, 0.1}));
  joint("yaw", "revolute", "0 0 1", 3.5, "");
  joint("pitch", "revolute", "0 1 0", 3.5, "");
  joint("roll", "revolute", "1 0 0", 3.5, "");
  // The tip's z is the wrist's x, its y the wrist's y.
  urdf += "<link name=\"hand\">" + collision_box({0, 0, -0.06}, {0.04, 0.14, 0.02}) +
          "</link><joint name=\"mounting\" type=\"fixed\"><parent link=\"roll_link\"/><child link=\"hand\"/>"
          "<origin xyz=\"0.1 0 0\" rpy=\"0 1.5707963267948966 0\"/></joint>";
  for (const int side : {1, -1}) {
    const std::string name = side > 0 ? "left" : "right";
    urdf += "<link name=\"" + name + "_finger\">" + collision_box({0, side * 0.005, -0.02}, {0.02, 0.01, 0.06}) +
            "</link><joint name=\"" + name + "\" type=\"prismatic\"><parent link=\"hand\"/><child link=\"" + name +
            "_finger\"/><axis xyz=\"0 " + std::to_string(side) + " 0\"/><limit lower=\"0\" upper=\"" +
            std::to_string(gantry.opening / 2) + "\" effort=\"1\" velocity=\"1\"/></joint>";
  }
  return urdf + "</robot>";
}
inline Arm gantry_arm(const Gantry& gantry = {}) {
  Hand hand;
  hand.opening_max = gantry.opening;
  hand.finger_joints = {"left", "right"};
  return Arm::from_urdf(gantry_urdf(gantry), "base", "hand", hand);
}

inline Handle handle_at(const Vector3& center, const Vector3& axis, const Vector3& approach, double radius = 0.02,
                        double length = 0.1) {
  Handle handle{};
  handle.center = center, handle.axis = normalized(axis), handle.approach = normalized(approach);
  handle.radius = radius, handle.length = length, handle.confidence = 0.9;
  return handle;
}
/// Half a metre before the gantry; its wrist is at the origin at first.
inline Handle gantry_handle() {
  return handle_at({0.5, 0, 0}, kZ, kX);
}
/// One direction, the handle's, in both flips.
inline PlannerOptions one_approach() {
  PlannerOptions options;
  options.max_angle = 0;
  options.places = {0};
  options.depths = {0};
  options.tilts = {0};
  return options;
}
inline Body box_body(const Vector3& at, const Vector3& size) {
  Body body;
  body.kind = Shape::Kind::kBox;
  body.size = size;
  body.T_base_body.t = at;
  return body;
}

// ---- Baxter before a table ------------------------------------------------------------------------------------------

/// A can on a table, and what a camera at Baxter's chest sees of them, without noise.
struct CanScene {
  sensor::Pose T_base_camera;
  Cloud cloud;
  std::vector<Handle> handles;  ///< the can's, camera frame
  Vector3 can;                  ///< m; base frame; the middle of its axis
};
inline constexpr double kTableTop = -0.15, kCanRadius = 0.022, kCanHeight = 0.2;

/// @param side  1: the table's left half (+y), -1: the right one
inline CanScene can_scene(int side = -1) {
  CanScene made;
  made.can = {0.7, side * 0.2, kTableTop + kCanHeight / 2};
  sensor::Scene scene;
  scene.add(sensor::table(0.6, 1.2), sensor::translation(0.75, 0, kTableTop));
  scene.add({"can", sensor::cylinder(kCanRadius, kCanHeight), {}, {}},
            sensor::translation(made.can[0], made.can[1], kTableTop));
  sensor::CameraOptions options;
  options.width = 160, options.height = 120, options.fx = options.fy = 144, options.cx = 79.5, options.cy = 59.5;
  const Vector3 eye = {0.15, 0, 0.45};
  made.T_base_camera = sensor::look_at(eye, {0.75, 0, kTableTop});
  made.cloud = sensor::DepthCamera(options).capture(scene, made.T_base_camera).cloud;

  const sensor::Pose T_camera_base = made.T_base_camera.inverse();
  Vector3 away = made.can - eye;
  away[2] = 0;
  made.handles = {handle_at(T_camera_base.point(made.can), T_camera_base.direction(kZ),
                            T_camera_base.direction(normalized(away)), kCanRadius, kCanHeight)};
  return made;
}
/// Every point counts as an obstacle.
inline CloudObstacleOptions every_point() {
  CloudObstacleOptions options;
  options.speck_neighbours = 0;
  return options;
}
inline GraspPlanner planner_for(const CanScene& scene, const Arm& arm, const PlannerOptions& options = {}) {
  GraspPlanner planner(arm, options);
  planner.obstacles().set_cloud(scene.cloud.view(), scene.T_base_camera, every_point());
  return planner;
}
inline std::vector<Vector3> points_in_base(const CanScene& scene) {
  std::vector<Vector3> points;
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
    const float* p = scene.cloud.xyz.data() + 3 * i;
    if (!std::isfinite(p[0])) continue;
    points.push_back(
        scene.T_base_camera.point({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}));
  }
  return points;
}

/// The same to the last bit.
inline bool same(const Grasp& a, const Grasp& b) {
  const auto same_pose = [](const Pose& p, const Pose& q) { return p.R == q.R && p.t == q.t; };
  return a.handle == b.handle && same_pose(a.pregrasp, b.pregrasp) && same_pose(a.grasp, b.grasp) &&
         same_pose(a.lifted, b.lifted) && a.opening == b.opening && a.width == b.width && a.approach == b.approach &&
         a.angle == b.angle && a.flipped == b.flipped && a.path == b.path && a.lift_path == b.lift_path &&
         a.times == b.times && a.lift_times == b.lift_times && a.pregrasp_index == b.pregrasp_index;
}

}  // namespace handhold::plan
