// The header of a PCD file, checked against the file's size before anybody allocates or reads what it promises.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace handhold::io {

struct PcdField {
  std::string name;        ///< "_" is padding
  std::size_t size = 4;    ///< bytes of one value: 1, 2, 4 or 8
  char type = 'F';         ///< I, U or F
  std::size_t count = 1;   ///< values a point
  std::size_t offset = 0;  ///< bytes from the start of a point
  std::size_t value = 0;   ///< values before it in a line of ascii data
};

enum class PcdData { kAscii, kBinary, kBinaryCompressed };

struct PcdHeader {
  std::vector<PcdField> fields;
  std::size_t width = 0, height = 0, points = 0;  ///< points == width * height
  std::size_t point_step = 0;                     ///< bytes of a point, padding included
  std::size_t values = 0;                         ///< values of a point: sum of the fields' counts
  std::array<double, 3> origin{0, 0, 0};          ///< of VIEWPOINT (m)
  PcdData data = PcdData::kAscii;
  std::size_t data_offset = 0;  ///< first byte after the header

  const PcdField* find(std::string_view name) const;
};

/// Whether the bytes begin like a PCD file.
bool looks_like_pcd(std::string_view bytes);

/// Reads the header in the first bytes of a PCD file and checks that it is complete and consistent, and that x, y and z
/// are floating point. `path` is for messages.
/// @throws IoError
PcdHeader parse_pcd_header(std::string_view bytes, const std::string& path);

/// Checks that the data after the header are all there and well formed: every line and number of ascii data, the length
/// of binary data, the whole LZF stream of binary_compressed data.
/// @throws IoError
void check_pcd_data(const PcdHeader& header, std::string_view bytes, const std::string& path);

}  // namespace handhold::io
