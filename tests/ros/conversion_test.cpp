// The node's conversions without a roscore: clouds in every layout, messages that contradict themselves, results as
// messages.
#include <gtest/gtest.h>
#include <handhold_ros/AffordanceList.h>
#include <handhold_ros/HandleList.h>
#include <handhold_ros/TrackList.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "frame_search.h"
#include "frame_statistics.h"
#include "mailbox.h"
#include "markers.h"
#include "motion.h"
#include "point_cloud.h"
#include "result_messages.h"

namespace handhold::ros_bridge {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Has the fields of a sensor_msgs/PointCloud2, of ROS 1 and of ROS 2.
struct Field {
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = 7;
  std::uint32_t count = 1;
};
struct Message {
  std::uint32_t height = 1, width = 0;
  std::vector<Field> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0, row_step = 0;
  std::vector<std::uint8_t> data;
  bool is_dense = false;
};

struct Layout {
  bool doubles = false, big = false;
  std::uint32_t width = 3, height = 2;
  std::uint32_t before = 0, between = 0, after = 0;  ///< bytes of a point beside its coordinates
  std::uint32_t row_padding = 0;
  bool backwards = false;  ///< z first
  bool short_last_row = false;
};

template <class T>
void put(T value, bool big, std::uint8_t* at) {
  std::memcpy(at, &value, sizeof value);
  if (big) std::reverse(at, at + sizeof value);
}

/// Coordinate i of point n.
float coordinate(std::uint32_t n, std::uint32_t i) {
  return n == 1 ? kNan : 0.25f * static_cast<float>(n) + 0.001f * static_cast<float>(i);
}

Message message_of(const Layout& layout) {
  Message m;
  m.width = layout.width;
  m.height = layout.height;
  m.is_bigendian = layout.big;
  const std::uint32_t size = layout.doubles ? 8 : 4;
  m.point_step = layout.before + 3 * size + 2 * layout.between + layout.after;
  m.row_step = m.point_step * m.width + layout.row_padding;
  m.fields.push_back({"intensity", 0, 2, 1});
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t i = layout.backwards ? 2 - k : k;
    m.fields.push_back({std::string(1, static_cast<char>('x' + i)), layout.before + k * (size + layout.between),
                        static_cast<std::uint8_t>(layout.doubles ? 8 : 7), 1});
  }
  m.data.assign(std::size_t{m.row_step} * m.height, 0xee);
  for (std::uint32_t v = 0; v < m.height; ++v) {
    for (std::uint32_t u = 0; u < m.width; ++u) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        std::uint8_t* at = m.data.data() + v * m.row_step + u * m.point_step + m.fields[k + 1].offset;
        const float value = coordinate(v * m.width + u, layout.backwards ? 2 - k : k);
        layout.doubles ? put(static_cast<double>(value), layout.big, at) : put(value, layout.big, at);
      }
    }
  }
  if (layout.short_last_row) m.data.resize(m.data.size() - layout.row_padding);
  return m;
}

CloudView read(PointCloudReader& reader, const Message& message, const Motion* T = nullptr) {
  PointCloudMessage view;
  point_cloud_view(message, view);
  return reader.read(view, T);
}

void expect_coordinates(const CloudView& cloud, const Layout& layout) {
  ASSERT_EQ(cloud.width, layout.width);
  ASSERT_EQ(cloud.height, layout.height);
  for (std::uint32_t n = 0; n < cloud.size(); ++n) {
    for (std::uint32_t i = 0; i < 3; ++i) {
      const float value = cloud.point(n)[i];
      if (n == 1) {
        EXPECT_TRUE(std::isnan(value));
      } else {
        EXPECT_EQ(value, coordinate(n, i)) << n << ' ' << i;
      }
    }
  }
}

TEST(PointCloudReader, ReadsEveryLayout) {
  PointCloudReader reader;  // one for all: nothing of a layout stays
  int count = 0;
  for (const bool doubles : {false, true}) {
    for (const bool big : {false, true}) {
      for (const bool backwards : {false, true}) {
        for (const std::uint32_t before : {0u, 1u, 4u}) {
          for (const std::uint32_t between : {0u, 2u, 4u}) {
            for (const std::uint32_t row_padding : {0u, 5u}) {
              for (const auto& [width, height] : {std::pair(3u, 2u), std::pair(6u, 1u), std::pair(1u, 6u)}) {
                for (const bool short_last_row : {false, true}) {
                  const Layout layout = {doubles, big,         width,       height,    before,
                                         between, before + 4u, row_padding, backwards, short_last_row};
                  const Message message = message_of(layout);
                  expect_coordinates(read(reader, message), layout);
                  ++count;
                }
              }
            }
          }
        }
      }
    }
  }
  EXPECT_EQ(count, 2 * 2 * 2 * 3 * 3 * 2 * 3 * 2);
}

