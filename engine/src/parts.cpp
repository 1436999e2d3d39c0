#include "parts.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "kernels.h"

namespace handhold {
namespace {

// Members of a group, relative to the seed's radius r.
constexpr double kCosAlign = 0.9396926207859084;  // 20 degrees
constexpr double kOffsetShare = 0.35, kOffset = 0.003;
constexpr double kRadiusShare = 0.3, kRadius = 0.002;
constexpr double kMemberGap = 0.012;  ///< m
constexpr int kMostUses = 2;          ///< a member of so many groups starts no other one
constexpr double kReach = 0.25;       ///< m; members lie within this of the seed along its axis
// The fit to the points.
constexpr std::size_t kMostPoints = 400;
constexpr double kCosNormal = 0.6427876096865394;  ///< points whose normal is farther from radial are another surface's
constexpr double kNormalFrom = 0.010;              ///< m; thinner parts have no reliable normals
constexpr double kNormalBall = 0.008;              ///< m
constexpr double kExtension = 0.02;                ///< m; how far beyond its members a part may go on
// Slices.
constexpr double kSlice = 0.005;       ///< m
constexpr double kLeastDensity = 0.4;  ///< of the median slice
constexpr double kLeastCover = 1.047;  ///< rad
constexpr double kRmsShare = 0.06;
constexpr double kLeastArc = 1.2217;       ///< rad
constexpr double kMostNormalError = 0.55;  ///< rad
constexpr double kThinnest = 0.004;        ///< m

constexpr double kStrap = 0.8;  ///< of a cylinder's radius: seen narrower than this it is none

constexpr double kCosContinue = 0.9659258262890683;  ///< 15 degrees
constexpr double kContinueGap = 0.06;                ///< m

enum Fate : std::uint8_t { kNotAligned, kUnconfirmed, kLowConfidence, kInHandle };

/// Probability that a handle is right: a logistic model of what was measured about it, fitted to the handles of 150
/// random simulated scenes (`handhold simulate --random 150 --seed 5000 --families tuning`) with their truth.
double confidence(const Handle& h, double sigma, std::size_t members) {
  const double noise = 1e3 * sigma;                               // mm
  const double thin = std::max(0.0, std::log(0.014 / h.radius));  // normals of thin parts tell less
  const double x = 8.6015 - 0.1658 * std::log(h.length / 0.02) + 0.776 * h.arc - 3.3898 * h.residual / sigma +
                   4.5707 * h.residual / h.radius + 0.7421 * h.observed_free - 26.1383 * h.normal_error -
                   1.3481 * noise + 2.8117 * std::log(h.radius / 0.02) +
                   0.7588 * std::log(static_cast<double>(members)) + 2.1713 * h.normal_error * noise - 1.6349 * thin +
                   10.6271 * thin * h.normal_error;
  return 1 / (1 + std::exp(-x));
}

/// Whether h goes on where g ends, or lies within it: pieces of one part that clutter or noise cut.
bool continues(const Handle& g, const Handle& h) {
  if (std::fabs(dot(g.axis, h.axis)) < kCosContinue) return false;
  if (std::fabs(g.radius - h.radius) > kRadiusShare * std::max(g.radius, h.radius) + kRadius) return false;
  const Vector3 d = h.center - g.center;
  const double along = dot(d, g.axis), offset = 0.5 * std::min(g.radius, h.radius) + kOffset;
  if (norm(d - along * g.axis) > offset || norm(d - dot(d, h.axis) * h.axis) > offset) return false;
  return std::fabs(along) - 0.5 * (g.length + h.length) <= kContinueGap;
}

/// Makes g as long as both.
void extend(Handle& g, const Handle& h) {
  const double along = dot(h.center - g.center, g.axis);
  const double low = std::min(-0.5 * g.length, along - 0.5 * h.length);
  const double high = std::max(0.5 * g.length, along + 0.5 * h.length);
  g.center = g.center + 0.5 * (low + high) * g.axis;
  g.length = high - low;
  std::vector<std::uint32_t> members;
  std::set_union(g.affordances.begin(), g.affordances.end(), h.affordances.begin(), h.affordances.end(),
                 std::back_inserter(members));
  g.affordances = std::move(members);
}

}  // namespace

/// Normal by the plane of least squares through the points around; zero when there are too few.
const Vector3& PartSearch::normal_of(std::uint32_t id, const float* p, Worker& w) const {
  const auto [at, is_new] = w.normals.try_emplace(id);
  Vector3& n = at->second;
  if (!is_new) return n;
  const auto capacity = static_cast<std::size_t>(w.around.view().padded) * 256 + 16;
  w.x.require(capacity), w.y.require(capacity), w.z.require(capacity);
  const int count = kernels::kernels().collect(tiles_->view(), w.around.view(), p, static_cast<float>(kNormalBall),
                                               nullptr, w.x.data(), w.y.data(), w.z.data());
  if (count < 8) return n;
  float sum[9] = {};
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const float x = w.x[i], y = w.y[i], z = w.z[i];
    sum[0] += x, sum[1] += y, sum[2] += z;
    sum[3] += x * x, sum[4] += x * y, sum[5] += x * z, sum[6] += y * y, sum[7] += y * z, sum[8] += z * z;
  }
  const float inverse = 1.0f / static_cast<float>(count);
  const float mx = sum[0] * inverse, my = sum[1] * inverse, mz = sum[2] * inverse;
  Eigen::Matrix3d C;
  C(0, 0) = static_cast<double>(sum[3] * inverse - mx * mx);
  C(1, 0) = C(0, 1) = static_cast<double>(sum[4] * inverse - mx * my);
  C(2, 0) = C(0, 2) = static_cast<double>(sum[5] * inverse - mx * mz);
  C(1, 1) = static_cast<double>(sum[6] * inverse - my * my);
  C(2, 1) = C(1, 2) = static_cast<double>(sum[7] * inverse - my * mz);
  C(2, 2) = static_cast<double>(sum[8] * inverse - mz * mz);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(C * 1e4);
  const Eigen::Vector3d v = solver.eigenvectors().col(0);
  const Vector3 to_sensor =
      image_->viewpoint() - Vector3{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  n = Vector3{v[0], v[1], v[2]};
  if (dot(n, to_sensor) < 0) n = -1.0 * n;
  return n;
}

/// Points between `low` and `high` along the axis whose distance from it is the radius to within `tolerance` (m), on
/// the side that the sensor sees; with `by_normal` those whose normal points away from the axis.
void PartSearch::take_points(const Cylinder& c, double low, double high, double tolerance, bool by_normal,
                             Worker& w) const {
  float box[6];
  const Vector3 a = c.point + low * c.axis, b = c.point + high * c.axis;
  for (std::size_t k = 0; k < 3; ++k) {
    box[k] = static_cast<float>(std::min(a[k], b[k])), box[3 + k] = static_cast<float>(std::max(a[k], b[k]));
  }
  const auto reach = static_cast<float>(c.radius + tolerance);
  w.near.fill(*tiles_, *index_, box, box + 3, reach);
  w.around.fill(*tiles_, *index_, box, box + 3, reach + static_cast<float>(kNormalBall));
  const kernels::Tiles tiles = tiles_->view();
  const kernels::Candidates near = w.near.view();
  const Vector3 to_sensor = image_->viewpoint() - c.point;
  const Vector3 ahead = normalized(to_sensor - dot(to_sensor, c.axis) * c.axis, any_perpendicular(c.axis));
  const double least = std::max(0.0, c.radius - tolerance), most = c.radius + tolerance;
  std::vector<std::uint32_t>& found = w.found;
  found.clear();
  for (std::int32_t i = 0; i < near.padded; ++i) {
    if (near.boxes[0][i] >= kernels::kFar) continue;
    for (std::uint32_t t = 0; t < kernels::kBlockTiles; ++t) {
      const std::uint32_t tile = near.block[i] * kernels::kBlockTiles + t;
      const float* p = tiles.points + static_cast<std::size_t>(tile) * 48;
      for (std::uint32_t k = 0; k < kernels::kTilePoints; ++k) {
        if (!(p[k] < kernels::kFar)) continue;
        const Vector3 d =
            Vector3{static_cast<double>(p[k]), static_cast<double>(p[16 + k]), static_cast<double>(p[32 + k])} -
            c.point;
        const double height = dot(d, c.axis);
        if (height < low || height > high) continue;
        const Vector3 across = d - height * c.axis;
        const double distance2 = dot(across, across);
        if (distance2 < least * least || distance2 > most * most) continue;
        if (dot(across, ahead) < -0.3 * std::sqrt(distance2)) continue;
        found.push_back(16 * tile + k);
      }
    }
  }
  Band& band = w.band;
  band.x.clear(), band.y.clear(), band.z.clear(), band.id.clear();
  const std::size_t stride = (found.size() + kMostPoints - 1) / kMostPoints;
  band.weight = static_cast<double>(std::max<std::size_t>(stride, 1));
  for (std::size_t i = 0; i < found.size(); i += stride) {
    const float* at = tiles.points + static_cast<std::size_t>(found[i] / 16) * 48 + found[i] % 16;
    const float p[3] = {at[0], at[16], at[32]};
    if (by_normal) {
      const Vector3& normal = normal_of(found[i], p, w);
      const Vector3 across =
          c.across({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
      if (dot(normal, normal) > 0.5 && dot(across, normal) < kCosNormal * norm(across)) continue;
    }
    band.x.push_back(p[0]), band.y.push_back(p[1]), band.z.push_back(p[2]);
    band.id.push_back(found[i]);
  }
  for (auto* coordinate : {&band.x, &band.y, &band.z}) coordinate->resize(coordinate->size() + 16);  // read in packs
}

/// Fits the cylinder to the points between low and high and beyond, and finds the longest run of slices that are of
/// one part and that the hand can hold from one direction.
bool PartSearch::confirm(const Group& group, Worker& w, Handle& handle) const {
  Cylinder c = group.mean;
  double low = group.low, high = group.high;
  w.normals.clear();
  Band& band = w.band;
  const double sigma = depth_noise(norm(image_->viewpoint() - c.point));
  const std::size_t least_points = 25;
  for (int pass = 0; pass < 2; ++pass) {
    take_points(c, low, high, 0.25 * c.radius + 2 * sigma, c.radius > kNormalFrom, w);
    if (band.id.size() < least_points) return false;
    Cylinder fit = c;
    refine_cylinder(band.arrays(), sigma, 10, fit);
    if (std::fabs(dot(fit.axis, c.axis)) < 0.9 || std::fabs(fit.radius - c.radius) > 0.35 * c.radius + 0.003) break;
    // Heights keep their origin.
    fit.point = fit.point + dot(c.point - fit.point, fit.axis) * fit.axis;
    if (dot(fit.axis, c.axis) < 0) fit.axis = -1.0 * fit.axis;
    c = fit;
  }
  if (2 * c.radius > 1.04 * options_->hand_aperture || c.radius < kThinnest) return false;
  if (2 * c.radius < options_->hand_minimum) return false;

  const double first_low = low, first_high = high;
  low -= kExtension, high += kExtension;
  take_points(c, low, high, 0.25 * c.radius + 2 * sigma, c.radius > kNormalFrom, w);
  if (band.id.size() < least_points) return false;
  const int n = std::max(1, static_cast<int>(std::ceil((high - low) / kSlice)));
  std::vector<Slice>& slices = w.slices;
  slices.assign(static_cast<std::size_t>(n), {});
  const Vector3 to_sensor = image_->viewpoint() - c.point;
  const Vector3 ahead = normalized(to_sensor - dot(to_sensor, c.axis) * c.axis, any_perpendicular(c.axis));
  const Vector3 side = cross(c.axis, ahead);
  const PointArrays points = band.arrays();
  const auto slice_of = [&](double height) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>((height - low) / kSlice), 0, n - 1));
  };
  for (std::size_t i = 0; i < points.n; ++i) {
    const Vector3 d = points[i] - c.point;
    const double height = dot(d, c.axis);
    Slice& s = slices[slice_of(height)];
    const Vector3 across = d - height * c.axis;
    const double e = norm(across) - c.radius, angle = std::atan2(dot(across, side), dot(across, ahead));
    s.count += band.weight;
    s.square += band.weight * e * e;
    s.low = std::min(s.low, angle), s.high = std::max(s.high, angle);
  }
  // What a slice of this part usually holds: how dense the cloud is here needs no other measure.
  std::vector<double> counts;
  for (int i = 0; i < n; ++i) {
    const double middle = low + (i + 0.5) * kSlice;
    if (middle > first_low && middle < first_high) counts.push_back(slices[static_cast<std::size_t>(i)].count);
  }
  if (counts.empty()) return false;
  std::nth_element(counts.begin(), counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2), counts.end());
  const double usual = counts[counts.size() / 2];
  std::vector<char> sound(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < sound.size(); ++i) {
    const Slice& s = slices[i];
    sound[i] = s.count >= std::max(1.0, kLeastDensity * usual) &&
               std::sqrt(s.square / s.count) <= kRmsShare * c.radius + sigma && s.high - s.low >= kLeastCover;
  }

  const FingerTest fingers(*options_, *image_);
  int best_length = 0, best_first = 0;
  double best_free = 0;
  Vector3 from{};
  for (int k = 0; k < FingerTest::kAngles; ++k) {
    std::vector<char> pass(static_cast<std::size_t>(n), 0);
    std::vector<double> free(static_cast<std::size_t>(n), 0);
    Vector3 towards{};
    for (int i = 0; i < n; ++i) {
      if (!sound[static_cast<std::size_t>(i)]) continue;
      const Grip grip =
          fingers.at(c.point + (low + (i + 0.5) * kSlice) * c.axis, c.axis, c.radius, kSlice, FingerTest::angle(k));
      if (!grip.fits) continue;
      pass[static_cast<std::size_t>(i)] = 1;
      free[static_cast<std::size_t>(i)] = grip.free;
      towards = grip.from;
    }
    for (std::size_t i = 1; i + 1 < pass.size(); ++i) {
      if (!pass[i] && pass[i - 1] == 1 && pass[i + 1] == 1) pass[i] = 2;
    }
    int run = 0;
    for (int i = 0; i <= n; ++i) {
      if (i < n && pass[static_cast<std::size_t>(i)]) {
        ++run;
        continue;
      }
      if (run > best_length) {
        best_length = run, best_first = i - run, from = towards;
        best_free = std::accumulate(free.begin() + best_first, free.begin() + i, 0.0) / run;
      }
      run = 0;
    }
  }
  const double length = best_length * kSlice;
  if (length < std::max(options_->handle_min_length, c.radius) - 1e-9) return false;

  const double begin = low + best_first * kSlice, middle = begin + 0.5 * length;
  double square = 0, error = 0;
  std::size_t count = 0, normals = 0;
  Band& run = w.run;
  run.x.clear(), run.y.clear(), run.z.clear(), run.id.clear();
  for (std::size_t i = 0; i < points.n; ++i) {
    const Vector3 d = points[i] - c.point;
    const double height = dot(d, c.axis);
    if (height < begin || height > begin + length) continue;
    const Vector3 across = d - height * c.axis;
    const double e = norm(across) - c.radius;
    square += e * e, ++count;
    run.x.push_back(band.x[i]), run.y.push_back(band.y[i]), run.z.push_back(band.z[i]), run.id.push_back(band.id[i]);
    const float p[3] = {band.x[i], band.y[i], band.z[i]};
    const Vector3& normal = normal_of(band.id[i], p, w);
    if (dot(normal, normal) > 0.5) {
      error += std::acos(std::clamp(dot(normalized(across), normal), -1.0, 1.0));
      ++normals;
    }
  }
  if (count < least_points / 2) return false;
  const double residual = std::sqrt(square / static_cast<double>(count));
  const double arc = arc_of(run.arrays(), c, ahead);
  if (arc < kLeastArc) return false;
  const double normal_error = normals ? error / static_cast<double>(normals) : 0;
  if (normal_error > kMostNormalError) return false;

  // A strap is flatter than any cylinder through it: what is seen of it across the axis tells its size.
  std::vector<double> widths;
  for (std::size_t i = 0; i < run.id.size(); ++i) widths.push_back(dot(run.arrays()[i] - c.point, side));
  std::sort(widths.begin(), widths.end());
  const double left = widths[widths.size() * 2 / 100], right = widths[widths.size() - 1 - widths.size() * 2 / 100];
  const double half_width = 0.5 * (right - left) + 0.5 * norm(to_sensor) / image_->focal();
  const bool strap = half_width < kStrap * c.radius;
  handle.center = c.point + middle * c.axis;
  if (strap) handle.center = handle.center + 0.5 * (left + right) * side + (c.radius - half_width) * ahead;
  handle.axis = canonical_axis(c.axis);
  handle.approach = -1.0 * from;
  handle.radius = strap ? half_width : c.radius;
  handle.length = length;
  handle.arc = arc;
  handle.residual = residual;
  handle.observed_free = best_free;
  handle.normal_error = normal_error;
  handle.confidence = confidence(handle, sigma, group.members.size());
  return true;
}

