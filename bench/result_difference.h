// How far two searches of one cloud differ. They are to be the same to the bit.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "handhold/result.h"

namespace handhold::bench {

struct Difference {
  std::int64_t places = 0;       ///< samples that lie elsewhere
  std::int64_t steps = 0;        ///< samples that ended at another step
  std::int64_t affordances = 0;  ///< samples with an affordance that only one of them has, or that differs in any bit
  std::int64_t handles = 0;      ///< handles that only one of them has in that place of the list, or that differ
  double centre = 0;             ///< m; between affordances of one sample, at most
  double axis = 0;               ///< rad; likewise

  bool none() const { return places + steps + affordances + handles == 0; }
  /// Of both together.
  void add(const Difference& d) {
    places += d.places, steps += d.steps, affordances += d.affordances, handles += d.handles;
    centre = std::max(centre, d.centre), axis = std::max(axis, d.axis);
  }
};

/// What a search found, with its samples (Localizer::samples).
struct Outcome {
  Result result;
  std::vector<Sample> samples;
};

inline bool same_bits(const Vector3& a, const Vector3& b) {
  return std::memcmp(a.data(), b.data(), sizeof a) == 0;
}
inline bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}
inline bool same_bits(const Affordance& a, const Affordance& b) {
  return same_bits(a.center, b.center) && same_bits(a.axis, b.axis) && same_bits(a.normal, b.normal) &&
         same_bits(a.radius, b.radius) && same_bits(a.shell_radius, b.shell_radius) && same_bits(a.gap, b.gap) &&
         same_bits(a.curvature, b.curvature) && same_bits(a.neighbourhood, b.neighbourhood) && a.sample == b.sample;
}
inline bool same_bits(const Handle& a, const Handle& b) {
  return same_bits(a.center, b.center) && same_bits(a.axis, b.axis) && same_bits(a.approach, b.approach) &&
         same_bits(a.radius, b.radius) && same_bits(a.length, b.length) && same_bits(a.confidence, b.confidence) &&
         a.affordances == b.affordances;
}

inline double distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}
/// Between two lines (rad).
inline double angle(const Vector3& a, const Vector3& b) {
  const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  return std::atan2(std::hypot(x, y, z), std::fabs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]));
}

inline std::int64_t gap(std::size_t a, std::size_t b) {
  return static_cast<std::int64_t>(a > b ? a - b : b - a);
}

/// Affordances are in the order of their samples in both.
inline Difference difference(const Outcome& a, const Outcome& b) {
  Difference d;
  const std::size_t samples = std::min(a.samples.size(), b.samples.size());
  d.places = d.steps = gap(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < samples; ++i) {
    d.places += !same_bits(a.samples[i].position, b.samples[i].position);
    d.steps += a.samples[i].step != b.samples[i].step;
  }
  const std::vector<Affordance>&x = a.result.affordances, &y = b.result.affordances;
  for (std::size_t i = 0, j = 0; i < x.size() || j < y.size();) {
    if (i < x.size() && j < y.size() && x[i].sample == y[j].sample) {
      d.affordances += !same_bits(x[i], y[j]);
      d.centre = std::max(d.centre, distance(x[i].center, y[j].center));
      d.axis = std::max(d.axis, angle(x[i].axis, y[j].axis));
      ++i, ++j;
    } else {
      ++d.affordances;
      j == y.size() || (i < x.size() && x[i].sample < y[j].sample) ? ++i : ++j;
    }
  }
  const std::vector<Handle>&g = a.result.handles, &h = b.result.handles;
  d.handles = gap(g.size(), h.size());
  for (std::size_t i = 0; i < std::min(g.size(), h.size()); ++i) d.handles += !same_bits(g[i], h[i]);
  return d;
}

}  // namespace handhold::bench
