#include "part_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace handhold {
namespace {

constexpr double kExtension = 0.02;  ///< m; how far beyond its members a part may go on
constexpr std::size_t kLeastPoints = 25;
constexpr double kMostNoise = 0.3;   ///< of the radius: in more no cross-section can be told from another
constexpr double kThinnest = 0.004;  ///< m
constexpr double kWidthSlack = 1.04;
constexpr int kSteps = 10;
// Slices.
constexpr double kSlice = 0.005;       ///< m
constexpr double kLeastDensity = 0.4;  ///< of the median slice
constexpr double kLeastCover = 1.047;  ///< rad
constexpr double kRmsShare = 0.06;
constexpr double kSureCount = 10;  ///< points of a slice beyond which its radius gets no surer: their noise is alike
/// A jump of the radius parts two pieces when it is larger than both.
constexpr double kJump = 0.0012, kJumpShare = 0.06;          ///< m; of the radius
constexpr double kLeastArc = 1.2217;                         ///< rad
constexpr double kMostNormalError = 0.55;                    ///< rad
constexpr double kSameWidth = 0.3, kSameWidthMore = 0.0015;  ///< share and m; widths along a strap differ by less
constexpr std::size_t kLeastOutline = 3;                     ///< slices
/// Of a cylinder's radius: seen narrower than this it is a strap. The steep sides of thick parts are often not
/// measured.
constexpr double kStrap = 0.9, kThickShare = 0.8;
constexpr double kThickStrap = 0.018;  ///< m; radius

/// What the outline of right candidates usually shows.
void forget_outline(Evidence& e) {
  e.steps_less = e.steps_more = 0.9, e.nearer_end = 0.85, e.farther_end = 0.95;
  e.fall_less = {0.022, 0.020, 0.019}, e.fall_more = {0.036, 0.042, 0.046};
  e.followed = e.length + 0.01, e.turn = 0.2, e.off_middle = 0.01, e.off_direction = 0.05;
}

double median(std::vector<double>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Replaces `c` by a cylinder that was fitted from it; false, and nothing changes: it has become another one.
bool adopt(Cylinder fit, double least_cosine, double most_change, Cylinder& c) {
  const double cosine = dot(fit.axis, c.axis);
  if (std::fabs(cosine) < least_cosine || std::fabs(fit.radius - c.radius) > most_change) return false;
  // Heights keep their origin.
  fit.point = fit.point + dot(c.point - fit.point, fit.axis) * fit.axis;
  if (cosine < 0) fit.axis = -1.0 * fit.axis;
  c = fit;
  return true;
}

}  // namespace

void PartCheck::fill_slices(const Cylinder& c, double low, std::size_t n) {
  slices_.assign(n, {});
  // What rises with the angle orders as well; an arc tangent is needed for the outermost points only.
  turns_.assign(n, {});
  for (const std::uint32_t i : points_.selected()) {
    const int at = static_cast<int>((points_.height(i) - low) / kSlice);
    const auto k = static_cast<std::size_t>(std::clamp(at, 0, static_cast<int>(n) - 1));
    Slice& s = slices_[k];
    Turns& t = turns_[k];
    const double distance = points_.distance(i), e = distance - c.radius;
    const double side = points_.side(i), ahead = points_.ahead(i);
    s.count += 1, s.square += e * e, s.distance += distance;
    const double turn = std::copysign(1 - ahead / std::max(std::fabs(ahead) + std::fabs(side), 1e-30), side);
    if (turn < t.low) t.low = turn, t.first = i;
    if (turn > t.high) t.high = turn, t.last = i;
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (!(slices_[k].count > 0)) continue;
    slices_[k].low = std::atan2(points_.side(turns_[k].first), points_.ahead(turns_[k].first));
    slices_[k].high = std::atan2(points_.side(turns_[k].last), points_.ahead(turns_[k].last));
  }
}

/// Log of the rms distance from the two planes along the axis that explain the selected points best, over `residual`.
/// Edges of boxes, blurred by the sensor, look round to a cylinder alone.
double PartCheck::corner_gain(double residual) {
  section_.clear();
  for (const std::uint32_t i : points_.selected()) {
    section_.push_back({points_.side(i), points_.ahead(i)});
  }
  std::sort(section_.begin(), section_.end());
  const std::size_t n = section_.size();
  section_sums_.assign(n + 1, {});
  for (std::size_t i = 0; i < n; ++i) {
    const double u = section_[i][0], v = section_[i][1];
    const std::array<double, 6> terms = {1, u, v, u * u, u * v, v * v};
    for (std::size_t k = 0; k < 6; ++k) section_sums_[i + 1][k] = section_sums_[i][k] + terms[k];
  }
  // Sum of squared distances from the line of least squares through points [a, b).
  const auto line = [&](std::size_t a, std::size_t b) {
    double s[6];
    for (std::size_t k = 0; k < 6; ++k) s[k] = section_sums_[b][k] - section_sums_[a][k];
    const double uu = s[3] - s[1] * s[1] / s[0], uv = s[4] - s[1] * s[2] / s[0], vv = s[5] - s[2] * s[2] / s[0];
    return std::max(0.0, 0.5 * (uu + vv - std::hypot(uu - vv, 2 * uv)));
  };
  double least = std::numeric_limits<double>::infinity();
  for (int k = 2; k <= 14; ++k) {
    const std::size_t at = n * static_cast<std::size_t>(k) / 16;
    if (at < 4 || n - at < 4) continue;
    least = std::min(least, line(0, at) + line(at, n));
  }
  if (!(least < std::numeric_limits<double>::infinity())) return 0;
  return std::log((std::sqrt(least / static_cast<double>(n)) + 1e-5) / (residual + 1e-5));
}

/// Fits `c` again to its points between `low` and `high`; false, and nothing changes: they are of something else.
bool PartCheck::refit(double low, double high, Cylinder& c) {
  if (points_.select(c, low, high) < kLeastPoints) return false;
  Cylinder fit = c;
  if (conditions_.refit) refine_cylinder(points_.taken(), sigma_, kSteps, fit);
  return adopt(fit, 0.95, 0.35 * c.radius, c);
}

/// Cuts what lies on the cylinder, in `n` slices from `low`, into pieces of different radii; false: too few points.
bool PartCheck::find_pieces(const Cylinder& c, double low, std::size_t n) {
  if (points_.select(c, low, low + static_cast<double>(n) * kSlice) < kLeastPoints) return false;
  fill_slices(c, low, n);
  profile_.assign(n, {});
  for (std::size_t i = 0; i < n; ++i) {
    const Slice& s = slices_[i];
    if (s.count < 3) continue;
    profile_[i] = {std::min(s.count, kSureCount) / (sigma_ * sigma_), s.distance / s.count};
  }
  pieces_.clear();
  if (!conditions_.cut_profile) {
    pieces_.push_back({0, n});
    return true;
  }
  cut_profile(profile_, kSlice, std::max(kJump, kJumpShare * c.radius), kPiecePenalty, profile_scratch_, pieces_);
  return true;
}

/// 0: nothing was measured.
double PartCheck::radius_of(const ProfilePiece& piece) const {
  double weight = 0, sum = 0;
  for (std::size_t i = piece.first; i < piece.last; ++i) {
    weight += profile_[i].weight, sum += profile_[i].weight * profile_[i].radius;
  }
  return weight > 0 ? sum / weight : 0;
}

/// Looks where the part ends on both sides of its axis, seen from the sensor, in `n` slices from `low`.
void PartCheck::find_outline(const Cylinder& c, double low, std::size_t n) {
  const CylinderFrame f = points_.frame(c);
  const double reach = silhouette_reach(c.radius);
  outline_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3 place = c.point + (low + (static_cast<double>(i) + 0.5) * kSlice) * c.axis + c.radius * f.ahead;
    outline_.push_back({silhouette_side(*image_, place, f.side, f.ahead, reach, sigma_),
                        silhouette_side(*image_, place, -1.0 * f.side, f.ahead, reach, sigma_)});
    for (SilhouetteSide& side : outline_.back()) {
      if (side.kind == SilhouetteSide::kSurface) side.at = reach;
    }
  }
}

