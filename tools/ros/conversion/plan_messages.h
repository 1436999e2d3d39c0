// Plans as messages. Templates, as result_messages.h.
#pragma once

#include <string>
#include <vector>

#include "handhold/planner.h"
#include "motion.h"
#include "result_messages.h"

namespace handhold::ros_bridge {

template <class PoseMessage>
void set_pose(const plan::Pose& pose, PoseMessage& out) {
  set_xyz(pose.t, out.position);
  set_quaternion(quaternion_of(pose.R), out.orientation);
}

/// @param duration  makes the message's duration of seconds: ros::Duration, or rclcpp::Duration::from_seconds
template <class Header, class Duration, class Trajectory>
void to_message(const plan::Arm& arm, const std::vector<plan::JointVector>& path, const std::vector<double>& times,
                const Header& header, Duration&& duration, Trajectory& out) {
  out.header = header;
  out.joint_names.clear();
  for (const plan::Joint& joint : arm.joints()) out.joint_names.push_back(joint.name);
  out.points.resize(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    out.points[i].positions = path[i];
    out.points[i].time_from_start = duration(times[i]);
  }
}

/// A trajectory's stamp says when it begins; none is "at once".
template <class Header, class Duration, class GraspMessage>
void to_message(const plan::Arm& arm, const plan::Grasp& grasp, const Header& header, Duration&& duration,
                GraspMessage& out) {
  Header at_once;
  at_once.frame_id = header.frame_id;
  out.handle = static_cast<std::uint32_t>(grasp.handle);
  set_pose(grasp.pregrasp, out.pregrasp);
  set_pose(grasp.grasp, out.grasp);
  set_pose(grasp.lifted, out.lifted);
  out.opening = grasp.opening;
  out.width = grasp.width;
  set_xyz(grasp.approach, out.approach);
  out.angle = grasp.angle;
  out.tilt = grasp.tilt;
  out.flipped = grasp.flipped;
  to_message(arm, grasp.path, grasp.times, at_once, duration, out.path);
  out.pregrasp_index = static_cast<std::uint32_t>(grasp.pregrasp_index);
  to_message(arm, grasp.lift_path, grasp.lift_times, at_once, duration, out.lift_path);
}

template <class RejectionMessage>
void to_message(const plan::Rejection& rejection, RejectionMessage& out) {
  out.handle = static_cast<std::uint32_t>(rejection.handle);
  out.reason = std::string(to_string(rejection.reason));
  out.what = rejection.what;
  out.reasons.clear();
  out.counts.clear();
  for (std::size_t i = 0; i < plan::kReasons; ++i) {
    if (rejection.counts[i] == 0) continue;
    out.reasons.push_back(std::string(to_string(static_cast<plan::Reason>(i))));
    out.counts.push_back(static_cast<std::uint32_t>(rejection.counts[i]));
  }
}

}  // namespace handhold::ros_bridge
