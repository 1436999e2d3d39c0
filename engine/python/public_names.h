// What stands in handhold._core or handhold._plan is shown as of the package that takes it over.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace handhold::python {

inline void make_public(pybind11::module_& m, const char* package) {
  namespace py = pybind11;
  for (const auto& [name, value] : m.attr("__dict__").cast<py::dict>()) {
    if (name.cast<std::string>()[0] != '_' && py::hasattr(value, "__module__")) value.attr("__module__") = package;
  }
}

}  // namespace handhold::python