/// Slices of the outline [first, last): how far the steps are that most of them end at on each side (m; along the
/// frame's side and against it); 0: they end at none.
std::array<double, 2> PartCheck::sum_outline(std::size_t first, std::size_t last, double radius, Evidence& e) {
  std::array<double, 2> steps{}, end{}, share{};
  for (std::size_t k = 0; k < 2; ++k) {
    usual_.clear();
    double count = 0;
    for (std::size_t i = first; i < last; ++i) usual_.push_back(outline_[i][k].at);
    end[k] = median(usual_) / radius;
    usual_.clear();
    for (std::size_t i = first; i < last; ++i) {
      if (outline_[i][k].kind == SilhouetteSide::kStep) usual_.push_back(outline_[i][k].at), count += 1;
    }
    share[k] = count / static_cast<double>(last - first);
    if (share[k] >= 0.5) steps[k] = median(usual_);
  }
  for (std::size_t look = 0; look < kLooksBeyond; ++look) {
    std::array<double, 2> fall{};
    for (std::size_t k = 0; k < 2; ++k) {
      usual_.clear();
      for (std::size_t i = first; i < last; ++i) {
        if (outline_[i][k].kind == SilhouetteSide::kStep) usual_.push_back(outline_[i][k].fall[look]);
      }
      if (!usual_.empty()) fall[k] = median(usual_);
    }
    e.fall_less[look] = std::min(fall[0], fall[1]), e.fall_more[look] = std::max(fall[0], fall[1]);
  }
  e.steps_less = std::min(share[0], share[1]), e.steps_more = std::max(share[0], share[1]);
  e.nearer_end = std::min(end[0], end[1]), e.farther_end = std::max(end[0], end[1]);
  return steps;
}