TEST(PointCloudReader, CopiesNothingWhereTheLayoutAllows) {
  PointCloudReader reader;
  for (const std::uint32_t before : {0u, 4u}) {
    Layout layout;
    layout.before = before;
    layout.after = 4;
    const Message message = message_of(layout);
    const CloudView cloud = read(reader, message);
    EXPECT_EQ(reinterpret_cast<const std::uint8_t*>(cloud.data), message.data.data() + before);
    EXPECT_EQ(cloud.point_step, message.point_step);
  }
  Layout unaligned;
  unaligned.before = 1;
  const Message message = message_of(unaligned);
  const auto* data = reinterpret_cast<const std::uint8_t*>(read(reader, message).data);
  EXPECT_FALSE(data >= message.data.data() && data < message.data.data() + message.data.size());
}

TEST(PointCloudReader, TakesIsDenseAndAnOldCountAsTheyCome) {
  Layout layout;
  Message message = message_of(layout);
  message.is_dense = true;  // with a NaN in it
  for (Field& field : message.fields) field.count = 0;
  PointCloudReader reader;
  expect_coordinates(read(reader, message), layout);
}

TEST(PointCloudReader, TakesRowStepOfOneRowAsItComes) {
  Layout layout;
  layout.width = 6;
  layout.height = 1;
  for (const std::uint32_t row_step : {0u, 1u, 4'000'000'000u}) {
    Message message = message_of(layout);
    message.row_step = row_step;
    PointCloudReader reader;
    expect_coordinates(read(reader, message), layout);
  }
}

TEST(PointCloudReader, EmptyIsEmptyWhateverElseIsThere) {
  PointCloudReader reader;
  for (const auto& [width, height] : {std::pair(0u, 0u), std::pair(0u, 5u), std::pair(5u, 0u)}) {
    Message message;
    message.width = width;
    message.height = height;
    EXPECT_EQ(read(reader, message).size(), 0u);
  }
}

TEST(PointCloudReader, DoublesBeyondFloatAreNotMeasured) {
  Layout layout;
  layout.doubles = true;
  Message message = message_of(layout);
  put(1e300, false, message.data.data());
  put(-std::numeric_limits<double>::infinity(), false, message.data.data() + 8);
  PointCloudReader reader;
  const CloudView cloud = read(reader, message);
  EXPECT_TRUE(std::isnan(cloud.point(0)[0]));
  EXPECT_TRUE(std::isnan(cloud.point(0)[1]));
  EXPECT_EQ(cloud.point(0)[2], coordinate(0, 2));
}

TEST(PointCloudReader, RefusesWhatContradictsItself) {
  const auto refused = [](auto&& spoil) {
    Message message = message_of({});
    spoil(message);
    PointCloudReader reader;
    try {
      read(reader, message);
    } catch (const MessageError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_EQ(refused([](Message&) {}), "taken");
  EXPECT_EQ(refused([](Message& m) { m.point_step = 0; }),
            "point_step = 0; must be the bytes from one point to the next");
  EXPECT_EQ(refused([](Message& m) { m.fields.erase(m.fields.begin() + 2); }),
            "there is no field 'y'; a cloud needs x, y and z, and it has: intensity, x, z");
  EXPECT_EQ(refused([](Message& m) { m.fields.clear(); }),
            "there is no field 'x'; a cloud needs x, y and z, and it has none");
  EXPECT_EQ(refused([](Message& m) { m.fields.push_back({"z", 0, 7, 1}); }), "field 'z' is there twice");
  EXPECT_EQ(refused([](Message& m) { m.fields[1].datatype = 3; }),
            "field 'x' has datatype 3; must be 7 (FLOAT32) or 8 (FLOAT64), in metres");
  EXPECT_EQ(refused([](Message& m) { m.fields[1].datatype = 0; }),
            "field 'x' has datatype 0; must be 7 (FLOAT32) or 8 (FLOAT64), in metres");
  EXPECT_EQ(refused([](Message& m) { m.fields[3].count = 3; }), "field 'z' has count 3; must be 1");
  EXPECT_EQ(refused([](Message& m) { m.fields[3].offset = 9; }),
            "field 'z' ends 13 bytes into a point of point_step = 12 bytes");
  EXPECT_EQ(refused([](Message& m) { m.fields[3].offset = 0xffffffff; }),
            "field 'z' ends 4294967299 bytes into a point of point_step = 12 bytes");
  EXPECT_EQ(refused([](Message& m) { m.row_step = 35; }), "row_step = 35 is less than width * point_step = 36");
  EXPECT_EQ(refused([](Message& m) { m.data.pop_back(); }),
            "data has 71 bytes; 3 x 2 points of point_step = 12 need 72");
  EXPECT_EQ(refused([](Message& m) { m.data.clear(); }), "data has 0 bytes; 3 x 2 points of point_step = 12 need 72");
  EXPECT_EQ(refused([](Message& m) { m.height = 3; }), "data has 72 bytes; 3 x 3 points of point_step = 12 need 108");
  // Products that do not fit into 32 bits, and not into 64.
  EXPECT_EQ(refused([](Message& m) { m.width = 0xffffffff, m.height = 1; }),
            "data has 72 bytes; 4294967295 x 1 points of point_step = 12 need 51539607540");
  EXPECT_EQ(refused([](Message& m) { m.height = 0xffffffff, m.row_step = 0xffffffff; }),
            "data has 72 bytes; 3 x 4294967295 points of point_step = 12 need 18446744060824649766");
  EXPECT_EQ(refused([](Message& m) {
              m.width = 1, m.height = 0xffffffff, m.row_step = 0xffffffff, m.point_step = 0xffffffff;
            }),
            "data has 72 bytes; 1 x 4294967295 points of point_step = 4294967295 need 18446744065119617025");
  // After all of them a reader is as good as new: each has one of its own here, so once with the same.
  PointCloudReader reader;
  Message bad = message_of({});
  bad.data.pop_back();
  EXPECT_THROW(read(reader, bad), MessageError);
  expect_coordinates(read(reader, message_of({})), {});
}

// ---- Frames ---------------------------------------------------------------------------------------------------------

/// A rotation about an odd axis, and a shift.
Motion some_motion() {
  return motion({0.1, -0.5, 0.3, std::sqrt(1 - 0.35)}, {0.4, -2, 7});
}

void expect_near(const Vector3& a, const Vector3& b, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << i;
}

/// Where a quaternion turns a unit vector.
Vector3 turned(const Quaternion& q, const Vector3& v) {
  return rotated(motion(q, {}).R, v);
}

TEST(Motion, InverseAndProductAgree) {
  const Motion T = some_motion();
  const Vector3 p = {0.3, 0.2, -0.7};
  expect_near(moved(inverse(T), moved(T, p)), p, 1e-14);
  expect_near(moved(T * T, p), moved(T, moved(T, p)), 1e-14);
  expect_near(moved(inverse(T) * T, p), p, 1e-14);
}

TEST(Motion, QuaternionsGoThereAndBack) {
  // Half turns about each axis are the cases in which another component is the largest.
  for (const Quaternion& q : {Quaternion{0, 0, 0, 1}, Quaternion{1, 0, 0, 0}, Quaternion{0, 1, 0, 0},
                              Quaternion{0, 0, 1, 0}, Quaternion{0.1, -0.5, 0.3, std::sqrt(1 - 0.35)},
                              Quaternion{0.7, 0.1, -0.7, 0.1}, Quaternion{0.1, 0.7, 0.1, -0.7}}) {
    const Motion T = motion(q, {});
    const Motion again = motion(quaternion_of(T.R), {});
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(again.R[i], T.R[i], 1e-14);
  }
}

TEST(Motion, OrientationHasTheAxisAsZAndTheApproachAsX) {
  const Vector3 axis = {0.6, 0.8, 0}, approach = {0.8, -0.6, 0};
  const Quaternion q = quaternion_of(axis, {0.8 + 0.06, -0.6 + 0.08, 0});  // askew by a tenth of the axis
  expect_near(turned(q, {0, 0, 1}), axis, 1e-12);
  expect_near(turned(q, {1, 0, 0}), approach, 1e-12);
  // Along the axis, or none: any that is square to it.
  for (const Vector3& none : {axis, Vector3{0, 0, 0}}) {
    expect_near(turned(quaternion_of(axis, none), {0, 0, 1}), axis, 1e-12);
  }
  expect_near(turned(quaternion_of({1, 0, 0}, {1, 0, 0}), {0, 0, 1}), {1, 0, 0}, 1e-12);
}

TEST(Motion, MovesAResult) {
  Result result;
  result.handles.resize(1);
  Handle& handle = result.handles[0];
  handle.center = {1, 2, 3};
  handle.axis = {0, 1, 0};
  handle.approach = {0, 1, 0};
  handle.path = {{1, 0, 0}};
  result.affordances.resize(1);
  Affordance& affordance = result.affordances[0];
  affordance.center = {1, 2, 3};
  affordance.axis = {1, 0, 0};
  affordance.normal = {1, 0, 0};
  move(result, motion({0, 0, 1, 0}, {0, 0, 10}));  // half a turn about z
  expect_near(handle.center, {-1, -2, 13}, 1e-15);
  expect_near(handle.axis, {0, 1, 0}, 1e-15);  // has no sign: its largest component is positive
  expect_near(handle.approach, {0, -1, 0}, 1e-15);
  expect_near(handle.path[0], {-1, 0, 10}, 1e-15);
  expect_near(affordance.center, {-1, -2, 13}, 1e-15);
  expect_near(affordance.axis, {1, 0, 0}, 1e-15);
  expect_near(affordance.normal, {-1, 0, 0}, 1e-15);
}

TEST(PointCloudReader, BringsACloudIntoAnotherFrame) {
  const Motion T = some_motion();
  for (const bool doubles : {false, true}) {
    Layout layout;
    layout.doubles = doubles;
    const Message message = message_of(layout);
    const std::vector<std::uint8_t> before = message.data;
    PointCloudReader reader;
    const CloudView cloud = read(reader, message, &T);
    for (std::uint32_t n : {0u, 2u, 5u}) {
      const Vector3 p = moved(T, {coordinate(n, 0), coordinate(n, 1), coordinate(n, 2)});
      expect_near({cloud.point(n)[0], cloud.point(n)[1], cloud.point(n)[2]}, p, 1e-6);
    }
    EXPECT_TRUE(std::isnan(cloud.point(1)[0]));
    EXPECT_EQ(message.data, before);
  }
}

// ---- Search ---------------------------------------------------------------------------------------------------------

constexpr double kRadius = 0.02;
constexpr Vector3 kCenter = {0.05, 0, 0.7};

/// The half of a cylinder along y that a camera in the origin sees.
Message cylinder() {
  constexpr int kAround = 63;
  Message m;
  m.width = 151 * kAround;
  m.point_step = 12;
  m.row_step = 12 * m.width;
  m.fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}};
  m.data.resize(m.row_step);
  for (int i = 0; i < 151; ++i) {
    for (int j = 0; j < kAround; ++j) {
      const double angle = M_PI * j / (kAround - 1);
      const float p[3] = {static_cast<float>(kCenter[0] + kRadius * std::cos(angle)),
                          static_cast<float>(-0.075 + 0.001 * i),
                          static_cast<float>(kCenter[2] - kRadius * std::sin(angle))};
      std::memcpy(m.data.data() + 12 * (i * kAround + j), p, sizeof p);
    }
  }
  return m;
}

void search(FrameSearch& search, const Message& message, const FramePlace& place = {}) {
  PointCloudMessage view;
  point_cloud_view(message, view);
  search.take(view, place);
  search.search();
}

TEST(FrameSearch, FindsTheSameInAWorkspaceOfAnotherFrame) {
  Settings settings;
  settings.track = false;
  FrameSearch plain(settings);
  search(plain, cylinder());
  ASSERT_EQ(plain.result().handles.size(), 1u);
  const Handle& expected = plain.result().handles[0];
  expect_near(expected.center, kCenter, 0.002);

  FramePlace place;
  place.T_workspace_cloud = some_motion();
  const Vector3 there = moved(*place.T_workspace_cloud, kCenter);
  settings.options.workspace = {there[0] - 0.2, there[0] + 0.2, there[1] - 0.2,
                                there[1] + 0.2, there[2] - 0.2, there[2] + 0.2};
  FrameSearch moved_search(settings);
  search(moved_search, cylinder(), place);
  ASSERT_EQ(moved_search.result().handles.size(), 1u);
  const Handle& handle = moved_search.result().handles[0];
  expect_near(handle.center, kCenter, 0.002);
  EXPECT_NEAR(handle.radius, kRadius, 0.001);
  EXPECT_GT(handle.axis[1], 0.99);  // its largest component is positive in the cloud's frame
  expect_near(handle.approach, expected.approach, 0.2);
  for (const Affordance& a : moved_search.result().affordances) EXPECT_NEAR(a.center[2], kCenter[2], 0.01);

  settings.options.workspace = {there[0] + 1, there[0] + 2, there[1], there[1] + 1, there[2], there[2] + 1};
  FrameSearch elsewhere(settings);
  search(elsewhere, cylinder(), place);
  EXPECT_EQ(elsewhere.result().handles.size(), 0u);
}

TEST(FrameSearch, TellsTheSensorsPlaceInTheWorkspacesFrame) {
  // From behind, nothing of the cylinder's seen half bulges towards the sensor.
  Settings settings;
  settings.track = false;
  FramePlace place;
  place.viewpoint = Vector3{0.05, 0, 1.4};
  FrameSearch plain(settings);
  search(plain, cylinder(), place);
  EXPECT_EQ(plain.result().handles.size(), 0u);
  place.T_workspace_cloud = some_motion();
  FrameSearch moved_search(settings);
  search(moved_search, cylinder(), place);
  EXPECT_EQ(moved_search.result().handles.size(), 0u);
}

TEST(FrameSearch, FollowsAHandle) {
  FrameSearch frames{Settings()};
  for (int age = 1; age <= 3; ++age) {
    search(frames, cylinder());
    ASSERT_EQ(frames.tracks().size(), 1u);
    EXPECT_EQ(frames.tracks()[0].age, age);
  }
  // The camera has moved to the side: told so, the tracker expects the handle elsewhere and does not find it there.
  FramePlace place;
  place.T_now_last.t = {0.3, 0, 0};
  search(frames, cylinder(), place);
  ASSERT_EQ(frames.tracks().size(), 2u);
  EXPECT_EQ(frames.tracks()[0].unseen, 1);
  expect_near(frames.tracks()[0].handle.center, {kCenter[0] + 0.3, kCenter[1], kCenter[2]}, 0.01);
  frames.begin_anew();
  search(frames, cylinder());
  ASSERT_EQ(frames.tracks().size(), 1u);
  EXPECT_EQ(frames.tracks()[0].age, 1);
}

TEST(FrameSearch, GoesOnAfterABadMessage) {
  FrameSearch frames{Settings()};
  Message bad = cylinder();
  bad.data.resize(10);
  EXPECT_THROW(search(frames, bad), MessageError);
  search(frames, cylinder());
  EXPECT_EQ(frames.result().handles.size(), 1u);
  search(frames, Message());
  EXPECT_EQ(frames.result().status, Status::kEmpty);
}

// ---- Messages -------------------------------------------------------------------------------------------------------

Result some_result() {
  Result result;
  result.points = 10;
  result.finite_points = 9;
  for (int i = 0; i < 2; ++i) {
    Handle handle;
    handle.center = {1.0 + i, 2, 3};
    handle.axis = {0, 1, 0};
    handle.approach = {0, 0, 1};
    handle.radius = 0.01;
    handle.length = 0.1;
    handle.confidence = 0.9;
    handle.affordances = {0, 2};
    handle.arc = 2;
    handle.residual = 0.001;
    handle.observed_free = 0.7;
    handle.normal_error = 0.1;
    if (i == 1) handle.path = {{1, 0, 0}, {2, 2, 3}, {3, 0, 0}};
    result.handles.push_back(handle);
  }
  Affordance a;
  a.center = {1, 2, 3};
  a.axis = {1, 0, 0};
  a.normal = {0, 0, -1};
  a.radius = 0.01;
  a.shell_radius = 0.011;
  a.gap = 0.02;
  a.curvature = 100;
  a.observed_free = 0.6;
  a.quality = 0.8;
  a.neighbourhood = 0.015;
  a.sample = 77;
  result.affordances.assign(3, a);
  return result;
}

TEST(Messages, CarryHandlesThereAndBack) {
  const Result result = some_result();
  handhold_ros::HandleList list;
  list.handles.resize(5);  // of a cloud before
  handle_list(result, list);
  EXPECT_EQ(list.status, "ok");
  EXPECT_EQ(list.points, 10u);
  EXPECT_EQ(list.finite_points, 9u);
  ASSERT_EQ(list.handles.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const Handle handle = from_message(list.handles[i]);
    const Handle& expected = result.handles[i];
    EXPECT_EQ(handle.center, expected.center);
    EXPECT_EQ(handle.axis, expected.axis);
    EXPECT_EQ(handle.approach, expected.approach);
    EXPECT_EQ(handle.radius, expected.radius);
    EXPECT_EQ(handle.length, expected.length);
    EXPECT_EQ(handle.confidence, expected.confidence);
    EXPECT_EQ(handle.path, expected.path);
    EXPECT_EQ(handle.affordances, expected.affordances);
    EXPECT_EQ(handle.arc, expected.arc);
    EXPECT_EQ(handle.residual, expected.residual);
    EXPECT_EQ(handle.observed_free, expected.observed_free);
    EXPECT_EQ(handle.normal_error, expected.normal_error);
    const auto& q = list.handles[i].pose.orientation;
    expect_near(turned({q.x, q.y, q.z, q.w}, {0, 0, 1}), expected.axis, 1e-12);
    expect_near(turned({q.x, q.y, q.z, q.w}, {1, 0, 0}), expected.approach, 1e-12);
  }
}

TEST(Messages, CarryAffordances) {
  handhold_ros::AffordanceList list;
  affordance_list(some_result(), 0.02, list);
  ASSERT_EQ(list.affordances.size(), 3u);
  const handhold_ros::Affordance& a = list.affordances[2];
  EXPECT_EQ(a.pose.position.z, 3);
  expect_near(
      turned({a.pose.orientation.x, a.pose.orientation.y, a.pose.orientation.z, a.pose.orientation.w}, {1, 0, 0}),
      {0, 0, 1}, 1e-12);
  EXPECT_EQ(a.axis.x, 1);
  EXPECT_EQ(a.normal.z, -1);
  EXPECT_EQ(a.radius, 0.01);
  EXPECT_EQ(a.extent, 0.02);
  EXPECT_EQ(a.shell_radius, 0.011);
  EXPECT_EQ(a.gap, 0.02);
  EXPECT_EQ(a.curvature, 100);
  EXPECT_EQ(a.observed_free, 0.6);
  EXPECT_EQ(a.quality, 0.8);
  EXPECT_EQ(a.neighbourhood, 0.015);
  EXPECT_EQ(a.sample, 77u);
}

TEST(Messages, CarryTracks) {
  Track track;
  track.id = 5;
  track.age = 7;
  track.unseen = 2;
  track.velocity = {0.1, 0.2, 0.3};
  track.handle = some_result().handles[0];
  handhold_ros::TrackList list;
  track_list({track}, list);
  ASSERT_EQ(list.tracks.size(), 1u);
  EXPECT_EQ(list.tracks[0].id, 5u);
  EXPECT_EQ(list.tracks[0].age, 7u);
  EXPECT_EQ(list.tracks[0].unseen, 2u);
  EXPECT_EQ(list.tracks[0].velocity.y, 0.2);
  EXPECT_EQ(list.tracks[0].handle.radius, 0.01);
}

TEST(Markers, DeleteOldOnesAndDrawAll) {
  using visualization_msgs::Marker;
  std_msgs::Header header;
  header.frame_id = "lens";
  visualization_msgs::MarkerArray array;
  MarkerWriter<visualization_msgs::MarkerArray>::write(header, some_result(), 0.02, array);
  ASSERT_EQ(array.markers.size(), 1u + 2 * 3 + 1);
  for (const Marker& marker : array.markers) {
    EXPECT_EQ(marker.header.frame_id, "lens");
    const auto& q = marker.pose.orientation;
    EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, 1e-12);
    EXPECT_EQ(marker.action, &marker == &array.markers[0] ? int{Marker::DELETEALL} : int{Marker::ADD});
  }
  EXPECT_EQ(array.markers[1].type, Marker::CYLINDER);
  EXPECT_DOUBLE_EQ(array.markers[1].scale.x, 0.02);
  EXPECT_DOUBLE_EQ(array.markers[1].scale.z, 0.1);
  EXPECT_EQ(array.markers[3].text, "0.90  r 10 mm");
  EXPECT_EQ(array.markers[4].type, Marker::LINE_STRIP);
  EXPECT_EQ(array.markers[4].points.size(), 3u);
  EXPECT_EQ(array.markers[7].points.size(), 6u);
  EXPECT_NEAR(array.markers[7].points[1].x - array.markers[7].points[0].x, 0.02, 1e-15);

  MarkerWriter<visualization_msgs::MarkerArray>::write(header, Result(), 0.02, array);
  ASSERT_EQ(array.markers.size(), 1u);
  EXPECT_EQ(array.markers[0].action, Marker::DELETEALL);
}

