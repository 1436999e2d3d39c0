#include "node.h"

#include <algorithm>
#include <cctype>
#include <exception>
#include <utility>

#include "handhold/localizer.h"
#include "markers.h"
#include "motion.h"
#include "parameters.h"
#include "result_messages.h"

namespace handhold::ros_bridge {
namespace {

double ms(const ros::WallDuration& duration) {
  return 1e3 * duration.toSec();
}
double ms(const ros::Duration& duration) {
  return 1e3 * duration.toSec();
}

/// How often the timer asks whether something is due (s).
constexpr double kTick = 0.1;

}  // namespace

bool RepeatedError::is_due(const std::string& text) {
  constexpr double kAgain = 5;  // s
  // Times and counts in a text make it no other one.
  std::string kind = text;
  kind.erase(std::remove_if(kind.begin(), kind.end(), [](unsigned char c) { return std::isdigit(c); }), kind.end());
  const ros::WallTime now = ros::WallTime::now();
  if (kind == last_ && (now - said_).toSec() < kAgain) return false;
  last_ = std::move(kind);
  said_ = now;
  return true;
}

Node::Node() {
  settings_ = std::make_shared<const Settings>();
  read_parameters();

  constexpr int kQueue = 10;
  handle_publisher_ = private_node_.advertise<handhold_ros::HandleList>("handles", kQueue);
  affordance_publisher_ = private_node_.advertise<handhold_ros::AffordanceList>("affordances", kQueue);
  track_publisher_ = private_node_.advertise<handhold_ros::TrackList>("tracks", kQueue);
  marker_publisher_ = private_node_.advertise<visualization_msgs::MarkerArray>("markers", kQueue);
  diagnostics_publisher_ = node_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", kQueue);
  reload_service_ = private_node_.advertiseService("reload", &Node::reload, this);
  plan_service_ = private_node_.advertiseService("plan", &Node::plan, this);

  worker_ = std::thread([this] { work(); });

  // A queue and a thread of its own: a cloud never waits for a service, and taking one takes no longer than its bytes.
  ros::SubscribeOptions options;
  options.initByFullCallbackType<const ros::MessageEvent<const Cloud>&>(
      "cloud", 2, [this](const ros::MessageEvent<const Cloud>& event) { receive(event); },
      [this] { return pool_.take(); });
  options.callback_queue = &cloud_queue_;
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  subscriber_ = node_.subscribe(options);
  cloud_spinner_.start();
  timer_ = node_.createWallTimer(ros::WallDuration(kTick), [this](const ros::WallTimerEvent&) { diagnose(); });
  ROS_INFO("clouds from %s, handles to %s, kernels %s", subscriber_.getTopic().c_str(),
           handle_publisher_.getTopic().c_str(), Localizer::isa());
}

Node::~Node() {
  timer_.stop();
  subscriber_.shutdown();
  cloud_spinner_.stop();
  reload_service_.shutdown();
  plan_service_.shutdown();
  mailbox_.close();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (search_) search_->cancel();
  }
  worker_.join();
}

// ---- Clouds ---------------------------------------------------------------------------------------------------------

void Node::receive(const ros::MessageEvent<const Cloud>& event) {
  const boost::shared_ptr<const Cloud> cloud = event.getConstMessage();
  const bool dropped = mailbox_.put({cloud, ros::Time::now(), ros::WallTime::now()});
  statistics_.received(event.getPublisherName(), cloud->header.seq, dropped);
}

void Node::work() {
  while (const std::optional<Arrived> arrived = mailbox_.take()) {
    try {
      search(*arrived);
    } catch (const MessageError& error) {
      skip("cloud on " + subscriber_.getTopic() + " passed over: " + error.what());
    } catch (const TransformError& error) {
      skip("cloud on " + subscriber_.getTopic() + " passed over: " + error.what());
    } catch (const std::exception& error) {
      skip("cloud on " + subscriber_.getTopic() + " failed: " + error.what());
      in_use_.reset();  // after a failure inside a frame a localizer may only be destroyed
    }
  }
}

void Node::skip(const std::string& reason) {
  statistics_.skipped(reason);
  if (skip_error_.is_due(reason)) ROS_ERROR("%s", reason.c_str());
}

