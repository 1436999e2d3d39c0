#include "plan_output.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "result_json.h"

namespace handhold::planning {
namespace {

using Json = nlohmann::ordered_json;

Json matrix(const plan::Pose& T) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) rows.push_back({T.R[3 * r], T.R[3 * r + 1], T.R[3 * r + 2], T.t[r]});
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

Json grasp_json(const plan::Arm& arm, const std::string& name, const plan::Grasp& grasp) {
  return {{"handle", grasp.handle},
          {"arm", name},
          {"frame", arm.tip()},
          {"pregrasp", matrix(grasp.pregrasp)},
          {"grasp", matrix(grasp.grasp)},
          {"lift", matrix(grasp.lifted)},
          {"opening", grasp.opening},
          {"width", grasp.width},
          {"approach", grasp.approach},
          {"angle", grasp.angle},
          {"tilt", grasp.tilt},
          {"flipped", grasp.flipped},
          {"pregrasp_index", grasp.pregrasp_index},
          {"path", grasp.path},
          {"times", grasp.times},
          {"lift_path", grasp.lift_path},
          {"lift_times", grasp.lift_times}};
}

Json rejection_json(const plan::Rejection& rejection) {
  Json counts = Json::object();
  for (std::size_t i = 0; i < plan::kReasons; ++i) {
    if (rejection.counts[i]) counts[std::string(to_string(static_cast<plan::Reason>(i)))] = rejection.counts[i];
  }
  return {{"handle", rejection.handle},
          {"reason", std::string(to_string(rejection.reason))},
          {"what", rejection.what},
          {"counts", counts}};
}

Json candidate_json(const plan::Candidate& candidate) {
  return {{"handle", candidate.handle},
          {"place", candidate.place},
          {"angle", candidate.angle},
          {"tilt", candidate.tilt},
          {"flipped", candidate.flipped},
          {"reason", candidate.reason ? Json(std::string(to_string(*candidate.reason))) : Json(nullptr)},
          {"what", candidate.what}};
}

std::string with_what(plan::Reason reason, const std::string& what) {
  const bool hits = reason == plan::Reason::kHandHits || reason >= plan::Reason::kArmHitsItself;
  return std::string(to_string(reason)) + (hits && !what.empty() ? " (" + what + ")" : "");
}

/// What is farther from the tip's frame (m) is more arm than hand, and would hide the picture.
constexpr double kHandSize = 0.15;

using Line = std::vector<Vector3>;

/// The twelve edges of a box, in three strokes and two that join them.
std::vector<Line> box_edges(const Vector3& size, const plan::Pose& T) {
  const auto corner = [&](int x, int y, int z) { return T.point({x * size[0] / 2, y * size[1] / 2, z * size[2] / 2}); };
  std::vector<Line> lines;
  for (const int z : {-1, 1}) {
    lines.push_back({corner(-1, -1, z), corner(1, -1, z), corner(1, 1, z), corner(-1, 1, z), corner(-1, -1, z)});
  }
  for (const int x : {-1, 1}) {
    for (const int y : {-1, 1}) lines.push_back({corner(x, y, -1), corner(x, y, 1)});
  }
  return lines;
}

/// The circles at both ends of a cylinder, and four lines along it.
std::vector<Line> cylinder_edges(double radius, double length, const plan::Pose& T) {
  constexpr int kSteps = 24;
  std::vector<Line> lines(6);
  for (int i = 0; i <= kSteps; ++i) {
    const double turn = 2 * 3.141592653589793 * i / kSteps, x = radius * std::cos(turn), y = radius * std::sin(turn);
    for (int end = 0; end < 2; ++end) {
      const Vector3 point = T.point({x, y, (end ? length : -length) / 2});
      lines[static_cast<std::size_t>(end)].push_back(point);
      if (i < kSteps && i % (kSteps / 4) == 0) lines[static_cast<std::size_t>(2 + 4 * i / kSteps)].push_back(point);
    }
  }
  return lines;
}

/// A shape of the hand as it stands at a grasp, open.
struct HandShape {
  const plan::Shape* shape;
  plan::Pose T_camera_shape;
};
std::vector<HandShape> hand_at(const plan::Arm& arm, const plan::Grasp& grasp, const plan::Pose& T_camera_base) {
  const std::vector<plan::Pose> links = arm.link_poses(arm.rest(), grasp.opening);
  const plan::Pose tip = T_camera_base * grasp.grasp;
  const plan::Pose T_camera_links = tip * links[arm.link_index(arm.tip())].inverse();
  std::vector<HandShape> hand;
  for (const plan::Shape& shape : arm.shapes()) {
    if (arm.link_joints()[shape.link] != arm.joints().size()) continue;
    const plan::Pose T = T_camera_links * links[shape.link] * shape.T_link_shape;
    if (std::hypot(T.t[0] - tip.t[0], T.t[1] - tip.t[1], T.t[2] - tip.t[2]) > kHandSize) continue;
    hand.push_back({&shape, T});
  }
  return hand;
}

PageBody page_body(const HandShape& part) {
  const plan::Shape& shape = *part.shape;
  const double across = 2 * shape.radius;
  switch (shape.kind) {
    case plan::Shape::Kind::kBox:
      return {PageBody::Kind::kBox, shape.size, part.T_camera_shape};
    case plan::Shape::Kind::kCapsule:
      return {PageBody::Kind::kCylinder, {across, across, shape.length}, part.T_camera_shape};
    case plan::Shape::Kind::kSphere:
      break;
  }
  return {PageBody::Kind::kSphere, {across, across, across}, part.T_camera_shape};
}

}  // namespace

