// NumPy arrays of the library's memory, and numbers and poses from Python.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "handhold/cloud.h"

namespace handhold::python {

namespace py = pybind11;

/// What keeps the memory that a view shows.
using Owner = std::shared_ptr<const void>;

/// A read-only array of memory that `owner` keeps: no copy. NumPy cannot be asked to make it writable.
template <class T>
py::array view(const Owner& owner, const T* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides) {
  const py::capsule base(new Owner(owner), [](void* o) { delete static_cast<Owner*>(o); });
  py::array array(py::dtype::of<T>(), std::move(shape), std::move(strides), data, base);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

inline py::array view(const Owner& owner, const Vector3& v) {
  return view(owner, v.data(), {3}, {sizeof(double)});
}
inline py::array view(const Owner& owner, const std::vector<Vector3>& v) {
  return view(owner, v.empty() ? nullptr : v[0].data(), {static_cast<py::ssize_t>(v.size()), 3},
              {sizeof(Vector3), sizeof(double)});
}
template <class T>
py::array view(const Owner& owner, const std::vector<T>& v) {
  return view(owner, v.data(), {static_cast<py::ssize_t>(v.size())}, {sizeof(T)});
}

/// A value as Python writes it, in ASCII and on one line, for messages.
std::string written(py::handle value);

/// A finite or infinite number. @throws std::invalid_argument "NAME = VALUE: must be a number"
double to_number(const char* name, py::handle value);
/// Three numbers. @throws std::invalid_argument
Vector3 to_vector3(const char* name, py::handle value);

/// A rigid motion as Python has it, a 4x4 matrix.
struct Rigid {
  std::array<double, 9> R = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major rotation
  Vector3 t = {0, 0, 0};                                  ///< m
};
/// @throws std::invalid_argument for what is no rotation (to 1e-3) and translation
Rigid to_rigid(const char* name, const py::object& matrix);

/// (N, 3) numbers. @throws std::invalid_argument
std::vector<Vector3> to_vectors3(const char* name, const py::object& array);

/// Makes Python's exceptions of the library's: ValueError, with the library's text.
void translate_errors();

}  // namespace handhold::python