void Node::search(const Arrived& arrived) {
  const std::shared_ptr<const Settings> wanted = settings();
  if (in_use_ != wanted) {
    auto fresh = std::make_shared<FrameSearch>(*wanted);
    if (!fresh->backend_reason().empty()) {
      ROS_INFO("backend = auto: on the CPU: %s", fresh->backend_reason().c_str());
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    search_ = std::move(fresh);
    in_use_ = wanted;
    T_fixed_now_.reset();
    T_fixed_last_.reset();
  }
  FrameTimes times;
  const Cloud& cloud = *arrived.cloud;
  times.delivery = ms(arrived.time - cloud.header.stamp);
  const ros::WallTime begin = ros::WallTime::now();
  times.waiting = ms(begin - arrived.wall);

  if (cloud.header.frame_id != last_frame_id_ || cloud.header.stamp < last_stamp_) {
    search_->begin_anew();
    T_fixed_now_.reset();
    T_fixed_last_.reset();
  }
  last_frame_id_ = cloud.header.frame_id;
  last_stamp_ = cloud.header.stamp;
  const FramePlace place = place_of(cloud);
  const ros::WallTime placed = ros::WallTime::now();
  point_cloud_view(cloud, message_);
  search_->take(message_, place);
  const ros::WallTime converted = ros::WallTime::now();
  search_->search();
  T_fixed_last_ = T_fixed_now_;  // only now: the tracks stay where they are when a cloud is passed over
  const ros::WallTime found = ros::WallTime::now();
  if (search_->result().status == Status::kCancelled) return;
  {
    // First: who gets these handles may ask for grasps of them at once.
    const std::lock_guard<std::mutex> lock(mutex_);
    searched_.cloud = arrived.cloud;
    searched_.handles = search_->result().handles;
  }
  publish(cloud);
  const ros::WallTime sent = ros::WallTime::now();

  times.waiting += ms(placed - begin);  // for transforms
  times.conversion = ms(converted - placed);
  times.search = ms(found - converted);
  times.publish = ms(sent - found);
  times.total = ms(ros::Time::now() - cloud.header.stamp);
  statistics_.searched(sent.toSec(), times, search_->result());
}

FramePlace Node::place_of(const Cloud& cloud) {
  const Settings& s = *in_use_;
  const std::string& frame = cloud.header.frame_id;
  const auto T = [&](const std::string& target, const std::string& source) {
    return transforms_.at(target, source, cloud.header.stamp, s.transform_timeout);
  };
  FramePlace place;
  if (s.options.workspace && !s.workspace_frame.empty() && s.workspace_frame != frame) {
    place.T_workspace_cloud = T(s.workspace_frame, frame);
  }
  if (s.viewpoint_frame == "none") {
    place.viewpoint.reset();
  } else if (!s.viewpoint_frame.empty()) {
    place.viewpoint = T(frame, s.viewpoint_frame).t;
  }
  if (s.track && !s.fixed_frame.empty()) {
    T_fixed_now_ = T(s.fixed_frame, frame);
    if (T_fixed_last_) place.T_now_last = inverse(*T_fixed_now_) * *T_fixed_last_;
  }
  return place;
}

void Node::publish(const Cloud& cloud) {
  const Result& result = search_->result();
  const double extent = in_use_->options.finger_width;
  handles_.header = affordances_.header = tracks_.header = cloud.header;
  handle_list(result, handles_);
  handle_publisher_.publish(handles_);
  if (affordance_publisher_.getNumSubscribers() > 0) {
    affordance_list(result, extent, affordances_);
    affordance_publisher_.publish(affordances_);
  }
  if (in_use_->track && track_publisher_.getNumSubscribers() > 0) {
    track_list(search_->tracks(), tracks_);
    track_publisher_.publish(tracks_);
  }
  if (marker_publisher_.getNumSubscribers() > 0) {
    MarkerWriter<visualization_msgs::MarkerArray>::write(cloud.header, result, extent, markers_);
    marker_publisher_.publish(markers_);
  }
}

// ---- Services -------------------------------------------------------------------------------------------------------

std::shared_ptr<const Settings> Node::settings() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return settings_;
}

