// Follows a thin part along its outline, also around bends: the bow of a basket, the handle of a mug.
#pragma once

#include <cstddef>
#include <vector>

#include "cylinder.h"
#include "depth_image.h"
#include "vec3.h"

namespace handhold {

/// What was followed. `path` has one place every kBowStep on the part's side towards the sensor, half way between the
/// two sides that it shows.
struct Bow {
  std::vector<Vector3> path;   ///< m
  std::vector<double> widths;  ///< m; across the path, at each place
  double length = 0;           ///< m; along the path
  double turn = 0;             ///< rad; between the directions at its two ends, all turns counted
  bool closed = false;         ///< it ends where it began

  void clear() { path.clear(), widths.clear(), length = turn = 0, closed = false; }
  /// Whether it bends everywhere: no stretch of 60 mm is straight to 0.2 rad.
  bool curved() const;
  /// Whether it comes nearer to itself than `width` (m): the tracing went round in a blob, not along a part.
  bool tangled(double width) const;
  /// Unit; at a place.
  Vector3 tangent(std::size_t i) const;
};

/// What following takes, kept from one part to the next.
struct BowScratch {
  /// On the side towards the sensor, and the width there (m).
  struct Place {
    Vector3 at{};
    double width = 0;
  };
  std::vector<Place> back, forth;
  std::vector<Vector3> smooth;
};

/// The place of a path that is nearest to a point; of equally near ones the first.
std::size_t nearest_place(const std::vector<Vector3>& path, const Vector3& p);

inline constexpr double kBowStep = 0.005;  ///< m

/// Follows the part that `start` lies on, both ways, as long as the depth image steps away on both sides and its width
/// stays. False: there is none. `sigma`: standard deviation of depth there (m).
bool trace_bow(const DepthImage& image, const Cylinder& start, double sigma, BowScratch& scratch, Bow& bow);

}  // namespace handhold
