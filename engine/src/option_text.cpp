// Single options from and to text, and names for messages.
#include "handhold/option_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace handhold {
namespace {

constexpr std::string_view kBlanks = " \t\n\r,";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

[[noreturn]] void fail(std::string_view name, std::string_view text, const std::string& right) {
  throw OptionError(std::string(name) + " = '" + std::string(text) + "': must be " + right);
}

struct FromText {
  std::string_view name;
  std::string_view text;

  template <class T>
  std::enable_if_t<std::is_integral_v<T>> operator()(T& field) const {
    const std::string_view digits = trimmed(text);
    T value{};
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error == std::errc::result_out_of_range) {
      fail(name, text, "a whole number of at most " + std::to_string(std::numeric_limits<T>::max()));
    }
    if (error != std::errc() || end != digits.data() + digits.size()) {
      fail(name, text, std::is_unsigned_v<T> ? "a whole number of at least 0" : "a whole number");
    }
    field = value;
  }

  void operator()(double& field) const {
    const std::vector<double> values = parse_numbers(name, text);
    if (values.size() != 1) fail(name, text, "one number");
    field = values[0];
  }

  void operator()(std::vector<double>& field) const {
    field = trimmed(text) == "default" ? std::vector<double>() : parse_numbers(name, text);
  }

  void operator()(std::array<double, 6>& field) const {
    const std::vector<double> values = parse_numbers(name, text);
    if (values.size() != 6) fail(name, text, "six numbers: XMIN XMAX YMIN YMAX ZMIN ZMAX");
    std::copy(values.begin(), values.end(), field.begin());
  }

  template <class T>
  void operator()(std::optional<T>& field) const {
    if (trimmed(text) == "default") {
      field.reset();
      return;
    }
    T value{};
    (*this)(value);
    field = value;
  }

  template <class T>
  std::enable_if_t<std::is_enum_v<T>> operator()(T& field) const {
    from_string(trimmed(text), field);
  }
};

/// The reverse: what FromText reads back to the same value, bit for bit.
struct ToText {
  template <class T>
  std::enable_if_t<std::is_arithmetic_v<T>, std::string> operator()(T value) const {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
  }
  template <class T>
  std::enable_if_t<std::is_enum_v<T>, std::string> operator()(T value) const {
    return std::string(to_string(value));
  }
  template <class List>
  std::string list(const List& values) const {
    std::string text;
    for (const double value : values) text += (text.empty() ? "" : " ") + (*this)(value);
    return text;
  }
  std::string operator()(const std::vector<double>& values) const { return values.empty() ? "default" : list(values); }
  std::string operator()(const std::array<double, 6>& values) const { return list(values); }
  template <class T>
  std::string operator()(const std::optional<T>& value) const {
    return value ? (*this)(*value) : "default";
  }
};

/// Edits (insert, delete, replace, swap of neighbours) that turn a into b.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

[[noreturn]] void fail_unknown(std::string_view name) {
  const std::string nearest = nearest_name(name, option_names());
  throw OptionError("unknown option '" + std::string(name) + "'" +
                    (nearest.empty() ? std::string() : "; did you mean '" + nearest + "'?"));
}

}  // namespace

std::vector<double> parse_numbers(std::string_view name, std::string_view text) {
  std::vector<double> values;
  std::string_view rest = trimmed(text);
  while (!rest.empty()) {
    const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
    const std::string_view digits = word.substr(word[0] == '+' && word.size() > 1 && word[1] != '-' ? 1 : 0);
    double value = 0;
    // from_chars, because strtod reads "0,08" in some locales and hexadecimal in all.
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value)) {
      throw OptionError(std::string(name) + " = '" + std::string(word) + "': must be a finite number");
    }
    values.push_back(value);
    rest = trimmed(rest.substr(word.size()));
  }
  if (values.empty()) fail(name, text, "a number");
  return values;
}

void set_option(Options& options, std::string_view name, std::string_view text) {
  bool known = false;
  visit_options(options, [&](auto& field, const OptionInfo& info) {
    if (name != info.name) return;
    known = true;
    FromText{name, text}(field);
  });
  if (!known) fail_unknown(name);
}

std::string get_option(const Options& options, std::string_view name) {
  bool known = false;
  std::string text;
  visit_options(options, [&](const auto& field, const OptionInfo& info) {
    if (name != info.name) return;
    known = true;
    text = ToText{}(field);
  });
  if (!known) fail_unknown(name);
  return text;
}

std::vector<std::string> option_names() {
  std::vector<std::string> names;
  const Options options;
  visit_options(options, [&](const auto&, const OptionInfo& info) { names.emplace_back(info.name); });
  return names;
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
  std::string nearest, containing;
  // Beyond a third of the letters wrong, a guess confuses more than it helps.
  std::size_t least = 1 + (name.size() <= 4 ? 1 : std::max<std::size_t>(2, name.size() / 3));
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < least) {
      least = distance;
      nearest = candidate;
    }
    const bool contains = name.size() >= 4 && candidate.find(name) != std::string::npos;
    if (contains && (containing.empty() || candidate.size() < containing.size())) containing = candidate;
  }
  // One slip is a slip; otherwise "aperture" means "hand_aperture" rather than "picture".
  return containing.empty() || (!nearest.empty() && least <= 1) ? nearest : containing;
}

}  // namespace handhold
