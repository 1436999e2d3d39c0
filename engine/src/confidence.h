// How likely a candidate is a part that a hand can hold: boosted trees over what was measured about it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "silhouette.h"

namespace handhold {

/// What was measured about a candidate for a handle.
struct Evidence {
  double length = 0;         ///< m
  double radius = 0;         ///< m
  double sigma = 0;          ///< m; standard deviation of depth at this distance
  double arc = 0;            ///< rad; angle about the axis within which points lie
  double residual = 0;       ///< m; root mean square distance of the points from the cylinder
  double free = 0;           ///< 0..1; share of the fingers' volumes that was seen empty
  double normal_error = 0;   ///< rad; mean angle between the points' normals and the cylinder's; 0: not measured
  double members = 0;        ///< affordances
  double corner_gain = 0;    ///< log of (rms distance from two planes over that from the cylinder): < 0 at a box's edge
  double inner = 0;          ///< points within the cylinder, which a solid would hide, over points on it
  double outer = 0;          ///< points close outside it, where it faces the sensor, over points on it
  double bend = 0;           ///< m; root mean square offset of the slices' middles across the line of sight
  double waviness = 0;       ///< m; root mean square deviation of the slices' radii from a line
  double radius_spread = 0;  ///< of the members over the radius
  // Beside it, as the sensor sees it (silhouette.h):
  double steps_less = 0, steps_more = 0;   ///< 0..1; share of its length that ends at a step, on either side
  double nearer_end = 1, farther_end = 1;  ///< where it ends on either side, over the radius
  /// m; how far behind its edges lies what is seen one pixel, 4 mm and 12 mm beyond them, on either side
  std::array<double, kLooksBeyond> fall_less{}, fall_more{};
  double followed = 0, turn = 0;  ///< m and rad; how far its outline was followed (bow.h), and how much that turns
  double off_middle = 0, off_direction = 0;  ///< m and rad; from the middle of what was followed, and the tangent there
  double strap = 0;                          ///< 1: found and measured by its outline
  double axis_spread = 0;                    ///< mean sine of the members' axes to this one
};

constexpr std::size_t kFeatures = 37;
constexpr int kUnfreeFeature = 4;  ///< the one that grows as `free` falls
/// The model's inputs.
std::array<double, kFeatures> features(const Evidence& evidence);

/// A tree of three levels of questions: `feature` above `threshold`? Question k is followed by 2 k + 1 (no) and 2 k + 2
/// (yes), the last ones by the values: log odds, summed over the model's trees.
constexpr std::size_t kConfidenceSplits = 7;
struct ConfidenceTree {
  std::array<std::uint8_t, kConfidenceSplits> feature;
  std::array<float, kConfidenceSplits> threshold;
  std::array<float, kConfidenceSplits + 1> value;

  double operator()(const std::array<double, kFeatures>& x) const {
    std::size_t k = 0;
    while (k < kConfidenceSplits) k = 2 * k + 1 + (x[feature[k]] > static_cast<double>(threshold[k]) ? 1 : 0);
    return static_cast<double>(value[k - kConfidenceSplits]);
  }
};

/// 0..1
double confidence(const Evidence& evidence);

}  // namespace handhold
