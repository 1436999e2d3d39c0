#include "search.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <tuple>

#include "axis.h"
#include "morton.h"
#include "radix_sort.h"
#include "vec3.h"

namespace handhold {
namespace {

constexpr double kPi = 3.14159265358979323846;
/// A round is cut into about so many tasks, but fits are solved in batches: a task has at least kLeastTask samples.
constexpr std::uint32_t kTasks = 16, kLeastTask = 32;
/// Points that a neighbourhood of the thinned cloud should hold, and those without which there is no quadric. With 150
/// of them the handles are no better.
constexpr double kEnoughPoints = 50;
constexpr int kLeastOfFit = 10;
/// A sample whose curvature is too low at so many radii in a row, from the largest on, is not looked at any closer: 3 %
/// of such samples have an affordance at a smaller radius, and the handles are as right without them. As right are they
/// when a sample that has an affordance of this quality is not looked at any closer.
constexpr int kFlatScales = 2;
constexpr double kGoodQuality = 0.25;
constexpr std::uint32_t kStrapsAtOnce = 8;  ///< between two looks at the clock

class Stopwatch {
 public:
  Stopwatch() : last_(Clock::now()) {}
  /// Adds the time since the last call.
  void lap(double& seconds) {
    const auto now = Clock::now();
    seconds += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_;
};

/// Frame of the cloud to frame of the moments.
Vector3 to_frame(const double* R_frame_cloud, const Vector3& v) {
  Vector3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) out[i] += R_frame_cloud[3 * i + j] * v[j];
  return out;
}

/// Part of the residual of a cylinder as wide as the hand that still counts as flat. Over eight frames of 20,000
/// samples 0.8 lost none of 4743 affordances, 0.9 one, 1.0 five; over half of all samples lie on tables and boxes and
/// end here, before their points are summed.
constexpr double kFlatShare = 0.8;

/// Root mean square distance from its plane of least squares that a patch of a cylinder of radius `curvature` leaves,
/// where a ball of `radius` about a point of its surface cuts it out (m).
double cylinder_residual(double curvature, double radius) {
  double n = 0, sum = 0, sum2 = 0;
  const double widest = 2 * std::asin(std::min(1.0, radius / (2 * curvature)));
  for (int i = -200; i <= 200; ++i) {
    const double angle = widest * i / 200;
    const double chord = 2 * curvature * std::sin(angle / 2);
    // Length of the patch along the cylinder at this angle, and its height under the tangent plane.
    const double length = std::sqrt(std::max(0.0, radius * radius - chord * chord)),
                 height = curvature * (1 - std::cos(angle));
    n += length, sum += length * height, sum2 += length * height * height;
  }
  return std::sqrt(std::max(0.0, sum2 / n - sum / n * (sum / n)));
}

/// About the same of a ball about a rod of radius `rod` that lies on a plane (m).
double rod_residual(double rod, double radius) {
  const double share = std::min(1.0, 4 * rod / (kPi * radius));
  return 2 * rod * std::sqrt(share * (1 - share));
}

}  // namespace

std::vector<Scale> scales_of(const Options& options) {
  // Only a fitted circle within the aperture goes on, so nothing flatter than a cylinder of that width is worth a sum.
  // A strip whose points have the variance v across leaves 2 v / sqrt(5) / (2 curvature) = 0.894 v / (2 curvature).
  const double widest = std::min(options.hand_aperture / 2, options.effective_reach());
  std::vector<double> radii = options.effective_radius();
  std::sort(radii.begin(), radii.end());
  std::vector<Scale> scales;
  for (const double radius : radii) {
    const double flat = kFlatShare * cylinder_residual(widest, radius);
    scales.push_back({radius, static_cast<float>(flat), static_cast<float>(kFlatShare * 0.894 / (2 * widest)),
                      flat < rod_residual(kThinnestPart, radius)});
  }
  return scales;
}

kernels::FitLimits fit_limits(const Options& options, double radius, bool by_points,
                              const std::optional<Vector3>& viewpoint) {
  const double slack = by_points ? 1.5 : 1;
  kernels::FitLimits limits{};
  limits.radius = radius;
  limits.least_curvature = radius / (slack * options.effective_reach());
  limits.widest = slack * options.hand_aperture, limits.narrowest = options.hand_minimum, limits.slack = slack;
  if (viewpoint) {
    limits.seen_from = 1;
    std::copy_n(viewpoint->data(), 3, limits.viewpoint);
  }
  return limits;
}

Search::Search(const Options& options, const Conditions& conditions)
    : options_(&options), conditions_(conditions), scales_(scales_of(options)) {}

void Search::begin(const Layers& layers, const std::optional<Vector3>& viewpoint, const DepthImage* image) {
  image_ = image && !image->empty() ? image : nullptr;
  layers_ = &layers;
  viewpoint_ = viewpoint;
  for (Scratch& s : scratch_) s.seconds = {};
  if (options_->axis == AxisEstimator::kNormals) {
    estimate_normals(*layers[0].tiles, *layers[0].index, static_cast<float>(options_->effective_radius().front() / 2),
                     normals_);
  }
}

StepSeconds Search::seconds() const {
  StepSeconds sum;
  for (const Scratch& s : scratch_) {
    sum.neighbours += s.seconds.neighbours;
    sum.moments += s.seconds.moments;
    sum.fit += s.seconds.fit;
    sum.shell += s.seconds.shell;
  }
  return sum;
}

/// Sorts samples along the Morton curve, in cells of 12.5 mm where 7 bits a coordinate cover the cloud.
void Search::sort_samples(const float* xyz, std::uint32_t n) {
  const TileStore& tiles = *(*layers_)[0].tiles;
  const float *low = tiles.robust_low(), *high = tiles.robust_high();
  const float cell = std::max(0.0125f, std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}) / 120.0f);
  const float per_cell = 1.0f / cell;
  keys_.require(n);
  other_keys_.require(n);
  sorted_.require(3 * static_cast<std::size_t>(n));
  number_.require(n);
  const tbb::blocked_range<std::uint32_t> all(0, n, 2048);
  tbb::parallel_for(all, [&](const auto& range) {
    for (std::uint32_t i = range.begin(); i < range.end(); ++i) {
      const float* p = xyz + 3 * static_cast<std::size_t>(i);
      std::uint32_t c[3];
      for (int k = 0; k < 3; ++k) {
        c[k] = static_cast<std::uint32_t>(std::clamp((p[k] - low[k]) * per_cell + 3.0f, 0.0f, 127.0f));
      }
      keys_[i] = morton3(c[0], c[1], c[2]) << 32 | i;
    }
  });
  const std::uint64_t* sorted = radix_sort(keys_.data(), other_keys_.data(), n, 32, 21);
  tbb::parallel_for(all, [&](const auto& range) {
    for (std::uint32_t i = range.begin(); i < range.end(); ++i) {
      const auto from = static_cast<std::uint32_t>(sorted[i]);
      number_[i] = from;
      std::memcpy(&sorted_[3 * static_cast<std::size_t>(i)], xyz + 3 * static_cast<std::size_t>(from),
                  3 * sizeof(float));
    }
  });
}

