// One case of an evaluation as a picture: the whole view, the place enlarged, and the cause in words.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/result.h"

namespace handhold {

/// A part of the truth to draw.
struct TruthMark {
  std::vector<Vector3> centre_line;  ///< m; at least two points
  double radius = 0;                 ///< m
  bool subject = false;              ///< what the picture is about: magenta; others: white
};

struct CasePicture {
  std::vector<TruthMark> parts;
  std::optional<std::size_t> handle;  ///< the handle that the picture is about: red; others keep their colours
  Vector3 focus = {0, 0, 0};          ///< m; middle of the enlarged place
  double extent = 0.1;                ///< m, > 0; what is around the focus in the enlarged place, at least
  std::string caption;                ///< printable ASCII; wrapped
};

/// Atomic; the same input gives the same bytes. Affordances are drawn, too, as `handhold localize --picture` does.
/// @throws std::runtime_error when the file cannot be written
void write_case_picture(const std::string& path, const CloudView& cloud, const std::vector<std::uint32_t>& rgb,
                        const Result& result, const CasePicture& picture);

}  // namespace handhold
