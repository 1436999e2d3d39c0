#include "points.h"

#include <pybind11/numpy.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include "numpy_views.h"

namespace handhold::python {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::invalid_argument("points: " + what);
}

std::string shape_of(const py::array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

/// Why an array's numbers cannot be coordinates; empty: they can.
std::string wrong_kind(const py::array& array) {
  const py::dtype dtype = array.dtype();
  const py::ssize_t size = dtype.itemsize();
  if (dtype.kind() == 'f' && (size == 4 || size == 8)) return {};
  std::string text = "dtype " + py::str(static_cast<py::object>(dtype)).cast<std::string>() +
                     ": must be float32 or float64, in metres";
  if (dtype.kind() == 'i' || dtype.kind() == 'u') text += " (of whole millimetres: points * 0.001)";
  if (dtype.has_fields())
    text += " (of named fields: structured_to_unstructured(points[['x', 'y', 'z']]), from numpy.lib.recfunctions)";
  return text;
}

}  // namespace

Points::Points(const py::object& points, const py::object& viewpoint) {
  const py::module_ numpy = py::module_::import("numpy");
  if (py::isinstance(points, numpy.attr("ma").attr("MaskedArray"))) {
    fail("a masked array: must be a plain one, NaN where nothing was measured (points.filled(numpy.nan))");
  }
  const py::array array = numpy.attr("asarray")(points);
  array_ = array;
  const py::ssize_t ndim = array.ndim();
  if (const std::string wrong = wrong_kind(array); !wrong.empty()) fail(wrong);
  if ((ndim != 2 && ndim != 3) || array.shape(ndim - 1) != 3) {
    std::string text = "shape " + shape_of(array) + ": must be (N, 3), or (H, W, 3) for an image";
    if ((ndim == 2 || ndim == 3) && array.shape(ndim - 1) > 3) text += " (of x, y, z and more: points[..., :3])";
    fail(text);
  }
  height_ = ndim == 3 ? static_cast<std::size_t>(array.shape(0)) : 1;
  width_ = static_cast<std::size_t>(array.shape(ndim - 2));
  if (height_ == 0 || width_ == 0) {
    height_ = 1, width_ = 0;
  } else if (height_ > ((std::size_t{1} << 31) - 1) / width_) {
    fail("shape " + shape_of(array) + ": must be fewer than 2^31 points");
  }
  row_step_ = ndim == 3 ? array.strides(0) : 0;
  point_step_ = array.strides(ndim - 2);
  coordinate_step_ = array.strides(ndim - 1);
  data_ = static_cast<const char*>(array.data());
  is_double_ = array.dtype().itemsize() == 8;
  const bool native = array.dtype().attr("isnative").cast<bool>();
  swapped_ = !native;
  // A stride over one element means nothing: let it fit.
  if (width_ == 1 && height_ > 1) point_step_ = row_step_;
  if (width_ * height_ <= 1) point_step_ = 12;
  if (height_ == 1 || width_ == 1) row_step_ = point_step_ * static_cast<std::ptrdiff_t>(width_);

  const bool in_place = !is_double_ && native && coordinate_step_ == 4 && point_step_ >= 12 && point_step_ % 4 == 0 &&
                        row_step_ == point_step_ * static_cast<std::ptrdiff_t>(width_) &&
                        reinterpret_cast<std::uintptr_t>(data_) % alignof(float) == 0;
  copies_ = width_ > 0 && !in_place;
  if (!viewpoint.is_none()) viewpoint_ = to_vector3("viewpoint", viewpoint);
}

/// Any strides, any alignment, either byte order.
template <class T>
void Points::copy(float* out) const {
  for (std::size_t row = 0; row < height_; ++row) {
    const char* point = data_ + static_cast<std::ptrdiff_t>(row) * row_step_;
    for (std::size_t column = 0; column < width_; ++column, point += point_step_) {
      for (int k = 0; k < 3; ++k) {
        char bytes[sizeof(T)];
        std::memcpy(bytes, point + k * coordinate_step_, sizeof bytes);
        if (swapped_) std::reverse(bytes, bytes + sizeof bytes);
        T value;
        std::memcpy(&value, bytes, sizeof value);
        *out++ = static_cast<float>(value);
      }
    }
  }
}

CloudView Points::view(std::vector<float>& buffer) const {
  CloudView cloud;
  cloud.width = static_cast<std::uint32_t>(width_);
  cloud.height = static_cast<std::uint32_t>(height_);
  cloud.viewpoint = viewpoint_;
  if (!copies_) {
    cloud.data = reinterpret_cast<const float*>(data_);
    if (width_ > 0) cloud.point_step = static_cast<std::size_t>(point_step_);
    return cloud;
  }
  buffer.resize(3 * width_ * height_);
  is_double_ ? copy<double>(buffer.data()) : copy<float>(buffer.data());
  cloud.data = buffer.data();
  return cloud;
}

}  // namespace handhold::python
