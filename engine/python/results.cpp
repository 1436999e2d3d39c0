#include "results.h"

#include <pybind11/stl.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "numpy_views.h"

namespace handhold::python {
namespace {

// ---- The fields, once: a property of one element, of all of them, and a key of to_dict() ---------------------------

template <class Visitor>
void visit_fields(Visitor&& visit, const Handle*) {
  visit("center", &Handle::center, "m; middle of the extent on the axis, or where `path` is best held");
  visit("axis", &Handle::axis, "unit; its largest component is positive");
  visit("approach", &Handle::approach, "unit; direction in which a hand moves towards the part");
  visit("radius", &Handle::radius, "m");
  visit("length", &Handle::length, "m; extent along the axis");
  visit("confidence", &Handle::confidence,
        "0 to 1; default method: probability that the handle is right; paper's method: not calibrated");
  visit("arc", &Handle::arc, "rad; angle about the axis within which points were measured; 0 with the paper's method");
  visit("residual", &Handle::residual,
        "m; root mean square distance of the points from the cylinder; 0 with the paper's method");
  visit("observed_free", &Handle::observed_free,
        "0 to 1; share of the fingers' volumes that was seen empty; 0 with the paper's method");
  visit("normal_error", &Handle::normal_error,
        "rad; mean angle between the points' normals and the cylinder's; 0 with the paper's method");
  visit("path", &Handle::path, "m; points on the line through a curved handle's middle, end to end; empty: straight");
  visit("affordances", &Handle::affordances, "indices into Result.affordances, ascending");
}

template <class Visitor>
void visit_fields(Visitor&& visit, const Affordance*) {
  visit("center", &Affordance::center, "m; point of the axis at the sample's height");
  visit("axis", &Affordance::axis, "unit; direction of least curvature; its largest component is positive");
  visit("normal", &Affordance::normal, "unit; outward, towards the sensor's side");
  visit("radius", &Affordance::radius, "m; of the fitted circle");
  visit("shell_radius", &Affordance::shell_radius, "m; inner radius of the shell found");
  visit("gap", &Affordance::gap, "m; free width found outside of shell_radius");
  visit("curvature", &Affordance::curvature, "1/m; median of the largest absolute curvature over the neighbourhood");
  visit("observed_free", &Affordance::observed_free,
        "0 to 1; share of the fingers' volumes that was seen empty; 0 where it was not looked at");
  visit("quality", &Affordance::quality, "0 to 1; how well the points fit the cylinder (default method)");
  visit("neighbourhood", &Affordance::neighbourhood,
        "m; radius of the ball; 0: found by its outline in the depth image (default method)");
  visit("sample", &Affordance::sample, "index of the sample that it came from: of Localizer.samples()");
}

/// A field of one element.
template <class T>
py::object one(const Owner& owner, const T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    return py::cast(value);
  } else {
    return view(owner, value);
  }
}

/// A field of all elements: an array, or where the elements have several values each, a tuple of arrays.
template <class Element, class T>
py::object column(const std::shared_ptr<const std::vector<Element>>& all, T Element::*field) {
  const auto n = static_cast<py::ssize_t>(all->size());
  const T* first = all->empty() ? nullptr : &(all->front().*field);
  constexpr py::ssize_t kStep = sizeof(Element);
  if constexpr (std::is_arithmetic_v<T>) {
    return view(all, first, {n}, {kStep});
  } else if constexpr (std::is_same_v<T, Vector3>) {
    return view(all, first ? first->data() : nullptr, {n, 3}, {kStep, sizeof(double)});
  } else {
    py::tuple columns(all->size());
    for (std::size_t i = 0; i < all->size(); ++i) columns[i] = view(all, (*all)[i].*field);
    return std::move(columns);
  }
}

template <class T>
constexpr const char* shape_of_column() {
  if constexpr (std::is_arithmetic_v<T>) {
    return "(N,)";
  } else if constexpr (std::is_same_v<T, Vector3>) {
    return "(N, 3)";
  } else if constexpr (std::is_same_v<T, std::vector<Vector3>>) {
    return "N arrays (P, 3)";
  } else {
    return "N arrays (A,)";
  }
}

// ---- Elements and sequences of them ---------------------------------------------------------------------------------

template <class Element>
py::dict to_dict(const Element& element) {
  py::dict dict;
  visit_fields([&](const char* name, auto field, const char*) { dict[name] = py::cast(element.*field); }, &element);
  return dict;
}

template <class Element>
std::string repr(const char* type, const Element& element) {
  const auto vector = [](const Vector3& v) {
    return py::str("({:.4g}, {:.4g}, {:.4g})").format(v[0], v[1], v[2]).template cast<std::string>();
  };
  const auto number = [](double x) { return py::str("{:.4g}").format(x).template cast<std::string>(); };
  std::string text = std::string(type) + "(center=" + vector(element.center) + ", axis=" + vector(element.axis) +
                     ", radius=" + number(element.radius);
  if constexpr (std::is_same_v<Element, Handle>) {
    text += ", length=" + number(element.length) + ", confidence=" + number(element.confidence);
  }
  return text + ")";
}

template <class Element>
py::class_<PyElement<Element>> bind_element(py::module_& m, const char* name, const std::string& doc) {
  py::class_<PyElement<Element>> type(m, name, doc.c_str());
  visit_fields(
      [&](const char* field_name, auto field, const char* help) {
        type.def_property_readonly(
            field_name, [field](const PyElement<Element>& e) { return one(e.it, (*e.it).*field); }, help);
      },
      static_cast<const Element*>(nullptr));
  type.def(
      "to_dict", [](const PyElement<Element>& e) { return to_dict(*e.it); },
      "to_dict(self)\n--\n\nAll of it as plain Python numbers and lists, as in the command line's JSON.");
  type.def("__repr__", [name](const PyElement<Element>& e) { return repr(name, *e.it); });
  return type;
}

template <class Element>
void bind_elements(py::module_& m, const char* name, const std::string& doc) {
  using Elements = PyElements<Element>;
  py::class_<Elements> type(m, name, doc.c_str());
  visit_fields(
      [&](const char* field_name, auto field, const char* help) {
        using T = std::decay_t<decltype(std::declval<Element>().*field)>;
        const std::string text = std::string(shape_of_column<T>()) + "; " + help;
        type.def_property_readonly(
            field_name, [field](const Elements& e) { return column(e.all, field); }, text.c_str());
      },
      static_cast<const Element*>(nullptr));
  const auto at = [](const Elements& e, std::size_t i) {
    return PyElement<Element>{std::shared_ptr<const Element>(e.all, &(*e.all)[i])};
  };
  type.def("__len__", [](const Elements& e) { return e.all->size(); });
  type.def("__getitem__", [at, name](const Elements& e, py::ssize_t i) {
    const auto n = static_cast<py::ssize_t>(e.all->size());
    if (i < -n || i >= n) {
      throw py::index_error(std::string(name) + "[" + std::to_string(i) + "]: there are " + std::to_string(n));
    }
    return at(e, static_cast<std::size_t>(i < 0 ? i + n : i));
  });
  type.def("__getitem__", [at](const Elements& e, const py::slice& slice) {
    std::size_t start = 0, stop = 0, step = 0, length = 0;
    if (!slice.compute(e.all->size(), &start, &stop, &step, &length)) throw py::error_already_set();
    py::list list;
    for (std::size_t i = 0; i < length; ++i, start += step) list.append(at(e, start));
    return list;
  });
  type.def("__iter__", [at](const Elements& e) {
    py::list list;
    for (std::size_t i = 0; i < e.all->size(); ++i) list.append(at(e, i));
    return py::iter(list);
  });
  type.def("__repr__",
           [name](const Elements& e) { return "<" + std::string(name) + ": " + std::to_string(e.all->size()) + ">"; });
}

// ---- The whole result -----------------------------------------------------------------------------------------------

py::dict funnel_dict(const Funnel& f) {
  py::dict d;
  d["samples"] = f.samples, d["too_few_points"] = f.too_few_points, d["flat"] = f.flat;
  d["curvature_low"] = f.curvature_low, d["concave"] = f.concave, d["circle_wide"] = f.circle_wide;
  d["circle_narrow"] = f.circle_narrow, d["poor_fit"] = f.poor_fit, d["no_gap"] = f.no_gap;
  d["shell_empty"] = f.shell_empty, d["affordances"] = f.affordances, d["cut"] = f.cut;
  d["not_aligned"] = f.not_aligned, d["unconfirmed"] = f.unconfirmed, d["too_short"] = f.too_short;
  d["low_confidence"] = f.low_confidence, d["in_handles"] = f.in_handles;
  return d;
}

py::dict times_dict(const StageTimes& t) {
  py::dict d;
  d["index"] = t.index, d["samples"] = t.samples, d["neighbours"] = t.neighbours, d["moments"] = t.moments;
  d["fit"] = t.fit, d["shell"] = t.shell, d["visibility"] = t.visibility, d["handles"] = t.handles;
  d["total"] = t.total;
  return d;
}

bool cut(const Result& r) {
  return r.status == Status::kDeadline || r.status == Status::kCancelled;
}

/// As in the JSON of the command line; what it says of the cloud and the options, the caller knows.
py::dict result_dict(const Result& r) {
  py::dict d;
  d["status"] = std::string(to_string(r.status));
  d["points"] = r.points, d["finite_points"] = r.finite_points;
  d["funnel"] = funnel_dict(r.funnel), d["times_ms"] = times_dict(r.times_ms);
  py::list handles, affordances;
  for (const Handle& h : r.handles) handles.append(to_dict(h));
  for (const Affordance& a : r.affordances) affordances.append(to_dict(a));
  d["handles"] = handles, d["affordances"] = affordances;
  return d;
}

PyHandle make_handle(const py::object& center, const py::object& axis, const py::object& approach,
                     const py::object& radius, const py::object& length, const py::object& confidence,
                     const py::object& path) {
  auto handle = std::make_shared<Handle>();
  handle->center = to_vector3("center", center);
  handle->axis = to_vector3("axis", axis);
  handle->approach = to_vector3("approach", approach);
  handle->radius = to_number("radius", radius);
  handle->length = to_number("length", length);
  handle->confidence = to_number("confidence", confidence);
  for (const py::handle point : path) handle->path.push_back(to_vector3("path", point));
  return {std::move(handle)};
}

}  // namespace

