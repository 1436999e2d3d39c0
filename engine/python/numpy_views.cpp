#include "numpy_views.h"

#include <cmath>
#include <exception>
#include <stdexcept>

namespace handhold::python {

std::string written(py::handle value) {
  const py::object text = py::reinterpret_steal<py::object>(PyObject_ASCII(value.ptr()));
  if (!text) throw py::error_already_set();
  auto line = text.cast<std::string>();
  for (char& c : line) {
    if (c == '\n') c = ' ';
  }
  return line.size() <= 60 ? line : line.substr(0, 57) + "...";
}

double to_number(const char* name, py::handle value) {
  const PyNumberMethods* methods = Py_TYPE(value.ptr())->tp_as_number;
  const bool is_number = methods && (methods->nb_float || methods->nb_index) && !PyBool_Check(value.ptr());
  const double number = is_number ? PyFloat_AsDouble(value.ptr()) : 0;
  if (!is_number || PyErr_Occurred()) {
    PyErr_Clear();
    throw std::invalid_argument(std::string(name) + " = " + written(value) + ": must be a number");
  }
  return number;
}

Vector3 to_vector3(const char* name, py::handle value) {
  Vector3 v;
  std::size_t n = 0;
  if (!py::isinstance<py::str>(value) && PySequence_Check(value.ptr())) {
    for (const py::handle x : value) {
      if (n < 3) v[n] = to_number(name, x);
      ++n;
    }
  }
  if (n != 3)
    throw std::invalid_argument(std::string(name) + " = " + written(value) + ": must be three numbers (x, y, z)");
  return v;
}

Rigid to_rigid(const char* name, const py::object& matrix) {
  const auto fail = [&] {
    PyErr_Clear();
    throw std::invalid_argument(std::string(name) + " = " + written(matrix) +
                                ": must be a 4x4 matrix, a rotation and a translation (m)");
  };
  const auto T = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(matrix);
  if (!T || T.ndim() != 2 || T.shape(0) != 4 || T.shape(1) != 4) fail();
  constexpr double kTolerance = 1e-3;
  const auto near = [&](double a, double b) { return std::fabs(a - b) <= kTolerance; };  // false for NaN
  const auto at = T.unchecked<2>();
  Rigid rigid;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) rigid.R[static_cast<std::size_t>(3 * r + c)] = at(r, c);
    rigid.t[static_cast<std::size_t>(r)] = at(r, 3);
    if (!std::isfinite(at(r, 3)) || !near(at(3, r), 0)) fail();
    for (int other = 0; other < 3; ++other) {
      const double dot = at(r, 0) * at(other, 0) + at(r, 1) * at(other, 1) + at(r, 2) * at(other, 2);
      if (!near(dot, r == other ? 1 : 0)) fail();
    }
  }
  const std::array<double, 9>& R = rigid.R;
  const double determinant =
      R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6]) + R[2] * (R[3] * R[7] - R[4] * R[6]);
  if (!near(at(3, 3), 1) || determinant < 0) fail();
  return rigid;
}

std::vector<Vector3> to_vectors3(const char* name, const py::object& array) {
  const auto rows = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!rows || rows.ndim() != 2 || rows.shape(1) != 3) {
    PyErr_Clear();
    throw std::invalid_argument(std::string(name) + " = " + written(array) + ": must be numbers of shape (N, 3)");
  }
  std::vector<Vector3> vectors(static_cast<std::size_t>(rows.shape(0)));
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) vectors[i][k] = rows.at(i, k);
  }
  return vectors;
}

void translate_errors() {
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const std::invalid_argument& error) {
      // A path in the message may be no UTF-8.
      const std::string text = error.what();
      const auto message = py::reinterpret_steal<py::object>(
          PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "backslashreplace"));
      PyErr_SetObject(PyExc_ValueError, message.ptr());
    }
  });
}

}  // namespace handhold::python
