// The localizer of a program that a person runs: on what, and what that person is told about it.
#pragma once

#include <string>

#include "handhold/localizer.h"
#include "option_arguments.h"

namespace handhold {

/// @throws UsageError that names the flag or the file by which a backend was asked for that cannot be had
Localizer make_localizer(const OptionArguments& a, const Options& options);

/// One line on standard error where "auto" became the CPU, otherwise nothing.
void note_backend(const Localizer& localizer);

/// What frames run on, in a line for --explain; empty for the CPU that was asked for.
std::string backend_line(const Localizer& localizer);

/// "cuda: NVIDIA H200", or why there is none.
std::string device_line();

}  // namespace handhold