/// Whether slice i of the outline is of a strap of that half width (m).
bool PartCheck::is_strap(std::size_t i, double half_width) const {
  const auto& [left, right] = outline_[i];
  if (left.kind != SilhouetteSide::kStep || right.kind != SilhouetteSide::kStep) return false;
  return std::fabs(0.5 * (left.at + right.at) - half_width) < kSameWidth * half_width + kSameWidthMore;
}

/// The strap along the group's line: its outline says where it is and how wide.
bool PartCheck::measure_strap(const PartGroup& group, const std::vector<Affordance>& affordances,
                              PartCandidate& found) {
  Cylinder c = group.mean;
  const double low = group.low - kExtension, high = group.high + kExtension;
  const auto n = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil((high - low) / kSlice)));
  for (int pass = 0; pass < 2; ++pass) {
    find_outline(c, low, n);
    usual_.clear(), others_.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const double height = low + (static_cast<double>(i) + 0.5) * kSlice;
      const auto& [left, right] = outline_[i];
      if (left.kind != SilhouetteSide::kStep || right.kind != SilhouetteSide::kStep) continue;
      if (height < group.low || height > group.high) continue;
      usual_.push_back(0.5 * (left.at + right.at));
      others_.push_back(0.5 * (left.at - right.at));
    }
    if (usual_.size() < kLeastOutline) return false;
    const double half_width = median(usual_), offset = median(others_);
    const CylinderFrame f = points_.frame(c);
    // The surface stays where it is.
    c.point = c.point + offset * f.side + (c.radius - half_width) * f.ahead;
    c.radius = half_width;
  }
  find_outline(c, low, n);
  return measure(c, low, high, Kind::kStrap, group, affordances, found);
}

/// The first of the longest runs of slices that pass, a single one that does not between two that do counted in: where
/// it begins and its length.
std::pair<std::size_t, std::size_t> PartCheck::longest_run(std::vector<char>& pass) {
  for (std::size_t i = 1; i + 1 < pass.size(); ++i) {
    if (!pass[i] && pass[i - 1] == 1 && pass[i + 1] == 1) pass[i] = 2;
  }
  std::size_t first = 0, longest = 0, run = 0;
  for (std::size_t i = 0; i <= pass.size(); ++i) {
    if (i < pass.size() && pass[i]) {
      ++run;
      continue;
    }
    if (run > longest) longest = run, first = i - run;
    run = 0;
  }
  return {first, longest};
}

