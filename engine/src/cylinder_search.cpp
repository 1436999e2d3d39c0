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
constexpr std::size_t kTried = kernels::CylinderTrials::kPoints, kMostTried = 80;
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

/// Copies at most `most` of the points, evenly in their order, to x, y and z one after the other.
PointArrays some_of(const PointArrays& points, std::size_t most, AlignedArray<float>& xyz) {
  const std::size_t n = std::min(points.n, most), row = most + 16;
  xyz.require(3 * row);
  float *x = xyz.data(), *y = x + row, *z = y + row;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t from = points.n <= most ? i : i * points.n / most;
    x[i] = points.x[from], y[i] = points.y[from], z[i] = points.z[from];
  }
  return {x, y, z, n};
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

/// Looks at a candidate of a ball: its verdict comes at once, or with the trials.
void Search::judge(const Candidate& c, double ball, Scratch& s) const {
  Step& step = s.reached[c.entry];
  const Vector3 to_sensor = image_->viewpoint() - c.position;
  step = Step::kConcave;
  if (conditions_.convex && !(dot(c.position - c.affordance.center, to_sensor) > 0)) return;
  step = Step::kPoorFit;
  if (!of_scale(ball, c.affordance.radius, 1.5)) return;

  const float sample[3] = {static_cast<float>(c.position[0]), static_cast<float>(c.position[1]),
                           static_cast<float>(c.position[2])};
  const Near& near = s.near[s.group[c.entry]];
  const kernels::Candidates blocks = near.blocks.view();
  const auto capacity = static_cast<std::size_t>(blocks.padded) * 256 + 16;
  s.x.require(capacity), s.y.require(capacity), s.z.require(capacity);
  const int n = kernels::kernels().collect(near.layer.tiles->view(), blocks, sample, static_cast<float>(ball), nullptr,
                                           s.x.data(), s.y.data(), s.z.data());
  const PointArrays all{s.x.data(), s.y.data(), s.z.data(), static_cast<std::size_t>(n)};
  const Cylinder cylinder{c.affordance.center - c.position, c.affordance.axis, c.affordance.radius};
  Trials& t = s.trials;
  const PointArrays points = some_of(all, kMostFitted, t.xyz[t.n]);
  if (all.n <= kMostTried) {
    settle(c, ball, points, cylinder, s);
    return;
  }
  // Most candidates are none, and some of the points are enough to see it.
  const std::size_t lane = t.n++;
  t.candidate[lane] = &c, t.points[lane] = points.n;
  for (std::size_t i = 0; i < kTried; ++i) {
    const std::size_t from = i * all.n / kTried;
    t.batch.points[i][0][lane] = all.x[from], t.batch.points[i][1][lane] = all.y[from];
    t.batch.points[i][2][lane] = all.z[from];
  }
  for (std::size_t k = 0; k < 3; ++k) {
    t.batch.point[k][lane] = static_cast<float>(cylinder.point[k]);
    t.batch.axis[k][lane] = static_cast<float>(cylinder.axis[k]);
    t.batch.towards[k][lane] = static_cast<float>(to_sensor[k]);
  }
  t.batch.radius[lane] = static_cast<float>(cylinder.radius);
  t.batch.sigma[lane] = static_cast<float>(depth_noise(norm(to_sensor)));
  if (t.n == Trials::kLanes) run_trials(ball, s);
}

/// Fits the cylinders of the trials, and those that pass once more to more points.
void Search::run_trials(double ball, Scratch& s) const {
  Trials& t = s.trials;
  if (t.n == 0) return;
  // An unused lane has the points of the first.
  for (std::size_t lane = t.n; lane < Trials::kLanes; ++lane) {
    for (auto& point : t.batch.points)
      for (auto& row : point) row[lane] = row[0];
    for (std::size_t k = 0; k < 3; ++k) {
      t.batch.point[k][lane] = t.batch.point[k][0], t.batch.axis[k][lane] = t.batch.axis[k][0];
      t.batch.towards[k][lane] = t.batch.towards[k][0];
    }
    t.batch.radius[lane] = t.batch.radius[0], t.batch.sigma[lane] = t.batch.sigma[0];
  }
  t.batch.arm = static_cast<float>(kTiltArm);
  t.batch.steps = conditions_.refine ? kTrialSteps : 0;
  kernels::kernels().try_cylinders(t.batch);
  for (std::size_t lane = 0; lane < t.n; ++lane) {
    const Candidate& c = *t.candidate[lane];
    Cylinder cylinder;
    for (std::size_t k = 0; k < 3; ++k) {
      cylinder.point[k] = static_cast<double>(t.batch.point[k][lane]);
      cylinder.axis[k] = static_cast<double>(t.batch.axis[k][lane]);
    }
    cylinder.axis = normalized(cylinder.axis);
    cylinder.radius = static_cast<double>(t.batch.radius[lane]);
    Step& step = s.reached[c.entry];
    step = refuse(c.position, ball, static_cast<double>(t.batch.rms[lane]), static_cast<double>(t.batch.sigma[lane]),
                  kTrialSlack, cylinder);
    if (step != Step::kAffordance) continue;
    const double arc = turn_angle(t.batch.most_turn[lane]) - turn_angle(t.batch.least_turn[lane]);
    if (conditions_.least_arc && kTrialSlack * arc < kLeastArc) {
      step = Step::kPoorFit;
      continue;
    }
    const std::size_t row = kMostFitted + 16;
    const float* x = t.xyz[lane].data();
    settle(c, ball, {x, x + row, x + 2 * row, t.points[lane]}, cylinder, s);
  }
  t.n = 0;
}

/// The verdict on a candidate, from its points.
void Search::settle(const Candidate& c, double ball, const PointArrays& points, const Cylinder& cylinder,
                    Scratch& s) const {
  Found found;
  s.reached[c.entry] = fit_cylinder(c, ball, points, cylinder, found);
  if (s.reached[c.entry] != Step::kAffordance) return;
  s.found.push_back(found);
  s.quality[c.entry] = found.affordance.quality;
}

Step Search::fit_cylinder(const Candidate& c, double ball, const PointArrays& points, Cylinder cylinder,
                          Found& found) const {
  const Vector3 to_sensor = image_->viewpoint() - c.position;
  const double sigma = depth_noise(norm(to_sensor));
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
  s.trials.n = 0;
  for (const Candidate& c : s.candidates) {
    if (budget_.spent()) return false;
    judge(c, radius, s);
  }
  run_trials(radius, s);
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
