// How likely a candidate is a part that a hand can hold: a logistic model of what was measured about it.
#pragma once

#include <array>
#include <cstddef>

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
  double strap = 0;                        ///< 1: found and measured by its outline
  double axis_spread = 0;                  ///< mean sine of the members' axes to this one
};

constexpr std::size_t kFeatures = 39;
constexpr int kUnfreeFeature = 5;  ///< the one that grows as `free` falls
/// The model's inputs, of about unit size.
std::array<double, kFeatures> features(const Evidence& evidence);
/// 0..1
double confidence(const Evidence& evidence);

}  // namespace handhold
