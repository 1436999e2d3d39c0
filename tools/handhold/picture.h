// What was found, drawn over the cloud: a PNG, made without a display.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/result.h"

namespace handhold {

/// A line in space, in the colour of a handle.
struct PictureLine {
  std::vector<Vector3> points;  ///< m; cloud's frame; at least two
  std::size_t handle = 0;       ///< index into Result::handles
};

struct PictureOptions {
  /// px; 0: the organized cloud's size (times a whole number when that is below 640 x 480), 1280 x 960 for others; one
  /// of the two alone keeps the shape.
  int width = 0, height = 0;
  bool affordances = true;              ///< the axis of each, cyan
  bool labels = true;                   ///< numbers of the handles (index + 1), and the legend at the bottom
  std::vector<Sample> samples = {};     ///< a dot each, coloured by the step at which it ended
  std::vector<PictureLine> lines = {};  ///< over the handles
};

/// Draws the cloud as its sensor saw it, and the affordances and handles of `result` over it. An organized cloud keeps
/// its pixels; another one, or one without a pinhole projection, is seen in perspective from its viewpoint (or from
/// outside, when there is none). Handles are outlined as cylinders, fainter where the surface hides them. The same
/// input gives the same bytes. Atomic: `path` has the old file or the whole new one.
/// rgb: 0x00RRGGBB for each point, or empty: shaded by depth then. Without finite points the picture says so.
/// @throws std::invalid_argument for a size below 0 or above 16384 px, or when rgb has neither 0 nor cloud.size()
/// entries
/// @throws std::runtime_error when the file cannot be written
void write_picture(const std::string& path, const CloudView& cloud, const std::vector<std::uint32_t>& rgb,
                   const Result& result, const PictureOptions& options = {});

}  // namespace handhold
