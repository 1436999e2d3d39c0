// handhold._io: clouds from files. The only part of the package that needs PCL.
#include "handhold/io.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "numpy_views.h"

namespace handhold::python {
namespace {

/// A new array that owns the values: Python may change them.
template <class T>
py::array array_of(std::vector<T>&& values, const Cloud& cloud) {
  auto* owned = new std::vector<T>(std::move(values));
  const py::capsule owner(owned, [](void* v) { delete static_cast<std::vector<T>*>(v); });
  std::vector<py::ssize_t> shape = {cloud.width, 3};
  if (cloud.height > 1) shape.insert(shape.begin(), cloud.height);
  return py::array(py::dtype::of<T>(), shape, {}, owned->data(), owner);
}

py::tuple read(const py::object& path) {
  const auto name = py::module_::import("os").attr("fsencode")(path).cast<std::string>();
  Cloud cloud;
  try {
    const py::gil_scoped_release released;
    cloud = read_cloud(name);
  } catch (const IoError& error) {
    throw std::invalid_argument(error.what());
  }
  py::object rgb = py::none();
  if (!cloud.rgb.empty()) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * cloud.rgb.size());
    for (const std::uint32_t color : cloud.rgb) {
      for (const int shift : {16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(color >> shift));
    }
    rgb = array_of(std::move(bytes), cloud);
  }
  py::object viewpoint = py::none();
  if (cloud.viewpoint) viewpoint = py::make_tuple((*cloud.viewpoint)[0], (*cloud.viewpoint)[1], (*cloud.viewpoint)[2]);
  return py::make_tuple(array_of(std::move(cloud.xyz), cloud), rgb, viewpoint);
}

}  // namespace
}  // namespace handhold::python

PYBIND11_MODULE(_io, m) {
  handhold::python::translate_errors();
  m.def("read_cloud", &handhold::python::read);
}
