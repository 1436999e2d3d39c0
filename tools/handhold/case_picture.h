// One case of an evaluation as a picture: the whole view, the place enlarged, and the cause in words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/result.h"

namespace handhold {

class Painter;

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

/// Draws the cases of one scene: the whole view is rendered once.
class CasePainter {
 public:
  /// The cloud and the result must outlive this. rgb: 0x00RRGGBB for each point, or empty.
  CasePainter(const CloudView& cloud, const std::vector<std::uint32_t>& rgb, const Result& result);
  ~CasePainter();
  CasePainter(const CasePainter&) = delete;
  CasePainter& operator=(const CasePainter&) = delete;

  /// Atomic; the same input gives the same bytes. Affordances are drawn, too, as `handhold localize --picture` does.
  /// @throws std::runtime_error when the file cannot be written
  void write(const std::string& path, const CasePicture& picture) const;

 private:
  CloudView cloud_;
  const std::vector<std::uint32_t>& rgb_;
  const Result& result_;
  std::unique_ptr<Painter> whole_;
};

}  // namespace handhold