/// Of handles on the same part the best one stays; pieces of one part become one handle.
void PartSearch::remove_overlaps(std::vector<Handle>& handles) const {
  std::vector<Handle> kept;
  for (Handle& h : handles) {
    bool overlaps = false;
    for (Handle& g : kept) {
      if (continues(g, h)) {
        extend(g, h);
        overlaps = true;
        break;
      }
      const Vector3 d = h.center - g.center;
      const double along = dot(d, g.axis), cosine = std::fabs(dot(h.axis, g.axis));
      const double across = norm(d - along * g.axis), alike = cosine > 0.766 ? 1 : 0;  // 40 degrees
      const double small = std::min(h.radius, g.radius), large = std::max(h.radius, g.radius);
      const double along_h = dot(d, h.axis), across_h = norm(d - along_h * h.axis);
      overlaps = (std::fabs(along) < g.length / 2 + h.length / 2 * cosine - 0.002 + (alike > 0 ? 0.01 : -0.005) &&
                  across < large + 0.5 * small + (alike > 0 ? 0.006 : 0)) ||
                 (std::fabs(along_h) < h.length / 2 && across_h < large);
      if (overlaps) break;
    }
    if (!overlaps) kept.push_back(std::move(h));
  }
  handles = std::move(kept);
}

/// Groups about the best affordances first. An affordance may be in several: which one is right the points decide.
void PartSearch::make_groups(const std::vector<Affordance>& affordances, std::vector<Group>& groups) const {
  groups.clear();
  const std::size_t n = affordances.size();
  std::vector<std::uint8_t> uses(n, 0);
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return affordances[a].quality != affordances[b].quality ? affordances[a].quality > affordances[b].quality : a < b;
  });
  const auto least = static_cast<std::size_t>(options_->handle_min_affordances);
  std::vector<std::pair<double, std::uint32_t>> members;
  for (const std::uint32_t seed : order) {
    if (uses[seed] >= kMostUses) continue;
    const Affordance& s = affordances[seed];
    members.clear();
    for (std::uint32_t j = 0; j < n; ++j) {
      const Affordance& a = affordances[j];
      const Vector3 d = a.center - s.center;
      const double along = dot(d, s.axis);
      if (std::fabs(along) > kReach || std::fabs(dot(a.axis, s.axis)) < kCosAlign) continue;
      if (norm(d - along * s.axis) > kOffsetShare * s.radius + kOffset) continue;
      if (std::fabs(a.radius - s.radius) > kRadiusShare * s.radius + kRadius) continue;
      members.emplace_back(along, j);
    }
    if (members.size() < least) continue;
    std::sort(members.begin(), members.end());
    std::size_t at = 0;
    while (members[at].second != seed) ++at;
    std::size_t first = at, last = at;
    while (first > 0 && members[first].first - members[first - 1].first < kMemberGap) --first;
    while (last + 1 < members.size() && members[last + 1].first - members[last].first < kMemberGap) ++last;
    if (last - first + 1 < least) continue;

    Group group;
    Vector3 axis{}, center{};
    double weight = 0;
    std::vector<double> radii;
    for (std::size_t k = first; k <= last; ++k) {
      const Affordance& a = affordances[members[k].second];
      axis = axis + (dot(a.axis, s.axis) < 0 ? -a.quality : a.quality) * a.axis;
      center = center + a.quality * a.center;
      weight += a.quality;
      radii.push_back(a.radius);
      group.members.push_back(members[k].second);
      if (uses[members[k].second] < kMostUses) ++uses[members[k].second];
    }
    const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
    std::nth_element(radii.begin(), middle, radii.end());
    group.mean = {(1 / weight) * center, normalized(axis), *middle};
    group.low = std::numeric_limits<double>::infinity(), group.high = -group.low;
    for (const std::uint32_t j : group.members) {
      const double h = dot(affordances[j].center - group.mean.point, group.mean.axis);
      group.low = std::min(group.low, h - options_->finger_width / 2);
      group.high = std::max(group.high, h + options_->finger_width / 2);
    }
    std::sort(group.members.begin(), group.members.end());
    groups.push_back(std::move(group));
  }
}

