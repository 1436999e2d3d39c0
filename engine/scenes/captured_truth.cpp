// What a frame shows of a scene's parts, and which of them a hand could hold where they are.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "handhold/grasp_check.h"
#include "handhold/scene_file.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

constexpr double kTurn = 6.283185307179586;

/// Arc lengths of a centre line's vertices, and frames to measure angles about it.
class CentreLine {
 public:
  explicit CentreLine(const std::vector<Vector3>& points) : points_(points), lengths_(1, 0.0) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      lengths_.push_back(lengths_.back() + norm(points[i + 1] - points[i]));
    }
  }
  double length() const { return lengths_.back(); }

  struct Place {
    double along = -1;  ///< m; arc length, negative: before the start or beyond the end
    double across = 0;  ///< m; distance to the line
    double angle = 0;   ///< rad; about the line
  };
  Place place(const Vector3& p) const {
    Place best;
    double nearest = HUGE_VAL;
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      const Vector3 d = points_[i + 1] - points_[i];
      const double s = dot(p - points_[i], d) / dot(d, d);
      if ((s < 0 && i == 0) || (s > 1 && i + 2 == points_.size())) continue;
      const double t = std::clamp(s, 0.0, 1.0);
      const Vector3 off = p - points_[i] - t * d;
      if (norm(off) >= nearest) continue;
      nearest = norm(off);
      // Directions across neighbouring pieces of a bent line differ by their bend only.
      const Vector3 tangent = unit(d);
      const Vector3 x = unit(cross(tangent, side_));
      best = {lengths_[i] + t * norm(d), nearest, std::atan2(dot(off, cross(tangent, x)), dot(off, x))};
    }
    return best;
  }
  Vector3 point(double along) const { return segment(along).first; }
  Vector3 tangent(double along) const { return segment(along).second; }

  /// A direction that no piece of the line runs along.
  void set_side(const Vector3& side) { side_ = side; }

 private:
  std::pair<Vector3, Vector3> segment(double along) const {
    std::size_t i = 0;
    while (i + 2 < points_.size() && along > lengths_[i + 1]) ++i;
    const Vector3 t = unit(points_[i + 1] - points_[i]);
    return {points_[i] + (along - lengths_[i]) * t, t};
  }

  const std::vector<Vector3>& points_;
  std::vector<double> lengths_;
  Vector3 side_ = {0, 0, 1};
};

