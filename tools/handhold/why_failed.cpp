#include "why_failed.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace handhold {
namespace {

/// Largest side of the box around the finite points (m).
double extent(const CloudView& cloud) {
  double side = 0;
  for (int axis = 0; axis < 3; ++axis) {
    float low = INFINITY, high = -INFINITY;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const float* p = cloud.point(i);
      if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) continue;
      low = std::min(low, p[axis]);
      high = std::max(high, p[axis]);
    }
    if (low <= high) side = std::max(side, static_cast<double>(high) - low);
  }
  return side;
}

}  // namespace

std::string why_failed(const std::string& path, const CloudView& cloud, const Options& options, const Result& result) {
  switch (result.status) {
    case Status::kOk:
    case Status::kDeadline:
      return {};
    case Status::kCancelled:
      break;
    case Status::kEmpty:
      return "'" + path + "' has no points; give a cloud with points";
    case Status::kNoFinitePoints:
      return "'" + path +
             "' has no finite point: in each, a coordinate is NaN or infinite; give a cloud with measured points";
    case Status::kTooFewPoints:
      if (options.workspace && static_cast<std::int64_t>(result.finite_points) >= options.min_neighbours) {
        return "'" + path + "' has " + std::to_string(result.finite_points) +
               " finite points, but none inside --workspace; give a box that holds some of them, in metres and in the "
               "cloud's frame";
      }
      return "'" + path + "' has only " + std::to_string(result.finite_points) +
             " finite points, fewer than one fit needs (" + std::to_string(options.min_neighbours) +
             "); give a denser cloud or lower --min-neighbours";
    case Status::kSuspiciousUnits: {
      char width[32];
      std::snprintf(width, sizeof width, "%.3g", extent(cloud) / 1000);
      return "'" + path + "' is " + width + " km wide, so its unit is probably the millimetre; convert it to metres";
    }
  }
  return "'" + path + "': " + std::string(to_string(result.status));
}

}  // namespace handhold
