#include "keywords.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

#include "handhold/config.h"
#include "numpy_views.h"

namespace handhold::python {
namespace {

[[noreturn]] void fail(const char* name, py::handle value, const std::string& right) {
  throw OptionError(std::string(name) + " = " + written(value) + ": must be " + right);
}

/// A whole number of the field's type: int, and NumPy's integers; True and 5000.0 are none.
template <class T>
T whole(const char* name, py::handle value, const char* right) {
  if (!PyIndex_Check(value.ptr()) || PyBool_Check(value.ptr())) fail(name, value, right);
  const auto number = py::reinterpret_steal<py::int_>(PyNumber_Index(value.ptr()));
  if (!number) throw py::error_already_set();
  if (number < py::int_(std::numeric_limits<T>::min())) fail(name, value, right);
  if (number > py::int_(std::numeric_limits<T>::max())) {
    fail(name, value, "a whole number of at most " + std::to_string(std::numeric_limits<T>::max()));
  }
  return number.cast<T>();
}

bool is_list(py::handle value) {
  if (!PySequence_Check(value.ptr()) || py::isinstance<py::str>(value) || py::isinstance<py::bytes>(value))
    return false;
  const bool has_length = PySequence_Size(value.ptr()) >= 0;  // an array without dimensions has none
  PyErr_Clear();
  return has_length;
}

/// What engine/config does with TOML, for Python's values.
struct FromPython {
  const char* name;
  py::handle value;

  void operator()(int& field) const { field = whole<int>(name, value, "a whole number"); }
  void operator()(std::uint64_t& field) const {
    field = whole<std::uint64_t>(name, value, "a whole number of at least 0");
  }
  void operator()(double& field) const {
    try {
      field = to_number(name, value);
    } catch (const std::invalid_argument& error) {
      throw OptionError(error.what());
    }
  }
  void operator()(std::vector<double>& field) const {
    std::vector<double> values;
    if (is_list(value)) {
      for (const py::handle element : value) FromPython{name, element}(values.emplace_back());
    } else if (!unset()) {
      (*this)(values.emplace_back());
    }
    field = std::move(values);
  }
  void operator()(std::array<double, 6>& field) const {
    if (!is_list(value) || py::len(value) != field.size()) {
      fail(name, value, "six numbers: [xmin, xmax, ymin, ymax, zmin, zmax]");
    }
    std::size_t i = 0;
    for (const py::handle element : value) FromPython{name, element}(field[i++]);
  }
  template <class T>
  void operator()(std::optional<T>& field) const {
    if (unset()) {
      field.reset();
      return;
    }
    T given{};
    (*this)(given);
    field = given;
  }
  template <class T>
  std::enable_if_t<std::is_enum_v<T>> operator()(T& field) const {
    if (!py::isinstance<py::str>(value)) fail(name, value, "a string such as '" + std::string(to_string(field)) + "'");
    from_string(value.cast<std::string>(), field);
  }

  bool unset() const {
    return value.is_none() || (py::isinstance<py::str>(value) && value.cast<std::string>() == "default");
  }
};

struct ToPython {
  template <class T>
  py::object operator()(const T& field) const {
    if constexpr (std::is_enum_v<T>) {
      return py::str(std::string(to_string(field)));
    } else {
      return py::cast(field);
    }
  }
  template <class List>
  py::object list(const List& values) const {
    py::list list;
    for (const double value : values) list.append(value);
    return std::move(list);
  }
  py::object operator()(const std::vector<double>& values) const {
    return values.empty() ? py::object(py::none()) : list(values);
  }
  py::object operator()(const std::array<double, 6>& values) const { return list(values); }
  template <class T>
  py::object operator()(const std::optional<T>& field) const {
    return field ? (*this)(*field) : py::object(py::none());
  }
};

void set(Options& options, const std::string& name, py::handle value, const std::vector<std::string>& others) {
  bool known = false;
  visit_options(options, [&](auto& field, const OptionInfo& info) {
    if (name != info.name) return;
    known = true;
    FromPython{info.name, value}(field);
  });
  if (known) return;
  std::vector<std::string> names = option_names();
  names.insert(names.end(), {"hand", "config"});
  names.insert(names.end(), others.begin(), others.end());
  const std::string nearest = nearest_name(name, names);
  throw OptionError("unknown option '" + name + "'; " +
                    (nearest.empty() ? "handhold.options() has them all" : "did you mean '" + nearest + "'?"));
}

}  // namespace

Options to_options(const py::kwargs& keywords, const std::vector<std::string>& others) {
  Options options;
  ConfigLines lines;
  std::string path;
  if (keywords.contains("hand") && !py::object(keywords["hand"]).is_none()) {
    const py::object hand = keywords["hand"];
    if (!hand.equal(py::str("baxter"))) throw OptionError("unknown hand " + written(hand) + "; must be 'baxter'");
    options = Options::baxter();
  }
  if (keywords.contains("config") && !py::object(keywords["config"]).is_none()) {
    // os.fsencode takes what open() takes, but for descriptors.
    path = py::module_::import("os").attr("fsencode")(keywords["config"]).cast<std::string>();
    try {
      lines = apply_toml_file(options, path);
    } catch (const ConfigError& error) {
      throw OptionError(error.what());
    }
  }
  for (const auto& [key, value] : keywords) {
    const auto name = key.cast<std::string>();
    if (name == "hand" || name == "config") continue;
    set(options, name, value, others);
    lines.erase(name);
  }
  try {
    options.validate();
  } catch (const OptionError& error) {
    // The message names the option first; say where it was set.
    const std::string message = error.what();
    const std::string name = message.substr(0, message.find(' '));
    if (!lines.count(name)) throw;
    throw OptionError(path + ", line " + std::to_string(lines.at(name)) + ": " + message);
  }
  return options;
}

py::dict to_dict(const Options& options) {
  py::dict dict;
  visit_options(options, [&](const auto& field, const OptionInfo& info) { dict[info.name] = ToPython{}(field); });
  return dict;
}

std::string keyword_signature() {
  std::string text = "hand=None, config=None";
  for (const auto& [name, value] : to_dict({})) text += ", " + name.cast<std::string>() + "=" + written(value);
  return text;
}

std::string keyword_help() {
  std::string text;
  const Options defaults;
  visit_options(defaults, [&](const auto&, const OptionInfo& info) {
    text += std::string("    ") + info.name + ": " + info.help +
            (*info.unit ? std::string(" (") + info.unit + ")" : "") + "\n";
  });
  return text;
}

}  // namespace handhold::python
