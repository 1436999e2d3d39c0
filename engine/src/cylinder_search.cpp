// The default method's verdict on a neighbourhood: a cylinder fitted to its points, and two fingers beside it.
#include <algorithm>
#include <cmath>

#include "fingers.h"
#include "search.h"

namespace handhold {
namespace {

/// A ball of radius R tells a cylinder of radius r when 0.5 r <= R <= 2.5 r + 12 mm: smaller ones see a plane, larger
/// ones more than the part.
constexpr double kSmallestBall = 0.5, kLargestBall = 2.5, kLargestBallOffset = 0.012;
constexpr double kRmsShare = 0.06;    ///< of the radius, beside the sensor's noise
constexpr double kLeastArc = 1.2217;  ///< rad; 70 degrees
constexpr double kThinnest = 0.004;   ///< m
constexpr double kWidthSlack = 1.04;
constexpr int kSteps = 8;

bool of_scale(double ball, double radius, double slack) {
  return ball >= kSmallestBall * radius / slack && ball <= (kLargestBall * radius + kLargestBallOffset) * slack;
}

}  // namespace

Step Search::judge(const Candidate& c, double ball, Scratch& s, Found& found) const {
  const Vector3 to_sensor = image_->viewpoint() - c.position;
  const auto convex = [&](const Vector3& center) {
    return !conditions_.convex || dot(c.position - center, to_sensor) > 0;
  };
  if (!convex(c.affordance.center)) return Step::kConcave;
  if (!of_scale(ball, c.affordance.radius, 1.5)) return Step::kPoorFit;

  const float sample[3] = {static_cast<float>(c.position[0]), static_cast<float>(c.position[1]),
                           static_cast<float>(c.position[2])};
  const auto capacity = static_cast<std::size_t>(s.near.view().padded) * 256 + 16;
  s.x.require(capacity), s.y.require(capacity), s.z.require(capacity);
  const int n = kernels::kernels().collect(tiles_->view(), s.near.view(), sample, static_cast<float>(ball), nullptr,
                                           s.x.data(), s.y.data(), s.z.data());
  const PointArrays points{s.x.data(), s.y.data(), s.z.data(), static_cast<std::size_t>(n)};
  const double sigma = depth_noise(norm(to_sensor));
  Cylinder cylinder{c.affordance.center - c.position, c.affordance.axis, c.affordance.radius};
  const double rms = refine_cylinder(points, sigma, conditions_.refine ? kSteps : 0, cylinder);
  if (2 * cylinder.radius > kWidthSlack * options_->hand_aperture) return Step::kCircleWide;
  if (cylinder.radius < kThinnest || 2 * cylinder.radius < options_->hand_minimum) return Step::kCircleNarrow;
  // At the sample's height.
  cylinder.point = -dot(cylinder.point, cylinder.axis) * cylinder.axis + cylinder.point;
  if (!convex(c.position + cylinder.point)) return Step::kConcave;
  if (!of_scale(ball, cylinder.radius, 1) || rms > kRmsShare * cylinder.radius + sigma) return Step::kPoorFit;
  const double arc = arc_of(points, cylinder, to_sensor);
  if (arc < kLeastArc && conditions_.least_arc) return Step::kPoorFit;

  const Grip grip = FingerTest(*options_, *image_, conditions_)
                        .any(c.position + cylinder.point, cylinder.axis, cylinder.radius, options_->finger_width);
  if (!grip.fits) return Step::kNoGap;
  Affordance& a = found.affordance = c.affordance;
  a.center = c.position + cylinder.point;
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

void Search::find_cylinders(double radius, Step* steps, Scratch& s) const {
  for (std::size_t first = 0; first < s.candidates.size();) {
    float low[3], high[3];
    std::size_t last = first;
    for (; last < s.candidates.size() && last < first + kernels::kMaxGroup; ++last) {
      float l[3], h[3], d2 = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        const auto x = static_cast<float>(s.candidates[last].position[j]);
        l[j] = last == first ? x : std::min(low[j], x), h[j] = last == first ? x : std::max(high[j], x);
        d2 += (h[j] - l[j]) * (h[j] - l[j]);
      }
      if (static_cast<double>(d2) > 16 * radius * radius) break;
      std::copy(l, l + 3, low), std::copy(h, h + 3, high);
    }
    s.near.fill(*tiles_, *index_, low, high, static_cast<float>(radius));
    for (; first < last; ++first) {
      const Candidate& c = s.candidates[first];
      Found found;
      steps[c.sample] = judge(c, radius, s, found);
      if (steps[c.sample] == Step::kAffordance) s.found.push_back(found);
    }
  }
}

}  // namespace handhold
