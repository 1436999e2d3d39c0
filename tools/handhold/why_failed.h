// What is wrong with a cloud that could not be searched.
#pragma once

#include <string>

#include "handhold/cloud.h"
#include "handhold/options.h"
#include "handhold/result.h"

namespace handhold {

/// Empty for a cloud that was searched, otherwise one line: what, where, what would be right.
std::string why_failed(const std::string& path, const CloudView& cloud, const Options& options, const Result& result);

}  // namespace handhold
