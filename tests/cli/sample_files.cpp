#include "sample_files.h"

#include <png.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <stdexcept>

namespace handhold::test {
namespace {

std::string pcd_header(std::size_t points, const char* data) {
  std::ostringstream header;
  header << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 "
            "1\nWIDTH "
         << points << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << points << "\nDATA " << data << "\n";
  return header.str();
}

std::string lines(const Points& points) {
  std::ostringstream text;
  text.precision(9);
  for (const auto& p : points) text << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  return text.str();
}

}  // namespace

Points cylinder() {
  Points points;
  for (double y = -0.075; y <= 0.075; y += 0.001) {
    for (double angle = -1.5; angle <= 1.5; angle += 0.001 / kCylinderRadius) {
      points.push_back({static_cast<float>(kCylinderCenter[0] + kCylinderRadius * std::sin(angle)),
                        static_cast<float>(y),
                        static_cast<float>(kCylinderCenter[2] - kCylinderRadius * std::cos(angle))});
    }
  }
  return points;
}

std::string binary_pcd(const Points& points) {
  std::string bytes(points.size() * 12, '\0');
  if (!points.empty()) std::memcpy(bytes.data(), points.data(), bytes.size());
  return pcd_header(points.size(), "binary") + bytes;
}

std::string ascii_pcd(const Points& points) {
  return pcd_header(points.size(), "ascii") + lines(points);
}

std::string ascii_ply(const Points& points) {
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(points.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\nend_header\n" + lines(points);
}

DepthImage depth_image(double x) {
  DepthImage image;
  image.values.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 0);
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      // Ray (dx, dy, 1) meets the cylinder about the line through x, z = 0.7: (t dx - x)^2 + (t - 0.7)^2 = r^2.
      const double dx = (u - 79.5) / 300, dy = (v - 59.5) / 300;
      const double a = dx * dx + 1, b = -0.7 - dx * x, c = 0.49 + x * x - kCylinderRadius * kCylinderRadius;
      const double discriminant = b * b - a * c;
      if (discriminant < 0) continue;
      const double z = (-b - std::sqrt(discriminant)) / a;
      if (std::abs(z * dy) > 0.075) continue;
      image.values[static_cast<std::size_t>(v * image.width + u)] = static_cast<std::uint16_t>(std::lround(z * 1000));
    }
  }
  return image;
}

std::string png(const DepthImage& depth) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(depth.width);
  image.height = static_cast<png_uint_32>(depth.height);
  image.format = PNG_FORMAT_LINEAR_Y;  // 16 bits
  png_alloc_size_t size = 0;
  std::string bytes(1 << 20, '\0');
  size = bytes.size();
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, depth.values.data(), 0, nullptr)) {
    throw std::runtime_error(image.message);
  }
  bytes.resize(size);
  return bytes;
}

std::string depth_png() {
  return png(depth_image());
}

}  // namespace handhold::test
