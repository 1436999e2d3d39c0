#include <pcl/io/lzf.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>

#include "file.h"
#include "handhold/io.h"
#include "readers.h"

namespace handhold {
namespace {

// One field after the other, as the format has it: equal bytes stand together and compress better.
std::string field_by_field(const CloudView& cloud, const std::vector<std::uint32_t>& rgb) {
  const std::size_t points = cloud.size();
  std::string bytes(points * (rgb.empty() ? 12 : 16), '\0');
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < points; ++i) std::memcpy(&bytes[4 * (k * points + i)], cloud.point(i) + k, 4);
  }
  if (!rgb.empty()) std::memcpy(&bytes[12 * points], rgb.data(), 4 * points);
  return bytes;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", std::isfinite(value) ? value : 0.0);
  return text;
}

std::string header(const CloudView& cloud, bool colored) {
  const Vector3 origin = cloud.viewpoint.value_or(Vector3{0, 0, 0});
  const std::string one = colored ? " 1 1 1 1" : " 1 1 1", four = colored ? " 4 4 4 4" : " 4 4 4";
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z" + std::string(colored ? " rgb" : "") +
         "\nSIZE" + four + "\nTYPE F F F" + (colored ? " U" : "") + "\nCOUNT" + one + "\nWIDTH " +
         std::to_string(cloud.width) + "\nHEIGHT " + std::to_string(cloud.height) + "\nVIEWPOINT " + number(origin[0]) +
         " " + number(origin[1]) + " " + number(origin[2]) + " 1 0 0 0\nPOINTS " + std::to_string(cloud.size()) +
         "\nDATA binary_compressed\n";
}

}  // namespace

void write_pcd(const std::string& path, const CloudView& cloud, const std::vector<std::uint32_t>& rgb) {
  if (!rgb.empty() && rgb.size() != cloud.size()) {
    throw std::invalid_argument("write_pcd: " + std::to_string(rgb.size()) + " colours for " +
                                std::to_string(cloud.size()) + " points: one for each point, or none, is needed");
  }
  const std::string plain = field_by_field(cloud, rgb);
  std::uint32_t sizes[2] = {0, 0};  // compressed, uncompressed
  // LZF's worst case is 33 bytes for 32.
  const std::size_t room = plain.size() + plain.size() / 32 + 16;
  if (room > std::numeric_limits<std::uint32_t>::max()) {
    throw IoError("cannot write " + path + ": " + std::to_string(cloud.size()) +
                  " points are more than a compressed PCD can hold; write fewer");
  }
  std::string body(8 + room, '\0');
  if (!plain.empty()) {
    const io::QuietPcl quiet;
    sizes[0] =
        pcl::lzfCompress(plain.data(), static_cast<unsigned>(plain.size()), &body[8], static_cast<unsigned>(room));
    sizes[1] = static_cast<std::uint32_t>(plain.size());
    if (sizes[0] == 0) throw IoError("cannot write " + path + ": PCL failed to compress it");
  }
  std::memcpy(&body[0], sizes, 8);
  body.resize(8 + sizes[0]);
  io::write_whole_file(path, header(cloud, !rgb.empty()), body);
}

}  // namespace handhold
