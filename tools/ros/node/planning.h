// The planner service's work. Without handhold::plan in the build it cannot plan.
#pragma once

#include <handhold_ros/PlanGrasps.h>
#include <sensor_msgs/PointCloud2.h>

#include <functional>
#include <string>
#include <vector>

#include "handhold/result.h"
#include "handhold/tracker.h"
#include "settings.h"

namespace handhold::ros_bridge {

/// The last cloud that was searched; `cloud` is null before the first one.
struct SearchedFrame {
  sensor_msgs::PointCloud2ConstPtr cloud;
  std::vector<Handle> handles;  ///< in the cloud's frame
};

/// T_target_source at the cloud's time. Throws TransformError.
using Lookup = std::function<Motion(const std::string& target, const std::string& source)>;

/// Null: this program cannot plan.
ArmOptions planning_arm_options();

/// Everything but success and message.
/// @throws std::exception, one line
void plan_grasps(const SearchedFrame& frame, const Settings& settings, const Lookup& lookup,
                 const handhold_ros::PlanGrasps::Request& request, handhold_ros::PlanGrasps::Response& response);

}  // namespace handhold::ros_bridge
