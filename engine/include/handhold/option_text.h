// Single options from and to text, by name: for command lines, parameter servers and other languages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "handhold/options.h"

namespace handhold {

/// Sets one option from text, as command lines and parameter servers have it: "0.08", "max", "0.015 0.025" (several
/// numbers: blanks or commas between them), "default" for an option that may be unset and for a list that may be empty.
/// @throws OptionError for an unknown name, or a text that is no value of the option's type (the range is not checked:
///         Options::validate() judges all options together); `options` is unchanged then
void set_option(Options& options, std::string_view name, std::string_view text);

/// One option as text that set_option reads back to the same (finite) value, bit for bit.
/// @throws OptionError for an unknown name
std::string get_option(const Options& options, std::string_view name);

/// Names of all options, in the order of the struct.
std::vector<std::string> option_names();

/// The candidate with the least edit distance to `name`, for "did you mean"; empty when none is near enough to be
/// meant.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

/// The numbers of a text, blanks or commas between them; locale and rounding do not matter.
/// @throws OptionError naming `name` when something in it is not a finite number, or nothing is in it
std::vector<double> parse_numbers(std::string_view name, std::string_view text);

}  // namespace handhold