/// Runs of at most 64 samples whose box stays within four times the largest radius.
void Search::make_groups(std::uint32_t n) {
  const double widest = scales_.back().radius;
  const auto limit2 = static_cast<float>(16 * widest * widest);
  groups_.clear();
  for (std::uint32_t i = 0; i < n;) {
    Group g{i, i + 1, {}, {}};
    for (std::size_t k = 0; k < 3; ++k) g.low[k] = g.high[k] = sorted_[3 * static_cast<std::size_t>(i) + k];
    for (; g.end < n && g.end - g.begin < kernels::kMaxGroup; ++g.end) {
      float low[3], high[3], d2 = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const float x = sorted_[3 * static_cast<std::size_t>(g.end) + k];
        low[k] = std::min(g.low[k], x), high[k] = std::max(g.high[k], x);
        d2 += (high[k] - low[k]) * (high[k] - low[k]);
      }
      if (d2 > limit2) break;
      std::copy(low, low + 3, g.low), std::copy(high, high + 3, g.high);
    }
    groups_.push_back(g);
    i = g.end;
  }
}

/// Runs of up to kGroupsPerTask groups.
void Search::make_tasks(std::uint32_t n) {
  const std::uint32_t enough = std::max(kLeastTask, n / kTasks);
  tasks_.clear();
  for (std::size_t g = 0; g < groups_.size();) {
    tasks_.push_back(g);
    const std::uint32_t begin = groups_[g].begin;
    const std::size_t last = std::min(groups_.size(), g + kGroupsPerTask);
    while (g < last && groups_[g].begin - begin < enough) ++g;
  }
  tasks_.push_back(groups_.size());
}

