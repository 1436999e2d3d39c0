#include "planning.h"

#include <ros/time.h>

#include <cstdio>
#include <stdexcept>
#include <utility>

#include "arm_settings.h"
#include "plan_messages.h"
#include "point_cloud.h"
#include "threads.h"

namespace handhold::ros_bridge {
namespace {

plan::JointVector start_of(const plan::Arm& arm, const std::vector<double>& start) {
  if (arm.within_limits(start)) return start;
  std::string limits;
  char text[64];
  for (const plan::Joint& joint : arm.joints()) {
    std::snprintf(text, sizeof text, " from %.4g to %.4g", joint.lower, joint.upper);
    limits += (limits.empty() ? "" : ", ") + joint.name + text;
  }
  throw std::invalid_argument("start: must be one position for each joint within its limits: " + limits);
}

}  // namespace

ArmOptions planning_arm_options() {
  return [](const Texts& arm) { return arm_settings(arm).chosen.options; };
}

void plan_grasps(const SearchedFrame& frame, const Settings& settings, const Lookup& lookup,
                 const handhold_ros::PlanGrasps::Request& request, handhold_ros::PlanGrasps::Response& response) {
  if (settings.arm.empty()) {
    throw std::invalid_argument(
        "no arm is chosen; set the parameter arm ('right' or 'left' of Baxter) or arm_file, and "
        "call reload");
  }
  if (!frame.cloud) throw std::invalid_argument("no cloud has been searched yet");
  const std_msgs::Header& header = frame.cloud->header;
  const double age = (ros::Time::now() - header.stamp).toSec();
  if (request.max_age > 0 && age > request.max_age) {
    throw std::invalid_argument("the last cloud is " + std::to_string(age) + " s old; max_age is " +
                                std::to_string(request.max_age) + " s");
  }
  ArmSettings arm = arm_settings(settings.arm);
  if (!request.start.empty()) arm.planner.start = start_of(arm.chosen.arm, request.start);
  if (request.grasps > 0) arm.planner.max_grasps = request.grasps;

  const std::string base = settings.base_frame.empty() ? arm.chosen.arm.base() : settings.base_frame;
  const Motion T = lookup(base, header.frame_id);
  plan::Pose T_base_cloud;
  T_base_cloud.R = T.R;
  T_base_cloud.t = T.t;
  plan::GraspPlanner planner(arm.chosen.arm, arm.planner);
  planning::add_known(arm.arguments, planner.obstacles());
  PointCloudMessage message;
  point_cloud_view(*frame.cloud, message);
  PointCloudReader reader;
  plan::Plan plan;
  // The arm stands where the camera may see it.
  plan::CloudObstacleOptions seen;
  seen.own =
      plan::bodies_of(planner.arm(), planner.options().start.empty() ? planner.arm().rest() : planner.options().start);
  with_threads(settings.options.threads, [&] {
    planner.obstacles().set_cloud(reader.read(message), T_base_cloud, seen);
    plan = planner.plan(frame.handles, T_base_cloud);
  });

  response.header.frame_id = base;
  response.header.stamp = header.stamp;
  response.handles_frame = header.frame_id;
  response.handles.resize(frame.handles.size());
  for (std::size_t i = 0; i < frame.handles.size(); ++i) to_message(frame.handles[i], response.handles[i]);
  const auto duration = [](double seconds) { return ros::Duration(seconds); };
  response.grasps.resize(plan.grasps.size());
  for (std::size_t i = 0; i < plan.grasps.size(); ++i) {
    to_message(planner.arm(), plan.grasps[i], response.header, duration, response.grasps[i]);
  }
  response.rejected.resize(plan.rejected.size());
  for (std::size_t i = 0; i < plan.rejected.size(); ++i) to_message(plan.rejected[i], response.rejected[i]);
}

}  // namespace handhold::ros_bridge