/// Looks at the piece between `low` and `high` of a line: the longest run of slices that are of one part and that the
/// hand can hold from one direction.
bool PartCheck::measure(Cylinder c, double low, double high, Kind kind, const PartGroup& group,
                        const std::vector<Affordance>& affordances, PartCandidate& found) {
  if (kind == Kind::kPiece) refit(low, high, c);
  if (2 * c.radius > kWidthSlack * options_->hand_aperture || c.radius < kThinnest) return false;
  if (2 * c.radius < options_->hand_minimum) return false;
  if (points_.select(c, low, high) < kLeastPoints) return false;
  const auto n = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround((high - low) / kSlice)));
  fill_slices(c, low, n);
  // What a slice of this part usually holds: how dense the cloud is here needs no other measure.
  usual_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const double middle = low + (static_cast<double>(i) + 0.5) * kSlice;
    if (middle > group.low && middle < group.high) usual_.push_back(slices_[i].count);
  }
  if (usual_.empty()) {
    for (const Slice& s : slices_) usual_.push_back(s.count);
  }
  const double usual = median(usual_);

  // Slices that may be part of a run, whatever the approach angle, and how long one can become.
  candidates_.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const Slice& s = slices_[i];
    if (s.count < std::max(1.0, kLeastDensity * usual)) continue;
    candidates_[i] = kind == Kind::kStrap ? is_strap(i, c.radius)
                                          : !(s.high - s.low < kLeastCover ||
                                              std::sqrt(s.square / s.count) > kRmsShare * c.radius + sigma_);
  }
  pass_ = candidates_;
  const std::size_t most = longest_run(pass_).second;

  const FingerTest fingers(*options_, *image_, conditions_);
  std::size_t best_length = 0, best_first = 0;
  double best_free = 0;
  Vector3 from{};
  free_.resize(n);
  for (int k = 0; k < fingers.angles() && best_length < most; ++k) {
    pass_.assign(n, 0);
    std::fill(free_.begin(), free_.end(), 0.0);
    Vector3 towards{};
    for (std::size_t i = 0; i < n; ++i) {
      if (!candidates_[i]) continue;
      const Grip grip = fingers.at(c.point + (low + (static_cast<double>(i) + 0.5) * kSlice) * c.axis, c.axis, c.radius,
                                   kSlice, FingerTest::angle(k));
      if (!grip.fits) continue;
      pass_[i] = 1;
      free_[i] = grip.free;
      towards = grip.from;
    }
    const auto [first, run] = longest_run(pass_);
    if (run <= best_length) continue;
    best_length = run, best_first = first, from = towards;
    best_free = std::accumulate(free_.begin() + static_cast<std::ptrdiff_t>(first),
                                free_.begin() + static_cast<std::ptrdiff_t>(first + run), 0.0) /
                static_cast<double>(run);
  }
  const double length = static_cast<double>(best_length) * kSlice;
  if (length < std::max(options_->handle_min_length, 0.8 * c.radius) - 1e-9) return false;
  const double begin = low + static_cast<double>(best_first) * kSlice, end = begin + length;
  const double middle = 0.5 * (begin + end);

  // The slices of the run: how straight it is, and how even.
  Evidence& e = found.evidence;
  double sides = 0, sides2 = 0, w = 0, wi = 0, wii = 0, wr = 0, wri = 0, wrr = 0, used = 0;
  for (std::size_t i = best_first; i < best_first + best_length; ++i) {
    const Slice& s = slices_[i];
    if (!(s.count > 0)) continue;
    const double mid = c.radius * 0.5 * (std::sin(s.low) + std::sin(s.high)), r = s.distance / s.count,
                 x = static_cast<double>(i), weight = std::min(s.count, kSureCount);
    sides += mid, sides2 += mid * mid, used += 1;
    w += weight, wi += weight * x, wii += weight * x * x, wr += weight * r, wri += weight * r * x,
        wrr += weight * r * r;
  }
  if (!(used > 0)) return false;
  e.bend = std::sqrt(std::max(0.0, sides2 / used - sides / used * (sides / used)));
  const double var_x = wii / w - wi / w * (wi / w), cov = wri / w - wr / w * (wi / w),
               var_r = wrr / w - wr / w * (wr / w);
  e.waviness = std::sqrt(std::max(0.0, var_r - (var_x > 1e-9 ? cov * cov / var_x : 0.0)));

  double inner = 0, outer = 0;
  const double tolerance = cylinder_band(c.radius, sigma_);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (points_.height(i) < begin || points_.height(i) > end) continue;
    inner += points_.distance(i) < c.radius - tolerance;
    outer += points_.distance(i) > c.radius + tolerance && points_.ahead(i) > 0.5 * points_.distance(i);
  }
  const std::size_t count = points_.narrow(begin, end);
  if (count < kLeastPoints / 2) return false;
  const CylinderFrame f = points_.frame(c);
  double square = 0, error = 0;
  std::size_t normals = 0;
  for (const std::uint32_t i : points_.selected()) {
    const double distance = points_.distance(i);
    square += (distance - c.radius) * (distance - c.radius);
    double component = 0;
    if (c.radius <= kNormalFrom || !(distance > 0) || !points_.outward(i, f, component)) continue;
    error += std::acos(std::clamp(component / distance, -1.0, 1.0));
    ++normals;
  }
  e.residual = std::sqrt(square / static_cast<double>(count));
  e.arc = arc_of(points_.taken(), c, f.ahead);
  e.normal_error = normals ? error / static_cast<double>(normals) : 0;
  if (conditions_.normal_error && normals) e.normal_error = *conditions_.normal_error;
  if (kind != Kind::kStrap && ((conditions_.least_arc && e.arc < kLeastArc) || e.normal_error > kMostNormalError)) {
    return false;
  }
  e.inner = inner / static_cast<double>(count), e.outer = outer / static_cast<double>(count);
  e.corner_gain = conditions_.corner_gain ? *conditions_.corner_gain : corner_gain(e.residual);

  Handle& handle = found.handle;
  handle.affordances.clear();
  double radius_sum = 0, radius_square = 0;
  e.axis_spread = 0;
  for (const std::uint32_t i : group.members) {
    const Affordance& a = affordances[i];
    const double height = dot(a.center - c.point, c.axis);
    if (height < begin - kSlice || height > end + kSlice) continue;
    handle.affordances.push_back(i);
    const double cosine = dot(a.axis, c.axis);
    e.axis_spread += std::sqrt(std::max(0.0, 1 - cosine * cosine));
    radius_sum += a.radius, radius_square += a.radius * a.radius;
  }
  e.members = static_cast<double>(handle.affordances.size());
  if (handle.affordances.empty()) return false;
  const double mean_radius = radius_sum / e.members;
  e.radius_spread = std::sqrt(std::max(0.0, radius_square / e.members - mean_radius * mean_radius)) / c.radius;
  e.axis_spread /= e.members;

  // A strap is flatter than any cylinder through it: what is seen of it across the axis tells its size.
  if (kind != Kind::kStrap) find_outline(c, low, n);
  const std::array<double, 2> steps = sum_outline(best_first, best_first + best_length, c.radius, e);
  usual_.clear();
  for (const std::uint32_t i : points_.selected()) usual_.push_back(points_.side(i));
  std::sort(usual_.begin(), usual_.end());
  const double half_pixel = 0.5 * norm(image_->viewpoint() - c.point) / image_->focal();
  const double left = std::min(usual_[count * 2 / 100] - half_pixel, -steps[1]);
  const double right = std::max(usual_[count - 1 - count * 2 / 100] + half_pixel, steps[0]);
  const double half_width = 0.5 * (right - left);
  const bool strap = kind != Kind::kStrap && half_width < (c.radius < kThickStrap ? kStrap : kThickShare) * c.radius;
  handle.center = c.point + middle * c.axis;
  if (strap) handle.center = handle.center + 0.5 * (left + right) * f.side + (c.radius - half_width) * f.ahead;
  handle.axis = canonical_axis(c.axis);
  handle.approach = -1.0 * from;
  handle.radius = strap ? half_width : c.radius;
  handle.length = length;
  handle.arc = e.arc, handle.residual = e.residual, handle.observed_free = best_free;
  handle.normal_error = e.normal_error;
  e.strap = kind == Kind::kStrap ? 1 : 0;
  e.length = length, e.radius = handle.radius, e.sigma = sigma_, e.free = best_free;
  e.followed = length, e.turn = e.off_middle = e.off_direction = 0;
  if (conditions_.bows) follow(group.bow, found);
  if (!conditions_.outline) forget_outline(e);
  handle.confidence = confidence(e);
  return true;
}