bool Search::run(const float* xyz, std::uint32_t n, std::uint32_t first, Step* steps, std::vector<Affordance>& found,
                 const Budget& budget) {
  budget_ = budget;
  std::atomic<bool> done{true};
  sort_samples(xyz, n);
  make_groups(n);
  make_tasks(n);
  std::fill(steps, steps + n, Step::kTooFewPoints);
  for (Scratch& s : scratch_) s.found.clear();
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, tasks_.size() - 1, 1),
      [&](const auto& range) {
        Scratch& s = scratch_.local();
        for (std::size_t t = range.begin(); t < range.end(); ++t) {
          const std::size_t before = s.found.size();
          if (run_task(tasks_[t], tasks_[t + 1], steps, s)) continue;
          // What was begun is as if it had not been.
          s.found.erase(s.found.begin() + static_cast<std::ptrdiff_t>(before), s.found.end());
          for (std::uint32_t i = groups_[tasks_[t]].begin; i < groups_[tasks_[t + 1] - 1].end; ++i)
            steps[number_[i]] = Step::kCut;
          done.store(false, std::memory_order_relaxed);
        }
      },
      tbb::simple_partitioner());
  // In the order of the samples; of several radii the one whose quadric fits best for its size explains the place.
  best_.assign(n, nullptr);
  for (const Scratch& s : scratch_) {
    for (const Found& f : s.found) {
      const Found*& best = best_[f.affordance.sample];
      if (!best || std::tie(f.residual, f.scale) < std::tie(best->residual, best->scale)) best = &f;
    }
  }
  for (const Found* best : best_) {
    if (!best) continue;
    found.push_back(best->affordance);
    found.back().sample += first;
  }
  return done;
}

/// All scales of some groups. A sample's step is the furthest that it came to.
bool Search::run_task(std::size_t first_group, std::size_t last_group, Step* steps, Scratch& s) const {
  s.kernel.require(kernels::scratch_bytes(static_cast<std::int32_t>((*layers_)[0].tiles->blocks())));
  s.moments.require(kGroupsPerTask * kernels::kMaxGroup);
  s.centres.require(3 * kernels::kMaxGroup);
  s.reached.require(kGroupsPerTask * kernels::kMaxGroup);
  s.flat.assign(groups_[last_group - 1].end - groups_[first_group].begin, 0);
  for (std::size_t g = first_group; g < last_group; ++g) {
    if (budget_.spent()) return false;
    measure_density(groups_[g], s.near[g - first_group], s);
  }
  // The largest one first: where it is flat, the smaller ones need not be looked at.
  for (auto scale = scales_.rbegin(); scale != scales_.rend(); ++scale) {
    for (std::size_t g = first_group; g < last_group; ++g) choose_layer(*scale, s.near[g - first_group]);
    if (!run_scale(first_group, last_group, *scale, s)) return false;
    for (std::size_t k = 0; k < s.sample.size(); ++k) {
      Step& step = steps[number_[s.sample[k]]];
      step = std::max(step, s.reached[k]);
      int& flat = s.flat[s.sample[k] - groups_[first_group].begin];
      flat = s.reached[k] == Step::kCurvatureLow ? flat + (scale->shows_rods && s.moments[k].skipped ? kFlatScales : 1)
             : s.quality[k] >= kGoodQuality      ? kFlatScales
                                                 : 0;
    }
  }
  if (!image_ || !conditions_.straps) return true;
  Stopwatch watch;
  for (std::uint32_t i = groups_[first_group].begin; i < groups_[last_group - 1].end; ++i) {
    Found found;
    if (i % kStrapsAtOnce == 0 && budget_.spent()) return false;
    if (steps[number_[i]] == Step::kAffordance || !find_strap(i, found)) continue;
    steps[number_[i]] = Step::kAffordance;
    s.found.push_back(found);
  }
  watch.lap(s.seconds.shell);
  return true;
}

