// What a person reads on the terminal.
#pragma once

#include <string>

#include "handhold/options.h"
#include "handhold/result.h"
#include "run_times.h"

namespace handhold {

/// The handles as a table in millimetres, best confidence first.
/// @param source  name of the cloud
/// @param times   null: no times
std::string summary_table(const std::string& source, const Result& result, const RunTimes* times);

/// Medians and 99th percentiles of every stage.
std::string times_table(const RunTimes& times);

/// The funnel in words: which step ended how many samples, and which option would change that for the biggest losers.
std::string explanation(const Options& options, const Result& result);

}  // namespace handhold
