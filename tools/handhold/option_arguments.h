// The localizer's options as a command line gives them.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "command_line.h"
#include "handhold/options.h"

namespace handhold {

/// What the user gave.
struct OptionArguments {
  OptionTexts texts;  ///< of the flags
  std::string config, hand;
};

/// Adds --config and --hand; what the user gives ends in `a`, which must outlive the parsing.
void add_preset_flags(CLI::App& app, OptionArguments& a, const std::string& group);

/// `defaults` < --hand < --config < flags. @throws UsageError, OptionError or ConfigError that names what is wrong, and
/// where it was set
Options effective_options(const OptionArguments& a, const Options& defaults = {});

}  // namespace handhold
