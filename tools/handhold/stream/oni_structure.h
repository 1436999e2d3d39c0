// What an OpenNI2 recording (.oni) is made of.
#pragma once

#include <cstddef>
#include <string>

namespace handhold::stream {

struct OniStructure {
  std::size_t depth_frames = 0;  ///< whole ones
  bool complete = false;         ///< its end mark is there
};

/// Looks at every record of the file, but not into its images: OpenNI2's player takes sizes from damaged files as they
/// stand and reads past their ends, and waits for ever for what was cut off.
/// @throws std::runtime_error: no such file, no recording, or damaged; one line
OniStructure check_oni(const std::string& path);

}  // namespace handhold::stream
