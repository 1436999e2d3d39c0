// Whether a search can run on the GPU: of the engine's own, beside the public handhold/device.h.
#pragma once

#include <string>

#include "handhold/device.h"
#include "handhold/options.h"

namespace handhold {

/// Empty when a localizer with these options can run on the GPU; otherwise why not, in one line without a full stop.
/// Where there is no device, what cuda_device().reason says. Does not look at Options::backend.
std::string why_not_on_device(const Options& options);

}  // namespace handhold
