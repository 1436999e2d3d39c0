// Results as a visualization_msgs/MarkerArray. A template, as result_messages.h.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

#include "handhold/result.h"
#include "motion.h"
#include "result_messages.h"

namespace handhold::ros_bridge {

template <class MarkerArray>
class MarkerWriter {
  using Marker = typename decltype(MarkerArray::markers)::value_type;

 public:
  /// Fills the array: first what deletes all markers of the array before (whatever a viewer has missed), then for each
  /// handle its cylinder or, curved, its path (namespace "handles"), an arrow for the hand's way to it ("approach") and
  /// its confidence and radius ("labels"), and all affordances as lines along their axes ("affordances").
  /// @param extent  m; length of an affordance's line
  template <class Header>
  static void write(const Header& header, const Result& result, double extent, MarkerArray& out) {
    out.markers.clear();
    Marker& first = add(header, "", 0, Marker::CUBE, out);
    first.action = Marker::DELETEALL;
    for (std::size_t i = 0; i < result.handles.size(); ++i) {
      const int id = static_cast<int>(i);
      add_part(result.handles[i], add(header, "handles", id, Marker::CYLINDER, out));
      add_approach(result.handles[i], add(header, "approach", id, Marker::ARROW, out));
      add_label(result.handles[i], add(header, "labels", id, Marker::TEXT_VIEW_FACING, out));
    }
    if (!result.affordances.empty()) {
      Marker& lines = add(header, "affordances", 0, Marker::LINE_LIST, out);
      lines.scale.x = 0.001;
      color(0.2, 0.6, 1, 0.8, lines);
      for (const Affordance& affordance : result.affordances) {
        for (const double side : {-0.5, 0.5})
          add_point(along(affordance.center, affordance.axis, side * extent), lines);
      }
    }
  }

 private:
  static Vector3 along(const Vector3& p, const Vector3& direction, double length) {
    return {p[0] + length * direction[0], p[1] + length * direction[1], p[2] + length * direction[2]};
  }
  template <class Header>
  static Marker& add(const Header& header, const char* name, int id, int type, MarkerArray& out) {
    out.markers.emplace_back();
    Marker& marker = out.markers.back();
    marker.header = header;
    marker.ns = name;
    marker.id = id;
    marker.type = type;
    marker.action = Marker::ADD;
    marker.pose.orientation.w = 1;
    return marker;
  }
  static void color(double r, double g, double b, double a, Marker& marker) {
    marker.color.r = static_cast<float>(r);
    marker.color.g = static_cast<float>(g);
    marker.color.b = static_cast<float>(b);
    marker.color.a = static_cast<float>(a);
  }
  static void add_point(const Vector3& p, Marker& marker) {
    marker.points.emplace_back();
    set_xyz(p, marker.points.back());
  }
  /// From yellow to green, the surer the greener.
  static void add_part(const Handle& handle, Marker& marker) {
    color(1 - handle.confidence, 0.8, 0.1, 0.7, marker);
    if (handle.path.size() > 1) {
      marker.type = Marker::LINE_STRIP;
      marker.scale.x = 2 * handle.radius;
      for (const Vector3& p : handle.path) add_point(p, marker);
      return;
    }
    set_xyz(handle.center, marker.pose.position);
    set_quaternion(quaternion_of(handle.axis, handle.approach), marker.pose.orientation);
    marker.scale.x = marker.scale.y = 2 * handle.radius;
    marker.scale.z = handle.length;
  }
  static void add_approach(const Handle& handle, Marker& marker) {
    constexpr double kLength = 0.08;
    add_point(along(handle.center, handle.approach, -handle.radius - kLength), marker);
    add_point(along(handle.center, handle.approach, -handle.radius), marker);
    marker.scale.x = 0.004;  // shaft
    marker.scale.y = 0.01;   // head
    color(0.9, 0.3, 0.2, 0.9, marker);
  }
  static void add_label(const Handle& handle, Marker& marker) {
    set_xyz(along(handle.center, handle.approach, -handle.radius - 0.1), marker.pose.position);
    marker.scale.z = 0.02;
    color(1, 1, 1, 1, marker);
    char text[64];
    std::snprintf(text, sizeof text, "%.2f  r %.0f mm", handle.confidence, 1000 * handle.radius);
    marker.text = text;
  }
};

}  // namespace handhold::ros_bridge
