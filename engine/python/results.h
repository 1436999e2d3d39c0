// Results as Python sees them. They share the library's memory, and keep it as long as anything of it is in use.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "handhold/result.h"

namespace handhold::python {

using ResultPointer = std::shared_ptr<const Result>;
// One element of a result, or an object of its own.
using HandlePointer = std::shared_ptr<const Handle>;
using AffordancePointer = std::shared_ptr<const Affordance>;

/// A handle or an affordance.
template <class Element>
struct PyElement {
  std::shared_ptr<const Element> it;
};
using PyHandle = PyElement<Handle>;
using PyAffordance = PyElement<Affordance>;

/// All handles or all affordances of a result.
template <class Element>
struct PyElements {
  std::shared_ptr<const std::vector<Element>> all;
};
using PyHandles = PyElements<Handle>;
using PyAffordances = PyElements<Affordance>;

struct PyResult {
  ResultPointer it;
};

/// Copies of handles: of Result.handles, or of any sequence of Handle. @throws std::invalid_argument
std::vector<Handle> to_handles(const pybind11::object& handles);

void bind_results(pybind11::module_& m);

}  // namespace handhold::python
