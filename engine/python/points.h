// A cloud from a NumPy array: where it lies if its layout allows, otherwise copied.
#pragma once

#include <pybind11/pybind11.h>

#include <vector>

#include "handhold/cloud.h"

namespace handhold::python {

/// An array of points that Python owns, (N, 3) or (H, W, 3). Made with the GIL held, which view() does not need.
class Points {
 public:
  /// @param points  an array, or what numpy.asarray makes one of
  /// @param viewpoint  three numbers or None
  /// @throws std::invalid_argument for another shape or kind of number, a masked array, too many points
  Points(const pybind11::object& points, const pybind11::object& viewpoint);

  /// Whether view() has to copy.
  bool copies() const { return copies_; }
  /// @param buffer  holds the copy; its memory is used again
  CloudView view(std::vector<float>& buffer) const;

 private:
  template <class T>
  void copy(float* out) const;

  pybind11::object array_;  // keeps the memory
  const char* data_ = nullptr;
  std::ptrdiff_t row_step_ = 0, point_step_ = 0, coordinate_step_ = 4;  // bytes
  std::size_t height_ = 1, width_ = 0;
  bool is_double_ = false, swapped_ = false, copies_ = false;
  std::optional<Vector3> viewpoint_;
};

}  // namespace handhold::python
