// Clouds from and to files. In a target of its own (handhold::io), so that the core needs neither PCL nor libpng.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "handhold/cloud.h"

namespace handhold {

/// A file that cannot be read or written. what() is one line: what is wrong, in which file, what would be right.
class IoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Pinhole camera. Pixel (u, v) = (fx x/z + cx, fy y/z + cy); (0, 0) is the centre of the upper left pixel.
struct Intrinsics {
  double fx = 0, fy = 0;  ///< px; above 0
  double cx = 0, cy = 0;  ///< px
};

/// Reads a PCD file (ascii, binary, binary_compressed) or a PLY file (ascii, binary), organized or not. The content
/// decides which, not the name.
///
/// x, y, z are taken as they stand (metres are expected; doubles become floats); points that were not measured stay
/// NaN. Colours (rgb or rgba; red, green, blue in a PLY) are kept, other fields are ignored. The origin of a PCD's
/// VIEWPOINT becomes the viewpoint; its quaternion is ignored, because real files carry wrong ones. The same holds for
/// the camera of a PLY that PCL wrote, which also has the size of an organized cloud. Without either the viewpoint is
/// the origin. A file with zero points gives an empty cloud. Prints nothing. May be called from several threads (PCL's
/// part of the work is serialised).
/// @throws IoError when there is no such file, or it is damaged, truncated or of another kind
Cloud read_cloud(const std::string& path);

/// A depth image, rows of `width` values, as an organized cloud in the camera's optical frame (x right, y down, z
/// forward; metres; viewpoint at the origin). depth_unit_m: metres of one step of a pixel's value (0.001 when it holds
/// millimetres); a value of 0 is a missing measurement and becomes NaN.
Cloud cloud_of_depth(const std::vector<std::uint16_t>& values, std::uint32_t width, const Intrinsics& intrinsics,
                     double depth_unit_m);

/// Reads a depth image, a 16-bit gray PNG, as cloud_of_depth() does.
/// @throws IoError for a file that is no such PNG, and for fx, fy or depth_unit_m that are not above 0
Cloud read_depth_png(const std::string& path, const Intrinsics& intrinsics, double depth_unit_m);

/// Writes a binary_compressed PCD with fields x y z (float) and, when given, rgb. Atomic: a temporary file beside
/// `path` is renamed, so that a reader sees the old file or the whole new one. VIEWPOINT has the cloud's viewpoint and
/// no rotation; (0, 0, 0) when there is none. rgb: 0x00RRGGBB for each point, or empty.
/// @throws IoError when the file cannot be written
/// @throws std::invalid_argument when rgb has neither 0 nor cloud.size() entries
void write_pcd(const std::string& path, const CloudView& cloud, const std::vector<std::uint32_t>& rgb = {});

}  // namespace handhold
