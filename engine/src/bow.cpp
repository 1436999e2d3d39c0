#include "bow.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "silhouette.h"

namespace handhold {
namespace {

constexpr double kThickest = 0.017;      ///< m; half width: what is thicker is a body
constexpr double kThinnest = 0.0025;     ///< m; half width
constexpr std::size_t kMostSteps = 100;  ///< either way
constexpr std::size_t kBase = 3;         ///< places over which the direction is taken
constexpr std::size_t kRecent = 8;       ///< places whose median width is the part's
constexpr std::size_t kMostLost = 2;     ///< places in a row at which the outline is not seen
/// A width may differ from the recent ones by this (share, and m).
constexpr double kSameWidth = 0.35, kSameWidthMore = 0.002;
constexpr double kFirstWidth = 0.5;     ///< share; from the first one
constexpr double kMostShift = 0.006;    ///< m; of the middle, from one place to the next, across
constexpr double kMostRise = 0.008;     ///< m; the same along the line of sight, beside the noise
constexpr double kCosMostTurn = 0.766;  ///< 40 degrees, from one direction to the next
constexpr double kClosed = 0.010;       ///< m; an end as near as this to the other one closes the path
constexpr double kStraight = 0.060, kCosStraight = 0.98;  ///< m; and 0.2 rad
constexpr std::size_t kLeastPlaces = 4;
/// Cosine and sine of the directions that are tried one after the other: 0, 25 and 50 degrees to either side.
constexpr double kCorners[5][2] = {{1, 0}, {0.9063, 0.4226}, {0.9063, -0.4226}, {0.6428, 0.7660}, {0.6428, -0.7660}};

using Place = BowScratch::Place;

class Tracer {
 public:
  Tracer(const DepthImage& image, double sigma) : image_(image), sigma_(sigma) {}

  /// The part's middle at a place across a direction, where the outline steps on both sides.
  bool look(const Vector3& place, const Vector3& along, double half_width, Place& found) const {
    const Vector3 to_sensor = image_.viewpoint() - place;
    const Vector3 across = to_sensor - dot(to_sensor, along) * along;
    if (!(norm(across) > 1e-6)) return false;
    const Vector3 ahead = normalized(across), side = cross(along, ahead);
    Vector3 at = place;
    if (!settle(ahead, at)) return false;
    const double reach = 2 * half_width + 0.008;
    const SilhouetteSide right = silhouette_side(image_, at, side, ahead, reach, sigma_);
    if (right.kind != SilhouetteSide::kStep) return false;
    const SilhouetteSide left = silhouette_side(image_, at, -1.0 * side, ahead, reach, sigma_);
    if (left.kind != SilhouetteSide::kStep) return false;
    found.width = right.at + left.at;
    found.at = at + 0.5 * (right.at - left.at) * side;
    return std::fabs(right.at - left.at) < 2 * kMostShift + 0.5 * found.width && settle(ahead, found.at);
  }

  /// Places one after the other from a place on, that one left out; true: they come back to it.
  bool follow(const Place& first, const Vector3& first_direction, std::vector<Place>& places) const {
    places.assign(1, first);
    Vector3 direction = first_direction;
    std::array<double, kRecent> recent;
    std::size_t lost = 0;
    for (std::size_t step = 0; step < kMostSteps; ++step) {
      const std::size_t n = std::min(kRecent, places.size());
      for (std::size_t i = 0; i < n; ++i) recent[i] = places[places.size() - 1 - i].width;
      const auto middle = recent.begin() + static_cast<std::ptrdiff_t>(n / 2);
      std::nth_element(recent.begin(), middle, recent.begin() + static_cast<std::ptrdiff_t>(n));
      const Place& last = places.back();
      Place found;
      bool seen = false;
      // Straight on, or around a corner.
      const Vector3 to_sensor = normalized(image_.viewpoint() - last.at);
      const Vector3 beside = normalized(cross(to_sensor, direction));
      for (const auto& [cosine, sine] : kCorners) {
        const Vector3 way = cosine * direction + sine * beside;
        seen = look(last.at + static_cast<double>(1 + lost) * kBowStep * way, way, 0.5 * *middle, found) &&
               found.width <= 2 * kThickest &&
               std::fabs(found.width - *middle) <= kSameWidth * *middle + kSameWidthMore &&
               std::fabs(found.width - first.width) <= kFirstWidth * first.width + kSameWidthMore;
        if (seen) break;
      }
      if (!seen) {
        if (++lost > kMostLost) break;
        continue;
      }
      lost = 0;
      const std::size_t back = std::min(kBase, places.size());
      const Vector3 way = found.at - places[places.size() - back].at;
      if (!(norm(way) > 0.5 * kBowStep)) break;
      // The first steps keep to the direction that they were given: a short base says little.
      const double trust = static_cast<double>(back) / static_cast<double>(kBase);
      const Vector3 turned = normalized(trust * normalized(way) + (1 - trust) * direction);
      if (dot(turned, direction) < kCosMostTurn) break;
      direction = turned;
      places.push_back(found);
      if (step > 8 && norm(found.at - first.at) < kClosed) return true;
    }
    return false;
  }