std::string plan_json(const plan::Arm& arm, const std::string& name, const std::vector<Handle>& handles,
                      const plan::Plan& plan, bool candidates) {
  Json json;
  json["schema"] = "handhold.plan/1";
  json["base"] = arm.base();
  json["joints"] = Json::array();
  for (const plan::Joint& joint : arm.joints()) json["joints"].push_back(joint.name);
  json["grasps"] = Json::array();
  for (const plan::Grasp& grasp : plan.grasps) json["grasps"].push_back(grasp_json(arm, name, grasp));
  json["rejected"] = Json::array();
  for (const plan::Rejection& rejection : plan.rejected) json["rejected"].push_back(rejection_json(rejection));
  json["handles"] = Json::array();
  for (const Handle& handle : handles) json["handles"].push_back(handle_json(handle));
  if (candidates) {
    json["candidates"] = Json::array();
    for (const plan::Candidate& candidate : plan.candidates) json["candidates"].push_back(candidate_json(candidate));
  }
  return to_lines(json);
}

std::string plan_table(const plan::Arm& arm, const plan::Plan& plan) {
  std::string text;
  char line[200];
  if (!plan.grasps.empty()) {
    text += "grasps of " + arm.tip() + " in " + arm.base() +
            ":\n handle   width opening mm        x       y       z mm   approach                angle   time s\n";
  }
  for (const plan::Grasp& grasp : plan.grasps) {
    std::snprintf(line, sizeof line, "%7zu %7.1f %7.1f     %8.1f %7.1f %7.1f      [%5.2f %5.2f %5.2f] %8.0f°  %6.1f\n",
                  grasp.handle + 1, 1000 * grasp.width, 1000 * grasp.opening, 1000 * grasp.grasp.t[0],
                  1000 * grasp.grasp.t[1], 1000 * grasp.grasp.t[2], grasp.approach[0], grasp.approach[1],
                  grasp.approach[2], grasp.angle * 57.29577951308232, grasp.times.back());
    text += line;
  }
  for (const plan::Rejection& rejection : plan.rejected) {
    std::snprintf(line, sizeof line, "%7zu rejected: ", rejection.handle + 1);
    text += line + with_what(rejection.reason, rejection.what) + "\n";
  }
  return text.empty() ? "no handles to grasp\n" : text;
}

std::vector<PictureLine> plan_lines(const plan::Arm& arm, const plan::Plan& plan, const plan::Pose& T_base_camera) {
  const plan::Pose T_camera_base = T_base_camera.inverse();
  std::vector<PictureLine> lines;
  for (const plan::Grasp& grasp : plan.grasps) {
    for (const auto& [shape, T] : hand_at(arm, grasp, T_camera_base)) {
      const bool is_box = shape->kind == plan::Shape::Kind::kBox;
      for (const Line& edge : is_box ? box_edges(shape->size, T) : cylinder_edges(shape->radius, shape->length, T)) {
        lines.push_back({edge, grasp.handle});
      }
    }
    lines.push_back({{T_camera_base.point(grasp.pregrasp.t), T_camera_base.point(grasp.grasp.t)}, grasp.handle});
  }
  return lines;
}

PagePlan page_plan(const plan::Arm& arm, const std::string& name, const plan::Plan& plan,
                   const plan::Pose& T_base_camera) {
  const plan::Pose T_camera_base = T_base_camera.inverse();
  PagePlan page;
  page.arm = name;
  page.base = arm.base();
  page.tip = arm.tip();
  page.T_base_cloud = T_base_camera;
  for (const plan::Grasp& grasp : plan.grasps) {
    PageGrasp shown;
    shown.handle = grasp.handle;
    for (const HandShape& part : hand_at(arm, grasp, T_camera_base)) shown.hand.push_back(page_body(part));
    shown.from = T_camera_base.point(grasp.pregrasp.t);
    shown.to = T_camera_base.point(grasp.grasp.t);
    shown.width = grasp.width;
    shown.opening = grasp.opening;
    shown.time = grasp.times.back();
    page.grasps.push_back(std::move(shown));
  }
  for (const plan::Rejection& rejection : plan.rejected) {
    page.rejected.push_back({rejection.handle, with_what(rejection.reason, rejection.what)});
  }
  return page;
}

}  // namespace handhold::planning
