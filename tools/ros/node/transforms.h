// Where frames are, from tf2.
#pragma once

#include <ros/time.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <stdexcept>
#include <string>

#include "handhold/tracker.h"

namespace handhold::ros_bridge {

/// A transform that is not there. what() is one line: from where to where, why not, which frames are known.
class TransformError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Transforms {
 public:
  Transforms() : listener_(buffer_) {}

  /// T_target_source at a time; waits for it for up to `timeout_s` of the wall clock: the ROS time may stand still.
  /// @throws TransformError
  Motion at(const std::string& target, const std::string& source, const ros::Time& time, double timeout_s) const;

 private:
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
};

}  // namespace handhold::ros_bridge
