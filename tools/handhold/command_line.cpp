#include "command_line.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <type_traits>

#include "handhold/config.h"
#include "usage_error.h"

namespace handhold {
namespace {

template <class T>
const char* value_name(const T&) {
  if constexpr (std::is_enum_v<T>) return "NAME";
  if constexpr (std::is_integral_v<T>) return "N";
  return "X";
}
const char* value_name(const std::vector<double>&) {
  return "X...";
}
const char* value_name(const std::optional<std::array<double, 6>>&) {
  return "X X X X X X";
}

template <class T>
std::string default_text(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return std::string(to_string(value));
  } else if constexpr (std::is_integral_v<T>) {
    return std::to_string(value);
  } else if constexpr (std::is_floating_point_v<T>) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
  } else {
    return {};
  }
}
std::string default_text(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : " ") + default_text(value);
  return text;
}

bool is_number(const std::string& text) {
  double value = 0;
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  return error != std::errc::invalid_argument && end == text.data() + text.size();
}

}  // namespace

std::string flag_of(std::string_view option) {
  std::string flag = "--" + std::string(option);
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

CLI::Option* add_text_flag(CLI::App& app, const std::string& flag, std::string& target, const std::string& value_name,
                           const std::string& help, const std::string& group) {
  return app
      .add_option_function<std::string>(
          flag,
          [flag, &target](const std::string& text) {
            // "--json --explain" would otherwise write a file of that name.
            if (text.empty()) throw UsageError(flag + " needs a value, but an empty text follows it");
            if (text.rfind("--", 0) == 0) throw UsageError(flag + " needs a value, but '" + text + "' follows it");
            target = text;
          },
          help)
      ->option_text(value_name)
      ->take_last()
      ->group(group);
}

void add_option_flags(CLI::App& app, OptionTexts& texts) {
  const Options defaults;
  visit_options(defaults, [&](const auto& field, const OptionInfo& info) {
    std::string help = info.help;
    if (*info.unit) help += std::string(" (") + info.unit + ")";
    const std::string standard = default_text(field);
    if (!standard.empty()) help += " [" + standard + "]";
    add_text_flag(app, flag_of(info.name), texts[info.name], value_name(field), help,
                  "Options of the search (also keys of --config)");
  });
}

void apply_option_texts(Options& options, const OptionTexts& texts) {
  for (const auto& [name, text] : texts) {
    if (text.empty()) continue;
    try {
      set_option(options, name, text);
    } catch (const OptionError& error) {
      throw UsageError(with_flag(name, error.what()));
    }
  }
}

std::uint64_t whole_number(const std::string& flag, const std::string& text, std::uint64_t low, std::uint64_t high) {
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc() && last == end && value >= low && value <= high) return value;
  throw UsageError(flag + " = '" + text + "': must be a whole number from " + std::to_string(low) + " to " +
                   std::to_string(high));
}

std::vector<int> whole_numbers(const std::string& flag, const std::string& text, int low, int high) {
  std::vector<int> values;
  for (const double value : numbers(flag, text, low, high, "")) {
    if (value != std::floor(value)) {
      throw UsageError(flag + " = '" + text + "': must be whole numbers from " + std::to_string(low) + " to " +
                       std::to_string(high));
    }
    values.push_back(static_cast<int>(value));
  }
  return values;
}

std::vector<double> numbers(const std::string& flag, const std::string& text, double low, double high,
                            const std::string& unit) {
  const std::vector<double> values = parse_numbers(flag, text);
  for (const double value : values) {
    if (value >= low && value <= high) continue;
    throw UsageError(flag + " = '" + text + "': must be numbers from " + default_text(low) + " to " +
                     default_text(high) + (unit.empty() ? "" : " ") + unit);
  }
  return values;
}

std::string with_flag(const std::string& option, const std::string& message) {
  if (message.rfind(option + " ", 0) == 0) return flag_of(option) + message.substr(option.size());
  return flag_of(option) + ": " + message;
}

std::vector<std::string> join_lists(const std::vector<std::string>& arguments) {
  const std::vector<std::string> lists = {"--radius",      "--workspace", "--viewpoint",
                                          "--camera-pose", "--table",     "--start"};
  std::vector<std::string> joined;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    joined.push_back(arguments[i]);
    if (arguments[i] == "--") {
      joined.insert(joined.end(), arguments.begin() + static_cast<std::ptrdiff_t>(i) + 1, arguments.end());
      break;
    }
    const bool takes_list = std::find(lists.begin(), lists.end(), arguments[i]) != lists.end();
    if (!takes_list || i + 1 == arguments.size()) continue;
    joined.back() += "=" + arguments[++i];
    if (!is_number(arguments[i])) continue;
    while (i + 1 < arguments.size() && is_number(arguments[i + 1])) joined.back() += " " + arguments[++i];
  }
  return joined;
}

std::string full_name(const CLI::App& app) {
  return app.get_parent() ? full_name(*app.get_parent()) + " " + app.get_name() : app.get_name();
}

void refuse_leftovers(const CLI::App& app) {
  std::vector<std::string> leftovers = app.remaining();
  leftovers.erase(std::remove(leftovers.begin(), leftovers.end(), "--"), leftovers.end());
  if (leftovers.empty()) return;
  // An unknown flag's value is left over, too: the flag is the mistake to name.
  auto first = std::find_if(leftovers.begin(), leftovers.end(),
                            [](const std::string& text) { return text.size() > 1 && text[0] == '-'; });
  const bool is_flag = first != leftovers.end();
  if (!is_flag) first = leftovers.begin();
  const std::string given = first->substr(0, first->find('='));

  std::vector<std::string> known;
  if (is_flag) {
    for (const CLI::Option* option : app.get_options()) {
      for (const std::string& name : option->get_lnames()) known.push_back(name);
    }
  } else {
    for (const CLI::App* subcommand : app.get_subcommands({})) known.push_back(subcommand->get_name());
  }
  const bool wants_subcommand = !is_flag && !known.empty();
  std::string message = is_flag            ? "unknown option '"
                        : wants_subcommand ? "unknown subcommand '"
                                           : "one argument too many: '";
  message += given + "'";
  std::string nearest;
  if (!is_flag) {
    nearest = nearest_name(given, known);
  } else if (given[1] == '-') {  // one letter is too little to guess from
    nearest = nearest_name(given.substr(2), known);
    if (!nearest.empty()) nearest.insert(0, "--");
  }
  if (!nearest.empty()) message += "; did you mean '" + nearest + "'?";
  throw UsageError(message + (nearest.empty() ? "; see '" : " See '") + full_name(app) + " --help'");
}

}  // namespace handhold
