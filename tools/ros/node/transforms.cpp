#include "transforms.h"

#include <ros/init.h>

#include <algorithm>
#include <vector>

#include "motion.h"

namespace handhold::ros_bridge {

Motion Transforms::at(const std::string& target, const std::string& source, const ros::Time& time,
                      double timeout_s) const {
  if (target == source) return {};
  if (source.empty()) {
    throw TransformError("no transform to '" + target + "': the message's header has no frame_id");
  }
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(timeout_s);
  while (!buffer_.canTransform(target, source, time) && ros::WallTime::now() < end && ros::ok()) {
    ros::WallDuration(0.002).sleep();
  }
  try {
    const geometry_msgs::TransformStamped found = buffer_.lookupTransform(target, source, time);
    const auto& q = found.transform.rotation;
    const auto& t = found.transform.translation;
    return motion({q.x, q.y, q.z, q.w}, {t.x, t.y, t.z});
  } catch (const tf2::TransformException& error) {
    std::string why = error.what();
    std::replace(why.begin(), why.end(), '\n', ' ');
    std::vector<std::string> frames;
    buffer_._getFrameStrings(frames);
    std::string known;
    for (const std::string& frame : frames) known += (known.empty() ? "" : ", ") + frame;
    throw TransformError("no transform from '" + source + "' to '" + target + "': " + why +
                         (known.empty() ? " Nobody publishes transforms." : " Known frames: " + known));
  }
}

}  // namespace handhold::ros_bridge
