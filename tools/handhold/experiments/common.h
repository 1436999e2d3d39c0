// What the experiments share: flags, outputs, tables.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command_line.h"
#include "handhold/options.h"
#include "plot.h"
#include "usage_error.h"

namespace handhold::experiments {

using Json = nlohmann::ordered_json;

/// What the user gave to the flags that every experiment has.
struct CommonArguments {
  std::string threads, seed, runs;
  std::string folder, csv, json, plot;
};

/// @param runs  what one run is, with the default: "Runs of each scene and strategy [20]"
void add_common_flags(CLI::App& app, CommonArguments& a, const std::string& runs);

/// Adds the flag --method, with this default in its help.
void add_method_flag(CLI::App& app, std::string& target, const std::string& standard);

/// Sets an enum of Options by its name; an empty text leaves it. @throws UsageError listing the names
template <class E>
void set_name(const std::string& flag, const std::string& text, E& target) {
  if (text.empty()) return;
  try {
    from_string(text, target);
  } catch (const OptionError& error) {
    throw UsageError(with_flag(flag.substr(2), error.what()));
  }
}

int threads_of(const CommonArguments& a);
std::uint64_t seed_of(const CommonArguments& a);
int runs_of(const CommonArguments& a, int standard);

/// What an experiment found.
struct Report {
  std::string text;  ///< a table for a person
  std::string csv;
  Json json;
  std::vector<PlotPanel> panels;
  int columns = 1;  ///< of panels
};

/// Where it goes. Paths that cannot work are refused by the constructor, before anything is computed.
class Outputs {
 public:
  /// -o FOLDER makes FOLDER/NAME.csv, .json and .png; --csv, --json and --plot win over it.
  /// @throws UsageError, std::runtime_error naming the flag or the path
  Outputs(const CommonArguments& a, const std::string& name);
  /// Writes the files, and the table to standard output (to standard error when that gets the JSON).
  void write(const Report& report) const;

 private:
  std::string csv_, json_, plot_;  ///< empty: not written
};

}  // namespace handhold::experiments
