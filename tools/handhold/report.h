// What a person reads on the terminal.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

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

/// One step of the funnel in words.
struct StepCount {
  const char* name;  ///< of the Funnel's count
  std::int64_t count;
  std::string what;      ///< completes "N samples ..."
  std::string settings;  ///< the options that decided it, with their values
  std::string advice;    ///< what would change it
};
/// What ended samples, in the order of the steps.
std::vector<StepCount> sample_steps(const Options& options, const Funnel& funnel);
/// What ended affordances.
std::vector<StepCount> affordance_steps(const Options& options, const Funnel& funnel);

/// The funnel in words: which step ended how many samples, and which option would change that for the biggest losers.
std::string explanation(const Options& options, const Result& result);

}  // namespace handhold
