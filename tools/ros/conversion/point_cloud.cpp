#include "point_cloud.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>

namespace handhold::ros_bridge {
namespace {

struct Coordinate {
  std::size_t offset = 0;  ///< bytes
  bool is_double = false;
};
using Coordinates = std::array<Coordinate, 3>;

constexpr bool kHostIsBigEndian = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

std::string names_of(const PointCloudMessage& message) {
  std::string names;
  for (const PointFieldView& field : message.fields) names.append(names.empty() ? "" : ", ").append(field.name);
  return names.empty() ? "it has none" : "it has: " + names;
}

Coordinate find(const PointCloudMessage& message, std::string_view name) {
  const auto is_it = [&](const PointFieldView& field) { return field.name == name; };
  const auto field = std::find_if(message.fields.begin(), message.fields.end(), is_it);
  const std::string quoted = "field '" + std::string(name) + "'";
  if (field == message.fields.end()) {
    throw MessageError("there is no " + quoted + "; a cloud needs x, y and z, and " + names_of(message));
  }
  if (std::any_of(field + 1, message.fields.end(), is_it)) throw MessageError(quoted + " is there twice");
  if (field->datatype != PointFieldView::kFloat32 && field->datatype != PointFieldView::kFloat64) {
    throw MessageError(quoted + " has datatype " + std::to_string(field->datatype) +
                       "; must be 7 (FLOAT32) or 8 (FLOAT64), in metres");
  }
  if (field->count > 1) {
    throw MessageError(quoted + " has count " + std::to_string(field->count) + "; must be 1");
  }
  const bool is_double = field->datatype == PointFieldView::kFloat64;
  if (std::uint64_t{field->offset} + (is_double ? 8 : 4) > message.point_step) {
    throw MessageError(quoted + " ends " + std::to_string(std::uint64_t{field->offset} + (is_double ? 8 : 4)) +
                       " bytes into a point of point_step = " + std::to_string(message.point_step) + " bytes");
  }
  return {field->offset, is_double};
}

/// 64 bits hold every product of two of the message's numbers, and here every sum: a row is no longer than row_step.
void check_sizes(const PointCloudMessage& message) {
  const std::uint64_t row = std::uint64_t{message.width} * message.point_step;
  if (message.height > 1 && message.row_step < row) {
    throw MessageError("row_step = " + std::to_string(message.row_step) +
                       " is less than width * point_step = " + std::to_string(row));
  }
  // The last row may end with its last point.
  const std::uint64_t needed = row + (message.height - std::uint64_t{1}) * (message.height > 1 ? message.row_step : 0);
  if (needed > message.size) {
    throw MessageError("data has " + std::to_string(message.size) + " bytes; " + std::to_string(message.width) + " x " +
                       std::to_string(message.height) + " points of point_step = " +
                       std::to_string(message.point_step) + " need " + std::to_string(needed));
  }
}

bool lies_as_needed(const PointCloudMessage& message, const Coordinates& xyz) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (xyz[i].is_double || xyz[i].offset != xyz[0].offset + 4 * i) return false;
  }
  return message.is_bigendian == kHostIsBigEndian && message.point_step % 4 == 0 &&
         (message.height == 1 || message.row_step == std::uint64_t{message.width} * message.point_step) &&
         reinterpret_cast<std::uintptr_t>(message.data + xyz[0].offset) % 4 == 0;
}

template <class Number, class Bits, bool swap>
float number_at(const std::uint8_t* bytes) {
  Bits bits;
  std::memcpy(&bits, bytes, sizeof bits);
  if constexpr (swap && sizeof bits == 4) bits = __builtin_bswap32(bits);
  if constexpr (swap && sizeof bits == 8) bits = __builtin_bswap64(bits);
  Number number;
  std::memcpy(&number, &bits, sizeof number);
  if constexpr (sizeof number == 8) {
    // Out of the range of float a conversion is undefined.
    constexpr double kLargest = std::numeric_limits<float>::max();
    if (!(number >= -kLargest && number <= kLargest)) return std::numeric_limits<float>::quiet_NaN();
  }
  return static_cast<float>(number);
}

template <bool swap>
float number_at(const std::uint8_t* point, const Coordinate& c) {
  return c.is_double ? number_at<double, std::uint64_t, swap>(point + c.offset)
                     : number_at<float, std::uint32_t, swap>(point + c.offset);
}

template <bool swap>
void copy(const PointCloudMessage& message, const Coordinates& xyz, float* out) {
  for (std::uint32_t v = 0; v < message.height; ++v) {
    const std::uint8_t* point = message.data + std::size_t{v} * message.row_step;
    for (std::uint32_t u = 0; u < message.width; ++u, point += message.point_step, out += 3) {
      for (std::size_t i = 0; i < 3; ++i) out[i] = number_at<swap>(point, xyz[i]);
    }
  }
}

/// In double: frames may lie far from each other.
void move(const CloudView& cloud, const Motion& T, float* out) {
  const std::array<double, 9>& R = T.R;
  const std::size_t size = cloud.size();
  for (std::size_t i = 0; i < size; ++i, out += 3) {
    const float* p = cloud.point(i);
    const double x = p[0], y = p[1], z = p[2];
    out[0] = static_cast<float>(R[0] * x + R[1] * y + R[2] * z + T.t[0]);
    out[1] = static_cast<float>(R[3] * x + R[4] * y + R[5] * z + T.t[1]);
    out[2] = static_cast<float>(R[6] * x + R[7] * y + R[8] * z + T.t[2]);
  }
}

}  // namespace

CloudView PointCloudReader::read(const PointCloudMessage& message, const Motion* T_target_cloud) {
  if (message.width == 0 || message.height == 0) return {};
  if (message.point_step == 0) throw MessageError("point_step = 0; must be the bytes from one point to the next");
  const Coordinates xyz = {find(message, "x"), find(message, "y"), find(message, "z")};
  check_sizes(message);

  CloudView view;
  view.width = message.width;
  view.height = message.height;
  if (lies_as_needed(message, xyz)) {
    view.data = reinterpret_cast<const float*>(message.data + xyz[0].offset);
    view.point_step = message.point_step;
    if (!T_target_cloud) return view;
    xyz_.resize(3 * view.size());
  } else {
    xyz_.resize(3 * view.size());
    message.is_bigendian == kHostIsBigEndian ? copy<false>(message, xyz, xyz_.data())
                                             : copy<true>(message, xyz, xyz_.data());
    view.data = xyz_.data();
    view.point_step = 12;
  }
  if (T_target_cloud) {
    move(view, *T_target_cloud, xyz_.data());  // point by point: also in place
    view.data = xyz_.data();
    view.point_step = 12;
  }
  return view;
}

}  // namespace handhold::ros_bridge