void PartSearch::run(const std::vector<Affordance>& affordances, const TileStore& tiles, const NeighbourIndex& index,
                     const DepthImage& image, std::vector<Handle>& handles, Funnel& funnel) {
  tiles_ = &tiles, index_ = &index, image_ = &image;
  std::vector<Group> groups;
  make_groups(affordances, groups);
  std::vector<std::uint8_t> confirmed(groups.size(), 0);
  std::vector<Handle> found(groups.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, groups.size(), 1), [&](const auto& range) {
    Worker& worker = workers_.local();
    for (std::size_t g = range.begin(); g < range.end(); ++g) confirmed[g] = confirm(groups[g], worker, found[g]);
  });
  std::vector<std::uint8_t> fate(affordances.size(), kNotAligned);
  handles.clear();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (const std::uint32_t i : groups[g].members) fate[i] = kUnconfirmed;
    if (!confirmed[g]) continue;
    found[g].affordances = std::move(groups[g].members);
    handles.push_back(std::move(found[g]));
  }
  std::sort(handles.begin(), handles.end(), [](const Handle& a, const Handle& b) {
    return a.confidence != b.confidence ? a.confidence > b.confidence : a.affordances < b.affordances;
  });
  for (const Handle& h : handles) {
    const std::uint8_t to = h.confidence < options_->min_confidence ? kLowConfidence : kInHandle;
    for (const std::uint32_t i : h.affordances) fate[i] = std::max(fate[i], to);
  }
  remove_overlaps(handles);
  handles.erase(std::find_if(handles.begin(), handles.end(),
                             [&](const Handle& h) { return h.confidence < options_->min_confidence; }),
                handles.end());
  for (const std::uint8_t f : fate) {
    ++(f == kNotAligned      ? funnel.not_aligned
       : f == kUnconfirmed   ? funnel.unconfirmed
       : f == kLowConfidence ? funnel.low_confidence
                             : funnel.in_handles);
  }
}

}  // namespace handhold