// ---- Counts ---------------------------------------------------------------------------------------------------------

std::string value_of(const FrameStatistics::Summary& summary, const std::string& name) {
  for (const auto& [key, value] : summary.values) {
    if (key == name) return value;
  }
  return "missing";
}

TEST(FrameStatistics, CountsAndTakesPercentiles) {
  FrameStatistics statistics;
  EXPECT_EQ(statistics.summary().message, "no cloud searched yet");
  EXPECT_EQ(value_of(statistics.summary(), "search_ms_p50"), "");
  statistics.received("/a", 7, false);
  statistics.received("/a", 8, true);
  statistics.received("/a", 11, false);  // 9 and 10 were lost
  statistics.received("/b", 100, false);
  statistics.received("/a", 0, false);  // began anew
  statistics.received("/a", 0, false);  // writes no counts
  Result result = some_result();
  result.funnel.samples = 5000;
  result.funnel.no_gap = 12;
  for (int i = 0; i < 101; ++i) {
    FrameTimes times;
    times.search = i;
    times.total = 2 * i;
    statistics.searched(0.1 * i, times, result);
  }
  const FrameStatistics::Summary summary = statistics.summary();
  EXPECT_EQ(value_of(summary, "received"), "6");
  EXPECT_EQ(value_of(summary, "dropped"), "1");
  EXPECT_EQ(value_of(summary, "lost"), "2");
  EXPECT_EQ(value_of(summary, "searched"), "101");
  EXPECT_EQ(value_of(summary, "rate_hz"), "10.00");
  EXPECT_EQ(value_of(summary, "search_ms_p50"), "50.00");
  EXPECT_EQ(value_of(summary, "search_ms_p99"), "99.00");
  EXPECT_EQ(value_of(summary, "total_ms_p99"), "198.00");
  EXPECT_EQ(value_of(summary, "funnel.samples"), "5000");
  EXPECT_EQ(value_of(summary, "funnel.no_gap"), "12");
  EXPECT_EQ(value_of(summary, "handles"), "2");
  EXPECT_EQ(summary.message, "ok, 2 handles");
  EXPECT_FALSE(summary.skipping);

  statistics.skipped("no such frame");
  EXPECT_TRUE(statistics.summary().skipping);
  EXPECT_EQ(statistics.summary().message, "no such frame");
  EXPECT_EQ(value_of(statistics.summary(), "skipped"), "1");
  result.status = Status::kEmpty;
  statistics.searched(20, {}, result);
  EXPECT_FALSE(statistics.summary().skipping);
  EXPECT_TRUE(statistics.summary().not_searched);
}

TEST(Mailbox, KeepsTheNewest) {
  Mailbox<int> mailbox;
  EXPECT_FALSE(mailbox.put(1));
  EXPECT_TRUE(mailbox.put(2));
  EXPECT_TRUE(mailbox.put(3));
  EXPECT_EQ(mailbox.take(), 3);
  EXPECT_FALSE(mailbox.put(4));
  mailbox.close();
  EXPECT_EQ(mailbox.take(), std::nullopt);
}

TEST(Mailbox, EndsAWait) {
  Mailbox<int> mailbox;
  std::thread waiting([&] { EXPECT_EQ(mailbox.take(), std::nullopt); });
  mailbox.close();
  waiting.join();
}

}  // namespace
}  // namespace handhold::ros_bridge
