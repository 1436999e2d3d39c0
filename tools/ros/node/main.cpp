// handhold_node: handles in the clouds of a topic.
#include <ros/ros.h>

#include "node.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "handhold");
  handhold::ros_bridge::Node node;
  ros::AsyncSpinner spinner(2);
  spinner.start();
  ros::waitForShutdown();
  return 0;
}
