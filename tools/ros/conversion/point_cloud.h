// From the bytes of a PointCloud2 to the library's view of a cloud. Knows no ROS: the message of ROS 1 and that of ROS
// 2 have the same fields, and both fit point_cloud_view().
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/tracker.h"

namespace handhold::ros_bridge {

/// A message that contradicts itself or lacks what is needed. what() is one line: what is wrong, what would be right.
class MessageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A field of a point, as sensor_msgs/PointField has it.
struct PointFieldView {
  static constexpr std::uint8_t kFloat32 = 7, kFloat64 = 8;

  std::string_view name;
  std::uint32_t offset = 0;  ///< bytes from the point's first one
  std::uint8_t datatype = 0;
  std::uint32_t count = 1;  ///< old publishers write 0 for 1
};

/// A sensor_msgs/PointCloud2 in its owner's memory.
struct PointCloudMessage {
  std::uint32_t width = 0, height = 0;
  std::vector<PointFieldView> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0, row_step = 0;  ///< bytes
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;  ///< bytes of data
};

/// `view` looks into `message` afterwards; its memory is reused.
template <class PointCloud2>
void point_cloud_view(const PointCloud2& message, PointCloudMessage& view) {
  view.width = message.width;
  view.height = message.height;
  view.fields.clear();
  for (const auto& field : message.fields) {
    view.fields.push_back({field.name, field.offset, field.datatype, field.count});
  }
  view.is_bigendian = message.is_bigendian;
  view.point_step = message.point_step;
  view.row_step = message.row_step;
  view.data = message.data.data();
  view.size = message.data.size();
}

/// Reads clouds out of messages; its memory is reused from one to the next.
class PointCloudReader {
 public:
  /// The cloud of a message, in metres as they stand there. Three floats in a row, in the byte order of this machine
  /// and without gaps between rows, are seen where they lie; every other layout is copied into memory of the reader.
  /// Either must live as long as the view is used. Values beyond the range of float count as not measured. `is_dense`
  /// is not asked for: what is not finite is not measured, whatever it says.
  /// @param T_target_cloud  not null: the cloud is brought into that frame, by a copy. The viewpoint is left to the
  ///                        caller.
  /// @throws MessageError
  CloudView read(const PointCloudMessage& message, const Motion* T_target_cloud = nullptr);

 private:
  std::vector<float> xyz_;
};

}  // namespace handhold::ros_bridge
