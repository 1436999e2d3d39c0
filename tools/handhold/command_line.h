// What CLI11 does not do: a flag for every field of Options, lists that end before a file name, and "did you mean".
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "handhold/options.h"

namespace handhold {

/// Texts that the user gave to option flags, by the option's name (underscores); empty: not given.
using OptionTexts = std::map<std::string, std::string>;

/// Adds a flag that takes one text, the last one given; an empty text, or another flag in its place, is refused.
CLI::Option* add_text_flag(CLI::App& app, const std::string& flag, std::string& target, const std::string& value_name,
                           const std::string& help, const std::string& group);

/// Flag of an option: "hand_aperture" -> "--hand-aperture".
std::string flag_of(std::string_view option);

/// Adds one flag per field of Options; what the user gives ends in `texts`, which must outlive the parsing.
void add_option_flags(CLI::App& app, OptionTexts& texts);

/// Sets the options that were given. @throws UsageError naming the flag, the text and what would be right
void apply_option_texts(Options& options, const OptionTexts& texts);

/// A count or a seed that the user gave to a flag. @throws UsageError naming the flag, the text and the range
std::uint64_t whole_number(const std::string& flag, const std::string& text, std::uint64_t low, std::uint64_t high);

/// Several of them, commas or blanks between. @throws UsageError as above
std::vector<int> whole_numbers(const std::string& flag, const std::string& text, int low, int high);

/// Several numbers, commas or blanks between. @throws UsageError naming the flag, the text and the range
std::vector<double> numbers(const std::string& flag, const std::string& text, double low, double high,
                            const std::string& unit);

/// A message that begins with an option's name, about its flag: "radius = 0: ..." -> "--radius = 0: ...".
std::string with_flag(const std::string& option, const std::string& message);

/// Joins the numbers after a flag that takes several into one argument ("--radius", "0.01", "0.02" ->
/// "--radius=0.01 0.02"): otherwise the list would swallow the cloud's name that follows.
std::vector<std::string> join_lists(const std::vector<std::string>& arguments);

/// "handhold localize"
std::string full_name(const CLI::App& app);

/// @throws UsageError for the first argument that CLI11 could not place, with the nearest flag or subcommand.
void refuse_leftovers(const CLI::App& app);

}  // namespace handhold
