// Options from and to TOML. In a target of its own (handhold::config), so that the core needs no TOML library; single
// values are set by option_text.h.
#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

#include "handhold/option_text.h"
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
/// @param options  changed in place
/// @param text  TOML
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

}  // namespace handhold