/// How far the part goes on around its bends; the handle of a bow gets its path.
void PartCheck::follow(const Bow* known, PartCandidate& found) {
  Handle& h = found.handle;
  Evidence& e = found.evidence;
  e.followed = 0;
  const Bow* bow = known;
  if (!bow && trace_bow(*image_, {h.center, h.axis, h.radius}, sigma_, bow_scratch_, bow_)) bow = &bow_;
  if (!bow) return;
  e.followed = bow->closed ? 1 : std::min(bow->length, 1.0), e.turn = bow->turn;
  const std::size_t at = nearest_place(bow->path, h.center), middle = bow->path.size() / 2;
  e.off_middle = kBowStep * std::fabs(static_cast<double>(at) - static_cast<double>(middle));
  e.off_direction = std::acos(std::min(1.0, std::fabs(dot(bow->tangent(at), bow->tangent(middle)))));
  if (!known) return;
  h.path.clear();
  for (std::size_t i = 0; i < known->path.size(); ++i) {
    const Vector3 t = known->tangent(i), to_sensor = image_->viewpoint() - known->path[i];
    const Vector3 ahead = normalized(to_sensor - dot(to_sensor, t) * t, any_perpendicular(t));
    h.path.push_back(known->path[i] - h.radius * ahead);
  }
}

