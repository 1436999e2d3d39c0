// What the localizer found, why it did not find more, and how long each step took.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "handhold/cloud.h"

namespace handhold {

/// How a frame went. Everything but kOk and kDeadline means that there are no handles and says why.
enum class Status {
  kOk,               ///< the cloud was searched; there may still be no handles
  kEmpty,            ///< the cloud has no points
  kNoFinitePoints,   ///< every point has a coordinate that is NaN, infinite or beyond 1e6 m
  kTooFewPoints,     ///< fewer finite points than one fit needs (Options::min_neighbours), or none in the workspace
  kSuspiciousUnits,  ///< the cloud is over 100 m wide: probably millimetres
  kDeadline,         ///< Options::deadline_ms ended the search; what had been found by then is there
  kCancelled,        ///< Localizer::cancel() ended the search
};
/// "ok", "empty", "no_finite_points", "too_few_points", "suspicious_units", "deadline", "cancelled"
std::string_view to_string(Status);

/// One cylindrical shell that satisfies the conditions of an enveloping grasp (paper, section 3).
struct Affordance {
  Vector3 center;            ///< m; point of the axis at the sample's height
  Vector3 axis;              ///< unit; direction of least curvature; largest component positive
  Vector3 normal;            ///< unit; outward, towards the sensor's side
  double radius = 0;         ///< m; of the fitted circle
  double shell_radius = 0;   ///< m; inner radius of the shell found
  double gap = 0;            ///< m; free width found outside shell_radius, at least Options::finger_thickness
  double curvature = 0;      ///< 1/m; median of the largest absolute curvature over the neighbourhood
  double observed_free = 0;  ///< 0..1; share of the fingers' volumes that was seen empty; 0 where it was not looked at
  double quality = 1;        ///< 0..1; how well the points fit the cylinder (default method)
  double neighbourhood = 0;  ///< m; radius of the ball; 0: found by its outline in the depth image (default method)
  std::uint32_t sample = 0;  ///< index of the sample it came from
};

/// A contiguous run of aligned affordances: one graspable part.
struct Handle {
  Vector3 center;             ///< m; middle of the extent on the axis, or where `path` is best held
  Vector3 axis;               ///< unit; largest component positive
  Vector3 approach;           ///< unit; direction in which a hand moves towards the part
  double radius = 0;          ///< m
  double length = 0;          ///< m; extent along the axis
  double confidence = 0;      ///< 0..1; default method: probability that the handle is right, calibrated on simulated
                              ///< scenes; paper's: from the number of affordances and the length, not calibrated
  std::vector<Vector3> path;  ///< m; line through a curved handle's middle, end to end; `center` is near its middle,
                              ///< `axis` the tangent there, `length` its own; empty: straight
  std::vector<std::uint32_t> affordances;  ///< indices into Result::affordances, ascending
  // What the confidence of the default method rests on; 0 with the paper's.
  double arc = 0;            ///< rad; angle about the axis within which points were measured
  double residual = 0;       ///< m; root mean square distance of the points from the cylinder
  double observed_free = 0;  ///< 0..1; share of the fingers' volumes that was seen empty
  double normal_error = 0;   ///< rad; mean angle between the points' normals and the cylinder's
};

/// Where a sample ended, in the order of the steps; of several radii, at the furthest. See Funnel for what each means.
enum class Step : std::uint8_t {
  kTooFewPoints,
  kFlat,
  kCurvatureLow,
  kConcave,
  kCircleWide,
  kCircleNarrow,
  kPoorFit,
  kNoGap,
  kShellEmpty,
  kAffordance,
  kCut,
};
/// Name of the Funnel's count: "too_few_points", "flat", ...; "affordance", "cut"
std::string_view to_string(Step);

/// A neighbourhood that was looked at.
struct Sample {
  Vector3 position = {0, 0, 0};  ///< m; its centre
  Step step = Step::kTooFewPoints;
};

/// How many samples ended at each step, in the order of the steps. The counts add up to `samples`.
struct Funnel {
  std::int64_t samples = 0;         ///< neighbourhoods looked at
  std::int64_t too_few_points = 0;  ///< fewer neighbours than Options::min_neighbours
  std::int64_t flat = 0;            ///< points exactly on a plane, a line or in one place: no quadric
  std::int64_t curvature_low = 0;   ///< radius of curvature beyond Options::reach, or flat within the noise
  std::int64_t concave = 0;         ///< bends towards the sensor: a hollow, nothing to hold (default method)
  std::int64_t circle_wide = 0;     ///< fitted circle wider than the hand's aperture
  std::int64_t circle_narrow = 0;   ///< fitted circle narrower than the hand's minimum opening
  std::int64_t poor_fit = 0;        ///< points too far from the cylinder, or on too little of it (default method)
  std::int64_t no_gap = 0;          ///< no empty gap for the fingers, or none that was seen
  std::int64_t shell_empty = 0;     ///< a gap, but too few points within the shell
  std::int64_t affordances = 0;     ///< samples that gave an affordance
  std::int64_t cut = 0;             ///< drawn, but not looked at to the end: Options::deadline_ms came first
  // Of the affordances:
  std::int64_t not_aligned = 0;     ///< in no group of Options::handle_min_affordances aligned ones
  std::int64_t unconfirmed = 0;     ///< in a group that the cloud's points do not bear out (default method)
  std::int64_t too_short = 0;       ///< in a group shorter than Options::handle_min_length
  std::int64_t low_confidence = 0;  ///< in a handle below Options::min_confidence
  std::int64_t in_handles = 0;      ///< in a reported handle, or askew on its part
};

/// Wall-clock time of each step of one frame (ms). Steps that run in parallel are measured as their share of the
/// parallel section: the sum of the stages is `total`.
struct StageTimes {
  double index = 0;       ///< tiles and BVH or grid
  double samples = 0;     ///< drawing, snapping, sorting and grouping of samples
  double neighbours = 0;  ///< index queries
  double moments = 0;     ///< culling of boxes, rough planes, sums
  double fit = 0;         ///< Taubin, curvature, circle
  double shell = 0;       ///< shells, or (default method) cylinders and fingers
  double visibility = 0;  ///< depth image of what was seen (default method)
  double handles = 0;
  double total = 0;
};

struct Result {
  Status status = Status::kOk;
  std::size_t points = 0;  ///< of the cloud
  std::size_t finite_points = 0;
  std::vector<Handle> handles;          ///< best confidence first
  std::vector<Affordance> affordances;  ///< in the order of their samples
  Funnel funnel;
  StageTimes times_ms;
};

}  // namespace handhold