std::vector<std::string> Node::read_parameters() {
  std::vector<std::string> problems;
  const std::string& where = private_node_.getNamespace();
  const Texts texts = server_parameters(where, problems);
  auto fresh =
      std::make_shared<const Settings>(read_settings(texts, *settings(), where, planning_arm_options(), problems));
  for (const std::string& problem : problems) ROS_ERROR("%s", problem.c_str());
  const std::lock_guard<std::mutex> lock(mutex_);
  settings_ = std::move(fresh);
  problems_ = problems;
  return problems;
}

bool Node::reload(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const std::vector<std::string> problems = read_parameters();
  response.success = problems.empty();
  for (const std::string& problem : problems) response.message += (response.message.empty() ? "" : "\n") + problem;
  return true;
}

bool Node::plan(handhold_ros::PlanGrasps::Request& request, handhold_ros::PlanGrasps::Response& response) {
  SearchedFrame frame;
  std::shared_ptr<const Settings> settings;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    frame = searched_;
    settings = settings_;
  }
  try {
    const auto lookup = [&](const std::string& target, const std::string& source) {
      return transforms_.at(target, source, frame.cloud->header.stamp, settings->transform_timeout);
    };
    plan_grasps(frame, *settings, lookup, request, response);
    response.success = true;
  } catch (const std::exception& error) {
    response = {};
    response.success = false;
    response.message = error.what();
    ROS_ERROR("%s: %s", plan_service_.getService().c_str(), error.what());
  }
  return true;
}

// ---- Diagnostics ----------------------------------------------------------------------------------------------------

void Node::diagnose() {
  const ros::WallTime now = ros::WallTime::now();
  const std::shared_ptr<const Settings> current = settings();
  const FrameStatistics::Summary summary = statistics_.summary();
  if (summary.received != last_received_) last_input_ = now;
  last_received_ = summary.received;
  const bool no_input = (now - last_input_).toSec() > current->input_timeout;
  if ((now - last_diagnosis_).toSec() < current->diagnostics_period) return;
  last_diagnosis_ = now;
  std::string why;
  if (no_input) {
    why = why_no_cloud();
    if (input_error_.is_due(why)) ROS_ERROR("%s", why.c_str());
  }

  diagnostic_msgs::DiagnosticArray array;
  array.header.stamp = ros::Time::now();
  array.status.resize(2);
  const std::string name = ros::this_node::getName().substr(1);
  diagnostic_msgs::DiagnosticStatus& clouds = array.status[0];
  to_message(summary, clouds);
  clouds.name = name + ": clouds";
  if (no_input) {
    clouds.level = diagnostic_msgs::DiagnosticStatus::ERROR;
    clouds.message = why;
  }
  diagnostic_msgs::DiagnosticStatus& parameters = array.status[1];
  parameters.name = name + ": parameters";
  parameters.message = "as given";
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!problems_.empty()) {
    parameters.level = diagnostic_msgs::DiagnosticStatus::ERROR;
    parameters.message = problems_.front();
  }
  diagnostics_publisher_.publish(array);
}

std::string Node::why_no_cloud() const {
  const char* const kType = "sensor_msgs/PointCloud2";
  const std::string topic = subscriber_.getTopic();
  ros::master::V_TopicInfo topics;
  if (!ros::master::getTopics(topics)) return "no cloud on " + topic + ": the ROS master does not answer";
  std::string other, others;
  bool is_published = false;
  for (const ros::master::TopicInfo& info : topics) {
    if (info.name == topic) {
      is_published = true;
      if (info.datatype != kType && info.datatype != "*") other = info.datatype;
    } else if (info.datatype == kType) {
      others += (others.empty() ? "" : ", ") + info.name;
    }
  }
  std::string text = "no cloud on " + topic + ": ";
  if (!other.empty()) {
    text += "it has type " + other + ", not " + kType;
  } else if (is_published) {
    return text + "its publisher sends none";
  } else {
    text += "nobody publishes it";
  }
  return text +
         (others.empty() ? std::string("; no other topic has clouds") : "; remap 'cloud' to one of these: " + others);
}

}  // namespace handhold::ros_bridge