void PartCheck::run(const PartGroup& group, const std::vector<Affordance>& affordances,
                    Recycled<PartCandidate>& found) {
  Cylinder c = group.mean;
  double low = group.low, high = group.high;
  sigma_ = depth_noise(norm(image_->viewpoint() - c.point));
  if (sigma_ > kMostNoise * c.radius) return;
  points_.gather(c, low - kExtension, high + kExtension, sigma_);
  if (conditions_.straps && 2 * group.straps >= group.members.size()) {
    PartCandidate& candidate = found.next();
    candidate.clear();
    if (!measure_strap(group, affordances, candidate)) found.drop_last();
  }
  if (group.bow) return;
  for (int pass = 0; pass < 2; ++pass) {
    if (points_.select(c, low, high) < kLeastPoints) return;
    Cylinder fit = c;
    if (conditions_.refit) refine_cylinder(points_.taken(), sigma_, kSteps, fit);
    if (!adopt(fit, 0.9, 0.35 * c.radius + 0.003, c)) break;
  }
  if (c.radius < kThinnest) return;
  low -= kExtension, high += kExtension;
  const auto n = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil((high - low) / kSlice)));
  if (!find_pieces(c, low, n)) return;
  const bool cut = pieces_.size() > 1;
  for (const ProfilePiece& piece : pieces_) {
    const double from = low + static_cast<double>(piece.first) * kSlice,
                 to = low + static_cast<double>(piece.last) * kSlice;
    if (to - from < options_->handle_min_length - 1e-9) continue;
    Cylinder own = c;
    if (cut) own.radius = radius_of(piece);
    if (!(own.radius > 0)) continue;
    PartCandidate& candidate = found.next();
    candidate.clear();
    if (!measure(own, from, to, cut ? Kind::kPiece : Kind::kWhole, group, affordances, candidate)) {
      found.drop_last();
      continue;
    }
    candidate.ends_low = &piece != &pieces_.front(), candidate.ends_high = &piece != &pieces_.back();
    if (dot(candidate.handle.axis, c.axis) < 0) std::swap(candidate.ends_low, candidate.ends_high);
  }
}

}  // namespace handhold