 private:
  /// Moves a place along `ahead` onto the surface that is seen there, if that is near.
  bool settle(const Vector3& ahead, Vector3& at) const {
    const DepthImage::Projected p = image_.project(at);
    if (!(p.depth > 0.02)) return false;
    const double u = p.a / p.depth + 0.5, v = p.b / p.depth + 0.5;
    double z[5] = {image_.depth_in(u, v), image_.depth_in(u + 1, v), image_.depth_in(u - 1, v),
                   image_.depth_in(u, v + 1), image_.depth_in(u, v - 1)};
    // The second nearest: one pixel may be mixed with what is behind, and on a thin part several are of that.
    for (double& x : z) {
      if (!(x > 0)) x = 1e9;
    }
    std::nth_element(z, z + 1, z + 5);
    const Vector3 to_place = at - image_.viewpoint();
    const double height = (z[1] / p.depth - 1) * dot(to_place, ahead);
    if (!(std::fabs(height) < kMostRise + 3 * sigma_)) return false;
    at = at + height * ahead;
    return true;
  }

  const DepthImage& image_;
  double sigma_;
};

double angle_between(const Vector3& a, const Vector3& b) {
  return std::acos(std::clamp(dot(a, b), -1.0, 1.0));
}

}  // namespace

Vector3 Bow::tangent(std::size_t i) const {
  const std::size_t n = path.size(), before = i < 2 ? 0 : i - 2, after = std::min(n - 1, i + 2);
  return normalized(path[after] - path[before]);
}

std::size_t nearest_place(const std::vector<Vector3>& path, const Vector3& p) {
  const auto distance2 = [&](const Vector3& q) { return dot(q - p, q - p); };
  const auto at = std::min_element(path.begin(), path.end(),
                                   [&](const Vector3& a, const Vector3& b) { return distance2(a) < distance2(b); });
  return static_cast<std::size_t>(at - path.begin());
}

bool Bow::curved() const {
  const auto stretch = static_cast<std::size_t>(kStraight / kBowStep);
  for (std::size_t i = 0; i + stretch < path.size(); ++i) {
    const Vector3 chord = normalized(path[i + stretch] - path[i]);
    double least = 1;
    for (std::size_t k = i + 1; k < i + stretch; ++k) least = std::min(least, dot(tangent(k), chord));
    if (least > kCosStraight) return false;
  }
  return true;
}

bool Bow::tangled(double width) const {
  const auto apart = static_cast<std::size_t>(std::ceil(2 * width / kBowStep)) + 1;
  for (std::size_t i = 0; i < path.size(); ++i) {
    for (std::size_t k = i + apart; k < path.size(); ++k) {
      if (norm(path[k] - path[i]) < width) return true;
    }
  }
  return false;
}

bool trace_bow(const DepthImage& image, const Cylinder& start, double sigma, BowScratch& scratch, Bow& bow) {
  bow.clear();
  if (start.radius > kThickest || start.radius < kThinnest) return false;
  const Tracer tracer(image, sigma);
  const Vector3 to_sensor = image.viewpoint() - start.point;
  const Vector3 across = to_sensor - dot(to_sensor, start.axis) * start.axis;
  if (!(norm(across) > 1e-6)) return false;
  Place first;
  if (!tracer.look(start.point + start.radius * normalized(across), start.axis, start.radius, first)) return false;
  if (0.5 * first.width > kThickest || 0.5 * first.width < kThinnest) return false;
  std::vector<Place>&back = scratch.back, &forth = scratch.forth;
  bow.closed = tracer.follow(first, start.axis, forth);
  if (bow.closed) {
    back.assign(1, first);
  } else {
    tracer.follow(first, -1.0 * start.axis, back);
  }
  for (auto place = back.rbegin(); place != back.rend(); ++place) {
    bow.path.push_back(place->at), bow.widths.push_back(place->width);
  }
  for (std::size_t i = 1; i < forth.size(); ++i) {
    bow.path.push_back(forth[i].at), bow.widths.push_back(forth[i].width);
  }
  const std::size_t n = bow.path.size();
  if (n < kLeastPlaces) return false;
  // The middles are known to a pixel or so.
  std::vector<Vector3>& smooth = scratch.smooth;
  smooth = bow.path;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    smooth[i] = (1.0 / 3) * (bow.path[i - 1] + bow.path[i] + bow.path[i + 1]);
  }
  std::swap(bow.path, smooth);
  for (std::size_t i = 0; i + 1 < n; ++i) bow.length += norm(bow.path[i + 1] - bow.path[i]);
  // Over 20 mm each time: between near places noise turns more than the part does.
  for (std::size_t i = 4; i + 2 < n; i += 4) {
    bow.turn += angle_between(bow.tangent(i - 2), bow.tangent(std::min(n - 3, i + 2)));
  }
  return true;
}

}  // namespace handhold
