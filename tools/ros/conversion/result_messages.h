// Results as messages. Templates on the message types: those of ROS 1 and of ROS 2 have the same fields, so one text
// serves both. What concerns time (stamps, lifetimes) comes with the header or is left to the caller.
#pragma once

#include <string>
#include <vector>

#include "handhold/result.h"
#include "handhold/tracker.h"
#include "motion.h"

namespace handhold::ros_bridge {

template <class Message>
void set_xyz(const Vector3& v, Message& out) {
  out.x = v[0];
  out.y = v[1];
  out.z = v[2];
}
template <class Message>
void set_quaternion(const Quaternion& q, Message& out) {
  out.x = q[0];
  out.y = q[1];
  out.z = q[2];
  out.w = q[3];
}

template <class HandleMessage>
void to_message(const Handle& handle, HandleMessage& out) {
  set_xyz(handle.center, out.pose.position);
  set_quaternion(quaternion_of(handle.axis, handle.approach), out.pose.orientation);
  set_xyz(handle.axis, out.axis);
  set_xyz(handle.approach, out.approach);
  out.radius = handle.radius;
  out.length = handle.length;
  out.confidence = handle.confidence;
  out.path.resize(handle.path.size());
  for (std::size_t i = 0; i < handle.path.size(); ++i) set_xyz(handle.path[i], out.path[i]);
  out.affordances.assign(handle.affordances.begin(), handle.affordances.end());
  out.arc = handle.arc;
  out.residual = handle.residual;
  out.observed_free = handle.observed_free;
  out.normal_error = handle.normal_error;
}

/// @param extent  m; along the axis: Options::finger_width, the length of a shell
template <class AffordanceMessage>
void to_message(const Affordance& affordance, double extent, AffordanceMessage& out) {
  const Vector3& n = affordance.normal;
  set_xyz(affordance.center, out.pose.position);
  set_quaternion(quaternion_of(affordance.axis, {-n[0], -n[1], -n[2]}), out.pose.orientation);
  set_xyz(affordance.axis, out.axis);
  set_xyz(affordance.normal, out.normal);
  out.radius = affordance.radius;
  out.extent = extent;
  out.shell_radius = affordance.shell_radius;
  out.gap = affordance.gap;
  out.curvature = affordance.curvature;
  out.observed_free = affordance.observed_free;
  out.quality = affordance.quality;
  out.neighbourhood = affordance.neighbourhood;
  out.sample = affordance.sample;
}

/// Everything but the header.
template <class HandleList>
void handle_list(const Result& result, HandleList& out) {
  out.status = std::string(to_string(result.status));
  out.points = result.points;
  out.finite_points = result.finite_points;
  out.handles.resize(result.handles.size());
  for (std::size_t i = 0; i < result.handles.size(); ++i) to_message(result.handles[i], out.handles[i]);
}

template <class AffordanceList>
void affordance_list(const Result& result, double extent, AffordanceList& out) {
  out.affordances.resize(result.affordances.size());
  for (std::size_t i = 0; i < result.affordances.size(); ++i) {
    to_message(result.affordances[i], extent, out.affordances[i]);
  }
}

template <class TrackList>
void track_list(const std::vector<Track>& tracks, TrackList& out) {
  out.tracks.resize(tracks.size());
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    out.tracks[i].id = tracks[i].id;
    out.tracks[i].age = static_cast<std::uint32_t>(tracks[i].age);
    out.tracks[i].unseen = static_cast<std::uint32_t>(tracks[i].unseen);
    set_xyz(tracks[i].velocity, out.tracks[i].velocity);
    to_message(tracks[i].handle, out.tracks[i].handle);
  }
}

/// The reverse of to_message().
template <class HandleMessage>
Handle from_message(const HandleMessage& message) {
  const auto vector = [](const auto& v) { return Vector3{v.x, v.y, v.z}; };
  Handle handle;
  handle.center = vector(message.pose.position);
  handle.axis = vector(message.axis);
  handle.approach = vector(message.approach);
  handle.radius = message.radius;
  handle.length = message.length;
  handle.confidence = message.confidence;
  for (const auto& point : message.path) handle.path.push_back(vector(point));
  handle.affordances.assign(message.affordances.begin(), message.affordances.end());
  handle.arc = message.arc;
  handle.residual = message.residual;
  handle.observed_free = message.observed_free;
  handle.normal_error = message.normal_error;
  return handle;
}

}  // namespace handhold::ros_bridge