/// Points of the full cloud per square of a ball's radius, from three of the group's samples; 0: thinning is not
/// wanted.
void Search::measure_density(const Group& group, Near& near, Scratch& s) const {
  near.density = 0;
  // Normals are those of the full cloud's points.
  if (!image_ || layers_->size() == 1 || options_->axis == AxisEstimator::kNormals) return;
  const auto [tiles, index] = (*layers_)[0];
  const auto radius = static_cast<float>(scales_.front().radius);
  near.blocks.fill(*tiles, *index, group.low, group.high, radius);
  const auto capacity = static_cast<std::size_t>(near.blocks.view().padded) * 256 + 16;
  s.x.require(capacity), s.y.require(capacity), s.z.require(capacity);
  int points = 0;
  for (const std::uint32_t i : {group.begin, group.begin + (group.end - group.begin) / 2, group.end - 1}) {
    points += kernels::kernels().collect(tiles->view(), near.blocks.view(), &sorted_[3 * static_cast<std::size_t>(i)],
                                         radius, nullptr, s.x.data(), s.y.data(), s.z.data());
  }
  near.density = points / (3.0 * static_cast<double>(radius) * static_cast<double>(radius));
}

/// The thinnest layer that has enough points.
void Search::choose_layer(const Scale& scale, Near& near) const {
  std::size_t i = 0;
  for (double points = near.density * scale.radius * scale.radius / 4;
       points >= kEnoughPoints && i + 1 < layers_->size(); ++i)
    points /= 4;
  near.layer = (*layers_)[i];
  near.share = 1.0 / static_cast<double>(1u << 2 * i);
}

bool Search::run_scale(std::size_t first_group, std::size_t last_group, const Scale& scale, Scratch& s) const {
  const kernels::Kernels& k = kernels::kernels();
  s.sample.clear();
  s.group.clear();
  s.whole.clear();
  s.axis.clear();
  s.candidates.clear();
  const std::uint32_t first = groups_[first_group].begin;
  Stopwatch watch;
  for (std::size_t g = first_group; g < last_group; ++g) {
    const Group& group = groups_[g];
    Near& near = s.near[g - first_group];
    const TileStore& tiles = *near.layer.tiles;
    const auto at = static_cast<std::uint32_t>(s.sample.size());
    for (std::uint32_t i = group.begin; i < group.end; ++i) {
      if (image_ && s.flat[i - first] >= kFlatScales) continue;
      std::copy_n(&sorted_[3 * static_cast<std::size_t>(i)], 3, &s.centres[3 * (s.sample.size() - at)]);
      s.sample.push_back(i);
      s.group.push_back(static_cast<std::uint32_t>(g - first_group));
    }
    const auto n = static_cast<std::int32_t>(s.sample.size() - at);
    if (n == 0) continue;
    if (budget_.spent()) return false;
    near.blocks.fill(tiles, *near.layer.index, group.low, group.high, static_cast<float>(scale.radius));
    watch.lap(s.seconds.neighbours);
    // Of a thinned layer's points a fit needs as many as of any, but no more than their share of what the user wants.
    const int least = std::max(kLeastOfFit, static_cast<int>(std::ceil(options_->min_neighbours * near.share)));
    k.moments(tiles.view(), near.blocks.view(),
              {s.centres.data(), n, static_cast<float>(scale.radius), scale.flat_rms, least, scale.flat_slope},
              s.kernel.data(), &s.moments[at]);
    for (std::uint32_t entry = at; entry < s.sample.size(); ++entry) {
      const std::uint32_t i = s.sample[entry];
      const kernels::Moments& m = s.moments[entry];
      if (m.skipped) {
        s.reached[entry] = m.count < least ? Step::kTooFewPoints : Step::kCurvatureLow;
        continue;
      }
      s.whole.push_back(entry);
      if (options_->axis == AxisEstimator::kPca) s.axis.push_back(axis_from_spread(m));
      if (options_->axis == AxisEstimator::kNormals) {
        s.axis.push_back(to_frame(m.R_frame_cloud, axis_from_normals(tiles, near.blocks.view(), normals_.data(),
                                                                     &sorted_[3 * static_cast<std::size_t>(i)],
                                                                     static_cast<float>(scale.radius))));
      }
    }
    watch.lap(s.seconds.moments);
  }
  s.quality.assign(s.sample.size(), 0);
  if (!fit(scale.radius, s)) return false;
  watch.lap(s.seconds.fit);
  const bool done = image_ ? find_cylinders(scale.radius, s) : find_shells(s);
  watch.lap(s.seconds.shell);
  return done;
}

