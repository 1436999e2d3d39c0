// Depth frames from OpenNI2: its recordings and its cameras.
#pragma once

#include <memory>
#include <string>

#include "frame_source.h"

namespace handhold::stream {

/// Plays a recording (.oni), as fast as frames are asked for. @throws UsageError: built without OpenNI2,
/// std::runtime_error: it cannot be played
std::unique_ptr<FrameSource> open_recording(const std::string& path);

/// The device of this URI; empty: the first one found. @throws as above
std::unique_ptr<FrameSource> open_device(const std::string& uri);

}  // namespace handhold::stream
