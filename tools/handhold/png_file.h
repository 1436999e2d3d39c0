// A canvas as a PNG file.
#pragma once

#include <string>

#include "canvas.h"

namespace handhold {

/// Atomic: `path` has the old file or the whole new one. @throws std::runtime_error when it cannot be written
void write_png(const std::string& path, const Canvas& canvas);

}  // namespace handhold
