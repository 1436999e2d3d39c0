// TOML <-> Options.
#include <toml++/toml.h>

#include <charconv>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <type_traits>

#include "handhold/config.h"

namespace handhold {
namespace {

/// A value as it stands in the file, on one line, for messages.
std::string as_written(const toml::node& node) {
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  std::string line = text.str();
  for (char& c : line) {
    if (c == '\n') c = ' ';
  }
  return line.size() <= 60 ? line : line.substr(0, 57) + "...";
}

[[noreturn]] void fail(std::string_view name, const toml::node& node, const std::string& right) {
  throw OptionError(std::string(name) + " = " + as_written(node) + ": must be " + right);
}

struct FromToml {
  std::string_view name;
  const toml::node& node;

  void operator()(int& field) const {
    const auto value = node.value_exact<std::int64_t>();
    if (!value) fail(name, node, "a whole number");
    if (*value < std::numeric_limits<int>::min() || *value > std::numeric_limits<int>::max()) {
      fail(name, node, "a whole number of at most " + std::to_string(std::numeric_limits<int>::max()));
    }
    field = static_cast<int>(*value);
  }

  void operator()(std::uint64_t& field) const {
    if (const auto text = node.value_exact<std::string>()) {
      const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), field);
      if (!text->empty() && error == std::errc() && end == text->data() + text->size()) return;
    } else if (const auto value = node.value_exact<std::int64_t>(); value && *value >= 0) {
      field = static_cast<std::uint64_t>(*value);
      return;
    }
    fail(name, node, "a whole number of at least 0");
  }

  void operator()(double& field) const {
    if (const auto value = node.value_exact<double>()) {
      field = *value;
    } else if (const auto whole = node.value_exact<std::int64_t>()) {
      field = static_cast<double>(*whole);
    } else {
      fail(name, node, "a number");
    }
  }

  void operator()(std::vector<double>& field) const {
    std::vector<double> values;
    if (const toml::array* array = node.as_array()) {
      for (const toml::node& element : *array) FromToml{name, element}(values.emplace_back());
    } else {
      (*this)(values.emplace_back());
    }
    field = std::move(values);
  }

  void operator()(std::array<double, 6>& field) const {
    const toml::array* array = node.as_array();
    if (!array || array->size() != field.size()) {
      fail(name, node, "six numbers: [xmin, xmax, ymin, ymax, zmin, zmax]");
    }
    for (std::size_t i = 0; i < field.size(); ++i) FromToml{name, (*array)[i]}(field[i]);
  }

  template <class T>
  void operator()(std::optional<T>& field) const {
    if (node.value_exact<std::string_view>() == std::string_view("default")) {
      field.reset();
    } else {
      T value{};
      (*this)(value);
      field = value;
    }
  }

  template <class T>
  std::enable_if_t<std::is_enum_v<T>> operator()(T& field) const {
    const auto text = node.value_exact<std::string>();
    if (!text) fail(name, node, "a string such as \"" + std::string(to_string(field)) + "\"");
    from_string(*text, field);
  }
};

struct ToToml {
  std::string& out;

  void operator()(int value) const { out += std::to_string(value); }
  void operator()(std::uint64_t value) const {
    const bool is_toml_integer = value <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    out += is_toml_integer ? std::to_string(value) : "\"" + std::to_string(value) + "\"";
  }
  void operator()(double value) const {
    char digits[64];
    const auto result = std::to_chars(digits, digits + sizeof digits, value);
    const std::string_view text(digits, static_cast<std::size_t>(result.ptr - digits));
    out += text;
    if (text.find_first_of(".en") == std::string_view::npos) out += ".0";  // 25 would be an integer; inf and nan stand
  }
  template <class List>
  void list(const List& values) const {
    out += '[';
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i) out += ", ";
      (*this)(values[i]);
    }
    out += ']';
  }
  void operator()(const std::vector<double>& values) const { list(values); }
  void operator()(const std::array<double, 6>& values) const { list(values); }
  template <class T>
  void operator()(const std::optional<T>& value) const {
    if (value) {
      (*this)(*value);
    } else {
      out += "\"default\"";
    }
  }
  template <class T>
  std::enable_if_t<std::is_enum_v<T>> operator()(T value) const {
    out += '"';
    out += to_string(value);
    out += '"';
  }
};

[[noreturn]] void fail_in_file(const std::string& source, int line, const std::string& message) {
  throw ConfigError(source + ", line " + std::to_string(line) + ": " + message);
}

void apply_entry(Options& options, const toml::key& key, const toml::node& node, const std::string& source) {
  const int line = static_cast<int>(key.source().begin.line);
  bool known = false;
  try {
    visit_options(options, [&](auto& field, const OptionInfo& info) {
      if (key.str() != info.name) return;
      known = true;
      FromToml{info.name, node}(field);
    });
  } catch (const OptionError& error) {
    fail_in_file(source, line, error.what());
  }
  if (known) return;
  const std::string nearest = nearest_name(key.str(), option_names());
  std::string message = node.is_table() ? "unknown table '" : "unknown key '";
  message += key.str();
  message += "'; ";
  if (!nearest.empty()) {
    message += "did you mean '" + nearest + "'?";
  } else {
    message += node.is_table() ? "options stand on the top level, in no table"
                               : "keys are the names of options, as in 'hand_aperture = 0.08'";
  }
  fail_in_file(source, line, message);
}

}  // namespace

ConfigLines apply_toml(Options& options, std::string_view text, const std::string& source) {
  toml::table table;
  try {
    table = toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    std::string message(error.description());
    for (char& c : message) {
      if (c == '\n') c = ' ';
    }
    fail_in_file(source, static_cast<int>(error.source().begin.line), message);
  }
  Options changed = options;
  ConfigLines lines;
  // The table is sorted by key; of several mistakes the first in the file is reported.
  std::map<std::pair<int, std::string>, std::pair<const toml::key*, const toml::node*>> by_line;
  for (auto&& [key, node] : table) {
    const int line = static_cast<int>(key.source().begin.line);
    by_line[{line, std::string(key.str())}] = {&key, &node};
  }
  for (const auto& [place, entry] : by_line) {
    apply_entry(changed, *entry.first, *entry.second, source);
    lines[place.second] = place.first;
  }
  options = std::move(changed);
  return lines;
}

ConfigLines apply_toml_file(Options& options, const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw ConfigError("cannot read '" + path + "': it is a folder; give the name of a TOML file");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    const bool exists = std::filesystem::exists(path, ignored);
    throw ConfigError("cannot read '" + path + "': " + (exists ? "permission denied" : "no such file") +
                      "; give the name of a TOML file");
  }
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad()) throw ConfigError("cannot read '" + path + "': the disk failed; give another TOML file");
  return apply_toml(options, text.str(), path);
}

Options read_options(const std::string& path) {
  Options options;
  apply_toml_file(options, path);
  try {
    options.validate();
  } catch (const OptionError& error) {
    throw ConfigError(path + ": " + error.what());
  }
  return options;
}

std::string to_toml(const Options& options) {
  std::string out;
  visit_options(options, [&](const auto& field, const OptionInfo& info) {
    out += "# ";
    out += info.help;
    if (*info.unit) out += std::string(" (") + info.unit + ")";
    out += '\n';
    out += info.name;
    out += " = ";
    ToToml{out}(field);
    out += '\n';
  });
  return out;
}

}  // namespace handhold
