// The machine-readable form of a result.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "handhold/cloud.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "run_times.h"

namespace handhold {

/// A handle by the names of the result.
nlohmann::ordered_json handle_json(const Handle& handle);

/// One line for every member, and for every element of its arrays: short, and still a text that a person or `diff` can
/// read. Ends in a newline.
std::string to_lines(const nlohmann::ordered_json& json);

/// JSON of schema "handhold/1", ending in a newline. Numbers are the shortest that read back to the same bits; what is
/// unset is null. Without times the text has nothing in it that a second run, or another number of threads, would
/// change: neither times nor `options.threads`.
/// @param backend  what it was searched on
/// @param times    null: no times
std::string to_json(const CloudView& cloud, const Options& options, Backend backend, const Result& result,
                    const RunTimes* times);

}  // namespace handhold