std::vector<Handle> to_handles(const py::object& handles) {
  if (py::isinstance<PyHandles>(handles)) return *handles.cast<const PyHandles&>().all;
  std::vector<Handle> copies;
  if (PySequence_Check(handles.ptr())) {
    for (const py::handle element : handles) {
      if (!py::isinstance<PyHandle>(element)) {
        throw std::invalid_argument("handles[" + std::to_string(copies.size()) + "] = " + written(element) +
                                    ": must be a handhold.Handle");
      }
      copies.push_back(*element.cast<const PyHandle&>().it);
    }
    return copies;
  }
  throw std::invalid_argument("handles = " + written(handles) +
                              ": must be Result.handles or a list of handhold.Handle");
}

void bind_results(py::module_& m) {
  const std::string frame = "Metres and radians, in the frame of the cloud.";
  const std::string views =
      "\n\nArrays are read-only views of the library's memory, without a copy; they stay valid for as long as you keep "
      "them.\n.copy() makes one that may be changed. ";
  bind_element<Handle>(m, "Handle",
                       "A contiguous run of aligned affordances: one graspable part.\n\n" + frame +
                           " Result.handles has those that were found; made by hand, one\ncan be planned for.")
      .def(py::init(&make_handle), py::arg("center"), py::arg("axis"), py::arg("approach"), py::arg("radius"),
           py::arg("length"), py::arg("confidence") = 1.0, py::arg("path") = py::tuple(),
           "__init__(self, center, axis, approach, radius, length, confidence=1.0, path=())\n--\n\n");
  bind_element<Affordance>(m, "Affordance",
                           "One cylindrical shell that satisfies the conditions of an enveloping grasp (of the paper's "
                           "section 3).\n\n" +
                               frame);
  bind_elements<Handle>(
      m, "Handles",
      "The handles of a result, the most confident first: a sequence of Handle, and an array of each field.\n\n" +
          frame + views + "");
  bind_elements<Affordance>(m, "Affordances",
                            "The affordances of a result, in the order of their samples: a sequence of Affordance, and "
                            "an array of each field.\n\n" +
                                frame + views);
  py::class_<PyResult>(m, "Result",
                       "What was found in a cloud, why it was not more, and how long each step took.\n\n"
                       "It owns what it holds and never changes, whatever the localizer does next.")
      .def_property_readonly(
          "status", [](const PyResult& r) { return std::string(to_string(r.it->status)); },
          "'ok' (there may still be no handles) or 'deadline' (what was found in time is there); or why there are "
          "none:\n"
          "'empty', 'no_finite_points', 'too_few_points', 'suspicious_units' (over 100 m wide: probably millimetres),\n"
          "'cancelled'.")
      .def_property_readonly(
          "cut", [](const PyResult& r) { return cut(*r.it); },
          "True when deadline_ms or cancel() ended the search before everything had been looked at.")
      .def_property_readonly(
          "points", [](const PyResult& r) { return r.it->points; }, "Points of the cloud.")
      .def_property_readonly(
          "finite_points", [](const PyResult& r) { return r.it->finite_points; },
          "Those without a coordinate that is NaN, infinite or beyond 1e6 m.")
      .def_property_readonly(
          "handles",
          [](const PyResult& r) {
            return PyHandles{{r.it, &r.it->handles}};
          },
          "The handles, the most confident first.")
      .def_property_readonly(
          "affordances",
          [](const PyResult& r) {
            return PyAffordances{{r.it, &r.it->affordances}};
          },
          "The affordances, in the order of their samples.")
      .def_property_readonly(
          "funnel", [](const PyResult& r) { return funnel_dict(r.it->funnel); },
          "How many samples ended at each step, in the order of the steps, from 'samples' to 'cut'; then of the\n"
          "affordances, from 'not_aligned' to 'in_handles'.")
      .def_property_readonly(
          "times_ms", [](const PyResult& r) { return times_dict(r.it->times_ms); },
          "Wall-clock time of each step of the search (ms), and 'total'. A copy of the points comes before it.")
      .def(
          "to_dict", [](const PyResult& r) { return result_dict(*r.it); },
          "to_dict(self)\n--\n\n"
          "All of it as plain Python numbers, strings, lists and dictionaries, for json.dump or pickle.")
      .def("__repr__", [](const PyResult& r) {
        return "<Result: " + std::string(to_string(r.it->status)) + ", " + std::to_string(r.it->handles.size()) +
               " handles, " + std::to_string(r.it->affordances.size()) + " affordances, " +
               std::to_string(r.it->points) + " points>";
      });
}

}  // namespace handhold::python
