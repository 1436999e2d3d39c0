// Options from and to text: TOML files and single values. In a target of its own (handhold::config), so that the core
// needs no TOML library.
#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "handhold/options.h"

namespace handhold {

/// A configuration that cannot be used. what() is one line: what is wrong, in which file and line, what would be right.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Line in which each key of a configuration stands, counted from 1; a key that is missing left its option alone.
using ConfigLines = std::map<std::string, int>;

/// Sets every option that the TOML text names, `name = value` on the top level (no tables); the others keep their
/// values. An option that may be unset takes the string "default" for that; a list takes a single number, too. A seed
/// above 2^63 - 1, which is no TOML integer, is a string. Values are checked for their type here, for their range by
/// Options::validate(): only all options together, with those from other sources, can be judged.
/// @param source  name of the text in messages, usually the path
/// @throws ConfigError for text that is no TOML, an unknown key (with the nearest known one), a value of a wrong type;
///         `options` is unchanged then
ConfigLines apply_toml(Options& options, std::string_view text, const std::string& source);
/// The same from a file. @throws ConfigError also when the file cannot be read
ConfigLines apply_toml_file(Options& options, const std::string& path);

/// The defaults with a file's values, validated.
/// @throws ConfigError
Options read_options(const std::string& path);

/// Every option with its unit and meaning as TOML that apply_toml reads back to the same options, bit for bit.
std::string to_toml(const Options& options);

/// Sets one option from text, as command lines and parameter servers have it: "0.08", "max", "0.015 0.025" (several
/// numbers: blanks or commas between them), "default" for an option that may be unset.
/// @throws OptionError for an unknown name, or a text that is no value of the option's type (the range is not checked)
void set_option(Options& options, std::string_view name, std::string_view text);

/// Names of all options, in the order of the struct.
std::vector<std::string> option_names();

/// The candidate with the least edit distance to `name`, for "did you mean"; empty when none is near enough to be
/// meant.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

/// The numbers of a text, blanks or commas between them; locale and rounding do not matter.
/// @throws OptionError naming `name` when something in it is not a finite number, or nothing is in it
std::vector<double> parse_numbers(std::string_view name, std::string_view text);

}  // namespace handhold
