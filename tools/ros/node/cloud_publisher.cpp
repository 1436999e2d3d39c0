// cloud_publisher: a PCD or PLY file as a PointCloud2, once (latched) or again and again.
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <cstring>
#include <exception>
#include <string>

#include "handhold/io.h"

namespace {

/// x, y and z as floats, point_step 16 as depth cameras have it.
sensor_msgs::PointCloud2 message_of(const handhold::Cloud& cloud) {
  constexpr std::uint32_t kStep = 16;
  sensor_msgs::PointCloud2 message;
  sensor_msgs::PointCloud2Modifier(message).setPointCloud2Fields(3, "x", 1, sensor_msgs::PointField::FLOAT32, "y", 1,
                                                                 sensor_msgs::PointField::FLOAT32, "z", 1,
                                                                 sensor_msgs::PointField::FLOAT32);
  message.width = cloud.width;
  message.height = cloud.height;
  message.point_step = kStep;
  message.row_step = kStep * cloud.width;
  message.is_dense = false;
  message.data.assign(std::size_t{kStep} * cloud.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) std::memcpy(&message.data[kStep * i], &cloud.xyz[3 * i], 12);
  return message;
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "cloud_publisher");
  ros::NodeHandle node, private_node("~");
  std::string file, frame;
  double rate = 0;
  int count = 0;
  const std::string where = private_node.getNamespace();
  if (!private_node.getParam("file", file) || !private_node.getParam("frame", frame) || file.empty() || frame.empty()) {
    ROS_FATAL("%s: parameters file (PCD or PLY) and frame (of its points) are needed", where.c_str());
    return 2;
  }
  private_node.param("rate", rate, 0.0);
  private_node.param("count", count, 0);
  if (!(rate >= 0 && rate <= 1000) || count < 0) {
    ROS_FATAL("%s: rate must be from 0 (once, latched) to 1000 Hz, and count 0 (no end) or more", where.c_str());
    return 2;
  }
  sensor_msgs::PointCloud2 message;
  try {
    message = message_of(handhold::read_cloud(file));
  } catch (const std::exception& error) {
    ROS_FATAL("%s: %s", where.c_str(), error.what());
    return 1;
  }
  message.header.frame_id = frame;

  ros::Publisher publisher = node.advertise<sensor_msgs::PointCloud2>("cloud", 2, rate == 0);
  if (rate == 0) {
    message.header.stamp = ros::Time::now();
    publisher.publish(message);
    ros::spin();
    return 0;
  }
  ros::WallRate due(rate);
  // What is sent before somebody listens is no part of the count.
  while (ros::ok() && count > 0 && publisher.getNumSubscribers() == 0) due.sleep();
  for (int sent = 0; ros::ok() && (count == 0 || sent < count); ++sent) {
    message.header.stamp = ros::Time::now();
    publisher.publish(message);
    ros::spinOnce();
    due.sleep();
  }
  if (ros::ok()) ROS_INFO("%s: sent %d clouds", where.c_str(), count);
  // The last ones are still on their way; whoever started us ends us.
  ros::spin();
  return 0;
}