/// Quadric, curvature and circle of the chunk's neighbourhoods; what passes becomes a candidate.
bool Search::fit(double radius, Scratch& s) const {
  const kernels::Kernels& k = kernels::kernels();
  kernels::FitBatch& f = s.fit;
  const kernels::FitLimits limits = fit_limits(*options_, radius, image_, viewpoint_);
  for (std::size_t first = 0; first < s.whole.size(); first += kernels::kBatch) {
    const std::size_t n = std::min<std::size_t>(kernels::kBatch, s.whole.size() - first);
    if (budget_.spent()) return false;
    f.idle = static_cast<std::int32_t>(kernels::kBatch - n);
    for (std::size_t lane = 0; lane < kernels::kBatch; ++lane) {
      const kernels::Moments& m = s.moments[s.whole[first + (lane < n ? lane : 0)]];
      for (std::size_t j = 0; j < kernels::kMoments; ++j) f.moments[j][lane] = m.sum[j];
    }
    k.taubin(f);
    k.curvature(f);
    if (!s.axis.empty()) {
      for (std::size_t lane = 0; lane < n; ++lane)
        for (std::size_t j = 0; j < 3; ++j) f.axis[j][lane] = s.axis[first + lane][j];
    }
    k.circle(f);
    for (std::size_t lane = 0; lane < n; ++lane) {
      const std::uint32_t entry = s.whole[first + lane], at = s.sample[entry];
      const kernels::Moments& m = s.moments[entry];
      Step& step = s.reached[entry];
      const double circle_radius = f.circle_radius[lane] * radius;
      const kernels::End end =
          kernels::judge_fit(limits, f.status[lane] == kernels::kFitFlat, f.kappa_median[lane], circle_radius);
      if (end != kernels::kEndAffordance) {
        step = static_cast<Step>(end);
        continue;
      }
      Candidate c;
      c.entry = entry;
      const float* p = &sorted_[3 * static_cast<std::size_t>(at)];
      c.position = {p[0], p[1], p[2]};
      Affordance& a = c.affordance;
      a.sample = number_[at];
      const auto vector = [lane](const double(*v)[kernels::kBatch]) {
        return Vector3{v[0][lane], v[1][lane], v[2][lane]};
      };
      const Vector3 centre = vector(f.circle_centre), axis = vector(f.axis), normal = vector(f.centre_normal);
      const kernels::Place place =
          kernels::place_fit(limits, c.position.data(), m.R_frame_cloud, centre.data(), axis.data(), normal.data());
      std::copy_n(place.center, 3, a.center.data()), std::copy_n(place.axis, 3, a.axis.data());
      std::copy_n(place.normal, 3, a.normal.data());
      a.radius = circle_radius;
      a.neighbourhood = radius;
      a.curvature = f.kappa_median[lane] / radius;
      c.residual = std::sqrt(f.lambda[lane]);
      c.scale = radius;
      c.density = kernels::ball_density(m.count, radius);
      s.candidates.push_back(c);
    }
  }
  return true;
}

}  // namespace handhold
