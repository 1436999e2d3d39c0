// Whole files in and out, with errors that say what to do.
#pragma once

#include <cstddef>
#include <string>

namespace handhold::io {

/// Bytes of a regular file. Refuses what has no content to read: nothing there, a directory, a device, an empty file.
/// @throws IoError
std::size_t checked_file_size(const std::string& path);

/// The first `size` bytes of a file (all of it: checked_file_size()).
/// @throws IoError
std::string read_bytes(const std::string& path, std::size_t size);

/// Writes head and body to a new file beside `path` and renames it.
/// @throws IoError; the file that was there before is still there then
void write_whole_file(const std::string& path, const std::string& head, const std::string& body);

}  // namespace handhold::io
