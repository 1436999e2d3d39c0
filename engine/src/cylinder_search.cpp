// The default method's verdict on a neighbourhood: a cylinder fitted to its points, and two fingers beside it.
#include <algorithm>
#include <cmath>

#include "fingers.h"
#include "ribbon.h"
#include "search.h"
#include "silhouette.h"

namespace handhold {
namespace {

/// A ball of radius R tells a cylinder of radius r when 0.5 r <= R <= 2.5 r + 12 mm: smaller ones see a plane, larger
/// ones more than the part.
constexpr double kSmallestBall = 0.5, kLargestBall = 2.5, kLargestBallOffset = 0.012;
constexpr double kRmsShare = 0.06;    ///< of the radius, beside the sensor's noise
constexpr double kLeastArc = 1.2217;  ///< rad; 70 degrees
constexpr double kWidthSlack = 1.04;
constexpr int kSteps = 8;
/// The noise of a cylinder through so many points is below what the sensor and the shape are wrong by.
constexpr std::size_t kMostFitted = 64;
/// Of more than kMostTried points, kTried are looked at first, with verdicts that leave room for their noise.
constexpr std::size_t kTried = 32, kMostTried = 80;
constexpr int kTrialSteps = 3;
constexpr double kTrialSlack = 1.2;
/// Of the quality of a strap that was found by its outline: fitted cylinders come first.
constexpr double kRibbonQuality = 0.5;

bool of_scale(double ball, double radius, double slack) {
  return ball >= kSmallestBall * radius / slack && ball <= (kLargestBall * radius + kLargestBallOffset) * slack;
}

/// Whether the surface that the sensor sees goes on beside a cylinder, on one side: it is the rim of something, or one
/// of its edges, and no finger gets around it there.
bool goes_on(const DepthImage& image, const Vector3& point, const Vector3& axis, double radius, double sigma) {
  const Vector3 to_sensor = image.viewpoint() - point;
  const Vector3 ahead = normalized(to_sensor - dot(to_sensor, axis) * axis, any_perpendicular(axis));
  const Vector3 side = cross(axis, ahead), place = point + radius * ahead;
  const double reach = silhouette_reach(radius);
  const auto surface = [&](const Vector3& way) {
    return silhouette_side(image, place, way, ahead, reach, sigma).kind == SilhouetteSide::kSurface;
  };
  return surface(side) || surface(-1.0 * side);
}

/// At most `most` of the points, evenly in their order; the same arrays when there are no more.
PointArrays some_of(const PointArrays& points, std::size_t most, AlignedArray<float>* xyz) {
  if (points.n <= most) return points;
  for (std::size_t k = 0; k < 3; ++k) xyz[k].require(most + 16);
  for (std::size_t i = 0; i < most; ++i) {
    const std::size_t from = i * points.n / most;
    xyz[0][i] = points.x[from], xyz[1][i] = points.y[from], xyz[2][i] = points.z[from];
  }
  return {xyz[0].data(), xyz[1].data(), xyz[2].data(), most};
}

}  // namespace

/// Why this cylinder, fitted to a ball's points with that residual, is no part that the hand could hold; kAffordance:
/// nothing speaks against it. `slack` > 1 refuses less.
Step Search::refuse(const Vector3& position, double ball, double rms, double sigma, double slack, Cylinder& c) const {
  if (2 * c.radius > slack * kWidthSlack * options_->hand_aperture) return Step::kCircleWide;
  if (slack * c.radius < kThinnestPart || 2 * slack * c.radius < options_->hand_minimum) return Step::kCircleNarrow;
  // At the sample's height.
  c.point = -dot(c.point, c.axis) * c.axis + c.point;
  if (conditions_.convex && !(dot(c.point, image_->viewpoint() - position) < 0)) return Step::kConcave;
  if (!of_scale(ball, c.radius, slack) || rms > slack * (kRmsShare * c.radius + sigma)) return Step::kPoorFit;
  return Step::kAffordance;
}

Step Search::judge(const Candidate& c, double ball, Scratch& s, Found& found) const {
  const Vector3 to_sensor = image_->viewpoint() - c.position;
  if (conditions_.convex && !(dot(c.position - c.affordance.center, to_sensor) > 0)) return Step::kConcave;
  if (!of_scale(ball, c.affordance.radius, 1.5)) return Step::kPoorFit;

  const float sample[3] = {static_cast<float>(c.position[0]), static_cast<float>(c.position[1]),
                           static_cast<float>(c.position[2])};
  const Near& near = s.near[s.group[c.entry]];
  const kernels::Candidates blocks = near.blocks.view();
  const auto capacity = static_cast<std::size_t>(blocks.padded) * 256 + 16;
  s.x.require(capacity), s.y.require(capacity), s.z.require(capacity);
  const int n = kernels::kernels().collect(near.layer.tiles->view(), blocks, sample, static_cast<float>(ball), nullptr,
                                           s.x.data(), s.y.data(), s.z.data());
  const PointArrays all{s.x.data(), s.y.data(), s.z.data(), static_cast<std::size_t>(n)};
  const double sigma = depth_noise(norm(to_sensor));
  Cylinder cylinder{c.affordance.center - c.position, c.affordance.axis, c.affordance.radius};
  // Most candidates are none, and some of the points are enough to see it.
  if (all.n > kMostTried) {
    const PointArrays few = some_of(all, kTried, s.few);
    const double rms = refine_cylinder(few, sigma, conditions_.refine ? kTrialSteps : 0, cylinder);
    const Step step = refuse(c.position, ball, rms, sigma, kTrialSlack, cylinder);
    if (step != Step::kAffordance) return step;
    if (conditions_.least_arc && kTrialSlack * arc_of(few, cylinder, to_sensor) < kLeastArc) return Step::kPoorFit;
  }
  const PointArrays points = some_of(all, kMostFitted, s.few);
  const double rms = refine_cylinder(points, sigma, conditions_.refine ? kSteps : 0, cylinder);
  const Step step = refuse(c.position, ball, rms, sigma, 1, cylinder);
  if (step != Step::kAffordance) return step;
  const double arc = arc_of(points, cylinder, to_sensor);
  if (arc < kLeastArc && conditions_.least_arc) return Step::kPoorFit;

  const Vector3 center = c.position + cylinder.point;
  if (conditions_.ends && goes_on(*image_, center, cylinder.axis, cylinder.radius, sigma)) return Step::kNoGap;
  const Grip grip =
      FingerTest(*options_, *image_, conditions_).any(center, cylinder.axis, cylinder.radius, options_->finger_width);
  if (!grip.fits) return Step::kNoGap;
  Affordance& a = found.affordance = c.affordance;
  a.center = center;
  a.axis = canonical_axis(cylinder.axis);
  a.radius = cylinder.radius;
  a.normal = normalized(-1.0 * cylinder.point, grip.from);
  a.shell_radius = grip.opening / 2;
  a.gap = options_->finger_thickness;
  a.observed_free = grip.free;
  a.quality = std::min(1.0, arc / 2.618) * std::exp(-rms / cylinder.radius / 0.15) * std::min(1.0, 0.5 + grip.free / 2);
  found.residual = -a.quality;  // of several radii the best one explains the place
  found.scale = c.scale;
  return Step::kAffordance;
}

bool Search::find_cylinders(double radius, Scratch& s) const {
  for (const Candidate& c : s.candidates) {
    if (budget_.spent()) return false;
    Found found;
    Step& step = s.reached[c.entry];
    step = judge(c, radius, s, found);
    if (step != Step::kAffordance) continue;
    s.found.push_back(found);
    s.quality[c.entry] = found.affordance.quality;
  }
  return true;
}

/// A strap about sample `at` of the sorted order, by its outline.
bool Search::find_strap(std::uint32_t at, Found& found) const {
  const float* p = &sorted_[3 * static_cast<std::size_t>(at)];
  const Vector3 sample = {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  Cylinder strap;
  if (!find_ribbon(*image_, sample, strap)) return false;
  if (2 * strap.radius > options_->hand_aperture || strap.radius < kThinnestPart) return false;
  if (2 * strap.radius < options_->hand_minimum) return false;
  const Grip grip =
      FingerTest(*options_, *image_, conditions_).any(strap.point, strap.axis, strap.radius, options_->finger_width);
  if (!grip.fits) return false;
  Affordance& a = found.affordance;
  a.sample = number_[at];
  a.center = strap.point;
  a.axis = canonical_axis(strap.axis);
  a.normal = grip.from;
  a.radius = strap.radius;
  a.curvature = 1 / strap.radius;
  a.shell_radius = grip.opening / 2;
  a.gap = options_->finger_thickness;
  a.observed_free = grip.free;
  a.quality = kRibbonQuality * std::min(1.0, 0.5 + grip.free / 2);
  found.residual = -a.quality;
  found.scale = 0;
  return true;
}

}  // namespace handhold
