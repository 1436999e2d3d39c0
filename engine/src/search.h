// Lines 3 to 13 of Algorithm 1 for many samples at once.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "aligned.h"
#include "budget.h"
#include "candidate.h"
#include "conditions.h"
#include "cylinder.h"
#include "depth_image.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "index.h"
#include "kernels.h"
#include "layers.h"
#include "tiles.h"

namespace handhold {

/// No part that the default method finds has a smaller radius (m).
inline constexpr double kThinnestPart = 0.004;

/// A size of neighbourhoods, and what is too flat to be summed there: kernels::NeighbourhoodBatch::flat_rms and
/// flat_slope.
struct Scale {
  double radius;  ///< m
  float flat_rms, flat_slope;
  bool shows_rods;  ///< what is too flat here holds no part, however thin
};
/// All that the options ask for, by their radius.
std::vector<Scale> scales_of(const Options& options);

/// What a fit must show. `by_points`: the default method measures again with the points, and wants a start, not a
/// verdict.
kernels::FitLimits fit_limits(const Options& options, double radius, bool by_points,
                              const std::optional<Vector3>& viewpoint);
/// What the paper's shell must be like.
kernels::ShellLimits shell_limits(const Options& options);

/// Time spent in each step, summed over the threads (s).
struct StepSeconds {
  double neighbours = 0, moments = 0, fit = 0, shell = 0;
};

/// Looks at neighbourhoods. Samples near each other are taken together: one index query serves a group of up to 64, and
/// 16 fits are solved at once.
class Search {
 public:
  explicit Search(const Options& options, const Conditions& conditions = {});

  /// `image`: what was seen, for the default method; null or empty: the paper's shells decide, on the full cloud.
  void begin(const Layers& layers, const std::optional<Vector3>& viewpoint, const DepthImage* image = nullptr);

  /// Looks at `n` samples (xyz: 3 * n, m) in parallel. steps[i] says where sample i ended (the furthest, of several
  /// radii). Affordances are appended to `found` in the order of their samples; Affordance::sample is first + i.
  /// False: the budget was spent; steps say kCut of the samples that were not looked at to the end.
  bool run(const float* xyz, std::uint32_t n, std::uint32_t first, Step* steps, std::vector<Affordance>& found,
           const Budget& budget = {});

  /// Time of all runs since `begin`, summed over threads.
  StepSeconds seconds() const;

 private:
  static constexpr std::size_t kGroupsPerTask = 4;
  struct Group {
    std::uint32_t begin, end;  ///< in the sorted order
    float low[3], high[3];     ///< box of its samples (m)
  };
  /// What a group of a task looks at.
  struct Near {
    Layer layer;
    double share = 1;  ///< of the cloud's points in that layer
    CandidateList blocks;
    double density = 0;  ///< points of the full cloud in a ball, per square of its radius (1/m^2)
  };
  struct Candidate {
    std::uint32_t entry;  ///< of the task's samples
    Affordance affordance;
    Vector3 position;
    double residual;  ///< root of lambda, in units of the radius
    double scale;     ///< the radius (m)
    double density;   ///< points per m^2
  };
  struct Found {
    Affordance affordance;
    double residual, scale;
  };
  /// Candidates whose cylinders are tried at once, with points enough for the fit of those that pass.
  struct Trials {
    static constexpr std::size_t kLanes = 16;
    kernels::CylinderTrials batch;
    std::array<const Candidate*, kLanes> candidate;
    std::array<AlignedArray<float>, kLanes> xyz;  ///< x, y and z, one after the other
    std::array<std::size_t, kLanes> points;
    std::size_t n = 0;
  };
  struct Scratch {
    std::array<Near, kGroupsPerTask> near;
    CandidateList shells;
    AlignedArray<std::byte> kernel;
    AlignedArray<float> centres;  ///< of the group that is summed (m)
    AlignedArray<kernels::Moments> moments;
    kernels::FitBatch fit;
    std::vector<std::uint32_t> sample;  ///< of each entry of `moments`: position in the sorted order
    std::vector<std::uint32_t> group;   ///< of each entry of `moments`: position in the task
    AlignedArray<Step> reached;         ///< where each entry ended
    std::vector<double> quality;        ///< of each entry's affordance, by the default method; 0: it has none
    std::vector<int> flat;              ///< of each sample of the task: at how many scales in a row, the last ones; as
                                        ///< many as it takes when it needs no further look
    std::vector<std::uint32_t> whole;   ///< entries whose moments are valid
    std::vector<Vector3> axis;          ///< by position in `whole`, when the axis is not the quadric's
    std::vector<Candidate> candidates;
    std::vector<kernels::ShellQuery> queries;  ///< of each candidate, by the paper's method
    AlignedArray<float> x, y, z;
    Trials trials;
    std::vector<Found> found;
    StepSeconds seconds;
  };

  void sort_samples(const float* xyz, std::uint32_t n);
  void make_groups(std::uint32_t n);
  void make_tasks(std::uint32_t n);
  bool run_task(std::size_t first_group, std::size_t last_group, Step* steps, Scratch& s) const;
  bool run_scale(std::size_t first_group, std::size_t last_group, const Scale& scale, Scratch& s) const;
  void measure_density(const Group& group, Near& near, Scratch& s) const;
  void choose_layer(const Scale& scale, Near& near) const;
  bool fit(double radius, Scratch& s) const;
  bool find_shells(Scratch& s) const;
  bool find_cylinders(double radius, Scratch& s) const;
  Step refuse(const Vector3& position, double ball, double rms, double sigma, double slack, Cylinder& cylinder) const;
  bool find_strap(std::uint32_t at, Found& found) const;
  void judge(const Candidate& candidate, double radius, Scratch& s) const;
  void run_trials(double radius, Scratch& s) const;
  Step fit_cylinder(const Candidate& candidate, double radius, const PointArrays& points, Cylinder cylinder,
                    Found& found) const;
  void settle(const Candidate& candidate, double radius, const PointArrays& points, const Cylinder& cylinder,
              Scratch& s) const;

  const Options* options_;
  Conditions conditions_;
  Budget budget_;  ///< of the run; what returns false found it spent
  const Layers* layers_ = nullptr;
  const DepthImage* image_ = nullptr;  ///< not null: the default method
  std::optional<Vector3> viewpoint_;
  std::vector<Scale> scales_;  ///< by their radius
  AlignedArray<float> normals_;
  AlignedArray<std::uint64_t> keys_, other_keys_;
  AlignedArray<float> sorted_;          ///< xyz in the sorted order
  AlignedArray<std::uint32_t> number_;  ///< sorted order -> sample
  std::vector<Group> groups_;
  std::vector<std::size_t> tasks_;  ///< the first group of each, and the end
  std::vector<const Found*> best_;  ///< of each sample; null: none
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace handhold
