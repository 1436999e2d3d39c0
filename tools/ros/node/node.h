// The ROS 1 node: clouds in, handles out. All that is not ROS is in ../conversion.
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <handhold_ros/AffordanceList.h>
#include <handhold_ros/HandleList.h>
#include <handhold_ros/PlanGrasps.h>
#include <handhold_ros/TrackList.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "frame_search.h"
#include "frame_statistics.h"
#include "mailbox.h"
#include "message_pool.h"
#include "planning.h"
#include "settings.h"
#include "transforms.h"

namespace handhold::ros_bridge {

/// An error that goes on is said once in a while, and when it changes.
class RepeatedError {
 public:
  /// Whether it is time to say it. For one thread.
  bool is_due(const std::string& text);

 private:
  std::string last_;
  ros::WallTime said_;
};

class Node {
 public:
  Node();
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

 private:
  using Cloud = sensor_msgs::PointCloud2;
  struct Arrived {
    boost::shared_ptr<const Cloud> cloud;
    ros::Time time;      ///< when it was there as an object
    ros::WallTime wall;  ///< the same
  };

  void receive(const ros::MessageEvent<const Cloud>& event);
  bool reload(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  bool plan(handhold_ros::PlanGrasps::Request& request, handhold_ros::PlanGrasps::Response& response);
  void diagnose();

  void work();
  void search(const Arrived& arrived);
  void skip(const std::string& reason);
  FramePlace place_of(const Cloud& cloud);
  void publish(const Cloud& cloud);

  /// Reads all parameters anew. What is wrong.
  std::vector<std::string> read_parameters();
  std::shared_ptr<const Settings> settings() const;
  std::string why_no_cloud() const;

  ros::NodeHandle node_, private_node_{"~"};
  Transforms transforms_;
  FrameStatistics statistics_;
  Mailbox<Arrived> mailbox_;
  MessagePool<Cloud> pool_;

  mutable std::mutex mutex_;  ///< of what follows, up to the next blank line
  std::shared_ptr<const Settings> settings_;
  std::vector<std::string> problems_;
  SearchedFrame searched_;
  std::shared_ptr<FrameSearch> search_;  ///< the worker's; here it is only replaced and cancelled

  // The worker's.
  std::shared_ptr<const Settings> in_use_;
  std::string last_frame_id_;
  ros::Time last_stamp_;
  std::optional<Motion> T_fixed_now_, T_fixed_last_;
  PointCloudMessage message_;
  RepeatedError skip_error_;
  handhold_ros::HandleList handles_;
  handhold_ros::AffordanceList affordances_;
  handhold_ros::TrackList tracks_;
  visualization_msgs::MarkerArray markers_;

  // The timer's.
  RepeatedError input_error_;
  ros::WallTime last_diagnosis_, last_input_ = ros::WallTime::now();
  std::uint64_t last_received_ = 0;

  ros::Publisher handle_publisher_, affordance_publisher_, track_publisher_, marker_publisher_, diagnostics_publisher_;
  ros::CallbackQueue cloud_queue_;  ///< before those who use it
  ros::Subscriber subscriber_;
  ros::ServiceServer reload_service_, plan_service_;
  ros::WallTimer timer_;
  ros::AsyncSpinner cloud_spinner_{1, &cloud_queue_};
  std::thread worker_;  ///< last: it uses the others
};

}  // namespace handhold::ros_bridge