/// For a bent line the normal of its plane, for a straight one any direction across it.
Vector3 side_of(const std::vector<Vector3>& line) {
  const Vector3 chord = line.back() - line.front();
  Vector3 best = {0, 0, 0};
  for (const Vector3& p : line) {
    const Vector3 n = cross(chord, p - line.front());
    if (norm(n) > norm(best)) best = n;
  }
  if (norm(best) > 1e-3 * dot(chord, chord)) return unit(best);
  const auto smallest =
      std::min_element(chord.begin(), chord.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  Vector3 other = {0, 0, 0};
  other[static_cast<std::size_t>(smallest - chord.begin())] = 1;
  return unit(cross(chord, other));
}

/// The arc from the first to the last of some angles, the short way around: a turn less the widest gap.
double spanned_arc(std::vector<double> angles) {
  std::sort(angles.begin(), angles.end());
  double gap = kTurn - (angles.back() - angles.front());
  for (std::size_t i = 0; i + 1 < angles.size(); ++i) gap = std::max(gap, angles[i + 1] - angles[i]);
  return kTurn - gap;
}

/// Part::measured, from the points of the part's object.
bool is_measured(const Part& part, const std::vector<Vector3>& points) {
  constexpr double kSlice = 0.005, kEnough = 0.020, kArc = kTurn / 6;
  constexpr std::size_t kPoints = 10;
  CentreLine line(part.centre_line);
  line.set_side(side_of(part.centre_line));
  const auto slices = static_cast<std::size_t>(line.length() / kSlice + 1e-9);
  const double start = (line.length() - static_cast<double>(slices) * kSlice) / 2;
  // Noise and sections that are not round reach a little beyond the radius.
  const double reach = 1.3 * part.radius + 0.004;
  std::vector<std::vector<double>> angles(slices);
  for (const Vector3& p : points) {
    const CentreLine::Place place = line.place(p);
    const double slice = std::floor((place.along - start) / kSlice);
    if (place.along < 0 || place.across > reach || slice < 0 || slice >= static_cast<double>(slices)) continue;
    angles[static_cast<std::size_t>(slice)].push_back(place.angle);
  }
  std::size_t run = 0, longest = 0;
  for (const std::vector<double>& slice : angles) {
    run = slice.size() >= kPoints && spanned_arc(slice) >= kArc ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return static_cast<double>(longest) * kSlice >= kEnough - 1e-9;
}

/// Whether the hand fits in the middle of a part's centre line or at one of the points every 10 mm along it.
bool is_graspable(const Part& part, const GraspCheck& check) {
  constexpr double kStep = 0.010;
  const CentreLine line(part.centre_line);
  const auto fits = [&](double along) {
    return check.check(line.point(along), line.tangent(along), part.radius, Hand{}).fits;
  };
  if (fits(line.length() / 2)) return true;
  for (double along = kStep; along < line.length(); along += kStep) {
    if (fits(along)) return true;
  }
  return false;
}

/// Part::raised, given what is not the part's object.
bool is_raised(const Part& part, const GraspCheck& others) {
  constexpr double kStep = 0.010, kThickness = 0.010;
  constexpr int kDirections = 24;
  const CentreLine line(part.centre_line);
  const Vector3 side = side_of(part.centre_line);
  const auto places = std::max<std::size_t>(1, static_cast<std::size_t>(line.length() / kStep));
  std::size_t free = 0;
  for (std::size_t i = 0; i < places; ++i) {
    const double along = line.length() * (static_cast<double>(i) + 0.5) / static_cast<double>(places);
    const Vector3 at = line.point(along), tangent = line.tangent(along);
    const Vector3 x = unit(cross(tangent, side)), y = cross(tangent, x);
    bool touched = false;
    for (int k = 0; k < kDirections && !touched; ++k) {
      const Vector3 out = std::cos(kTurn * k / kDirections) * x + std::sin(kTurn * k / kDirections) * y;
      // Three circles, so that thin things between them are met, too.
      for (const double beyond : {0.002, kThickness / 2, kThickness}) {
        touched = touched || others.inside(at + (part.radius + beyond) * out);
      }
    }
    free += !touched;
  }
  return 2 * free >= places;
}

}  // namespace

std::vector<Part> captured_truth(const Scene& scene, const Pose& T_world_camera, const CameraOptions& options,
                                 const Frame& frame) {
  if (frame.cloud.width != options.width || frame.cloud.height != options.height ||
      frame.object.size() != frame.cloud.size()) {
    throw std::invalid_argument("captured_truth: the frame is " + std::to_string(frame.cloud.width) + " x " +
                                std::to_string(frame.cloud.height) + " px; it must be the camera's " +
                                std::to_string(options.width) + " x " + std::to_string(options.height));
  }
  std::vector<std::vector<Vector3>> points(scene.objects.size());
  for (std::size_t i = 0; i < frame.object.size(); ++i) {
    const float* p = &frame.cloud.xyz[3 * i];
    if (frame.object[i] < 0 || !std::isfinite(p[2])) continue;
    points[static_cast<std::size_t>(frame.object[i])].push_back({p[0], p[1], p[2]});
  }
  std::vector<Part> truth = DepthCamera(options).truth(scene, T_world_camera);
  const GraspCheck check(scene);
  std::size_t k = 0;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.objects[i].parts.empty()) continue;
    Scene rest = scene;
    rest.objects.erase(rest.objects.begin() + static_cast<std::ptrdiff_t>(i));
    const GraspCheck others(rest);
    for (const Part& part : scene.objects[i].parts) {
      truth[k].measured = is_measured(truth[k], points[i]);
      truth[k].graspable = is_graspable(part, check);
      truth[k].raised = is_raised(part, others);
      ++k;
    }
  }
  return truth;
}

std::vector<Part> captured_truth(const SceneFile& file, const Scene& scene, const Frame& frame) {
  return captured_truth(scene, file.T_world_camera, file.camera, frame);
}

}  // namespace handhold::sensor
