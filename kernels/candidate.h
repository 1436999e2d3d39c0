// What becomes of a fitted neighbourhood by the paper's method: plain double arithmetic without fused operations, whose
// bits are the same on a CPU and on a GPU.
#pragma once

#include <cmath>
#include <cstdint>

#include "kernels.h"

#if defined(__CUDACC__)
#define HANDHOLD_SHARED __host__ __device__ inline
#else
// Each instruction set has its own copy: a shared one would be whichever the linker picks.
#define HANDHOLD_SHARED inline __attribute__((always_inline))
#endif

namespace handhold::kernels {

/// Standard deviation of depth at distance z of a structured-light camera (m).
HANDHOLD_SHARED double depth_noise(double z) {
  const double d = z - 0.4 > 0 ? z - 0.4 : 0;
  return 0.0008 + 0.0019 * d * d;
}

/// Where a sample ended: the numbers of handhold::Step.
enum End : std::uint8_t {
  kEndTooFewPoints = 0,
  kEndFlat = 1,
  kEndCurvatureLow = 2,
  kEndCircleWide = 4,
  kEndCircleNarrow = 5,
  kEndNoGap = 7,
  kEndShellEmpty = 8,
  kEndAffordance = 9,
};

/// What a fit must show, and where the sensor stood.
struct FitLimits {
  double radius;           ///< m; of the ball
  double least_curvature;  ///< 1/radius; median of the largest curvature
  double widest;           ///< m; diameter of the circle at most
  double narrowest;        ///< m; its diameter times `slack` at least
  double slack;
  double viewpoint[3];     ///< m
  std::int32_t seen_from;  ///< 0: there is no viewpoint
};

/// Where a fit ends, kEndAffordance: not here. circle_radius: m
HANDHOLD_SHARED End judge_fit(const FitLimits& limits, bool flat, double kappa_median, double circle_radius) {
  if (flat) return kEndFlat;
  if (!(kappa_median >= limits.least_curvature)) return kEndCurvatureLow;
  if (!(2 * circle_radius <= limits.widest)) return kEndCircleWide;
  if (2 * circle_radius * limits.slack < limits.narrowest) return kEndCircleNarrow;
  return kEndAffordance;
}

/// A cylinder in the frame of the cloud.
struct Place {
  double center[3];  ///< m; point of the axis at the sample's height
  double axis[3];    ///< unit; largest component positive
  double normal[3];  ///< unit; towards the sensor, or away from the axis
};

HANDHOLD_SHARED double dot3(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
/// Unit vector, or z where there is no direction.
HANDHOLD_SHARED void normalize3(double* a) {
  const double n = sqrt(dot3(a, a));
  if (!(n > 0)) {
    a[0] = a[1] = 0, a[2] = 1;
    return;
  }
  const double inverse = 1 / n;
  for (int k = 0; k < 3; ++k) a[k] = inverse * a[k];
}

/// From the frame and the unit of the moments. position: m, of the sample; `circle_centre`, `axis` and `normal`: of a
/// FitBatch's lane.
HANDHOLD_SHARED Place place_fit(const FitLimits& limits, const double* position, const double* R_frame_cloud,
                                const double* circle_centre, const double* axis, const double* normal) {
  Place p;
  for (int i = 0; i < 3; ++i) {
    double c = 0, a = 0, n = 0;
    for (int j = 0; j < 3; ++j) {
      const double r = R_frame_cloud[3 * j + i];
      c += r * circle_centre[j], a += r * axis[j], n += r * normal[j];
    }
    p.center[i] = position[i] + limits.radius * c;
    p.axis[i] = a, p.normal[i] = n;
  }
  normalize3(p.axis);
  int largest = 0;
  for (int k = 1; k < 3; ++k) {
    if (fabs(p.axis[k]) > fabs(p.axis[largest])) largest = k;
  }
  if (p.axis[largest] < 0) {
    for (int k = 0; k < 3; ++k) p.axis[k] = -1.0 * p.axis[k];
  }
  normalize3(p.normal);
  double outward[3];
  for (int k = 0; k < 3; ++k)
    outward[k] = limits.seen_from ? limits.viewpoint[k] - position[k] : position[k] - p.center[k];
  if (dot3(p.normal, outward) < 0) {
    for (int k = 0; k < 3; ++k) p.normal[k] = -1.0 * p.normal[k];
  }
  return p;
}

/// What the paper's shell must be like. Areas are turned into numbers of points by the local density.
struct ShellLimits {
  double aperture;    ///< m
  double half_width;  ///< m
  double gap;         ///< m
  double gap_area;    ///< mm^2 of surface that may lie in the gap
  double inner_area;  ///< mm^2 that must lie within
};

/// Points per square metre of a surface through a ball.
HANDHOLD_SHARED double ball_density(std::int32_t points, double radius) {
  return static_cast<double>(points) / (3.14159265358979323846 * radius * radius);
}

/// density: points per m^2; circle_radius: m
HANDHOLD_SHARED ShellQuery shell_query(const ShellLimits& limits, const FitLimits& fit, const double* position,
                                       const Place& place, double circle_radius, double density) {
  double z = 0;
  if (fit.seen_from) {
    double away[3];
    for (int k = 0; k < 3; ++k) away[k] = position[k] - fit.viewpoint[k];
    z = sqrt(dot3(away, away));
  }
  // Noise may carry single points of the part beyond its own radius.
  // Far away the noise of such a camera would swallow what stands beside the part: it counts up to a tenth of the hand.
  const double noise = 2 * depth_noise(z), most = 0.1 * limits.aperture;
  const double largest = limits.aperture / 2 + (most < noise ? most : noise) + 0.002;
  const double gap_points = floor(limits.gap_area * 1e-6 * density),
               inner_points = ceil(limits.inner_area * 1e-6 * density);
  ShellQuery q;
  for (int k = 0; k < 3; ++k) {
    q.centre[k] = static_cast<float>(place.center[k]);
    q.axis[k] = static_cast<float>(place.axis[k]);
  }
  q.half_width = static_cast<float>(limits.half_width);
  q.start_radius = static_cast<float>(0.7 * circle_radius);
  q.max_radius = static_cast<float>(largest);
  q.gap = static_cast<float>(limits.gap);
  q.max_gap_points = static_cast<std::int32_t>(gap_points < 1e9 ? gap_points : 1e9);
  const auto inner = static_cast<std::int32_t>(inner_points < 1e9 ? inner_points : 1e9);
  q.min_inner_points = inner > 1 ? inner : 1;
  return q;
}

HANDHOLD_SHARED End end_of_shell(const ShellResult& r) {
  return r.status == kShellFound ? kEndAffordance : r.status == kShellEmpty ? kEndShellEmpty : kEndNoGap;
}

}  // namespace handhold::kernels
