// Lines 3 to 13 of Algorithm 1 for many samples at once.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "aligned.h"
#include "conditions.h"
#include "cylinder.h"
#include "depth_image.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "index.h"
#include "kernels.h"
#include "tiles.h"

namespace handhold {

/// Time spent in each step, summed over the threads (s).
struct StepSeconds {
  double neighbours = 0, moments = 0, fit = 0, shell = 0;
};

/// Looks at neighbourhoods. Samples near each other are taken together: one index query serves a group of up to 64, and
/// 16 fits are solved at once.
class Search {
 public:
  explicit Search(const Options& options, const Conditions& conditions = {});

  /// `image`: what was seen, for the default method; null or empty: the paper's shells decide.
  void begin(const TileStore& tiles, const NeighbourIndex& index, const std::optional<Vector3>& viewpoint,
             const DepthImage* image = nullptr);

  /// Looks at `n` samples (xyz: 3 * n, m) in parallel. steps[i] says where sample i ended (the furthest, of several
  /// radii). Affordances are appended to `found` in the order of their samples; Affordance::sample is first + i.
  void run(const float* xyz, std::uint32_t n, std::uint32_t first, Step* steps, std::vector<Affordance>& found);

  /// Time of all runs since `begin`, summed over threads.
  StepSeconds seconds() const;

 private:
  struct Group {
    std::uint32_t begin, end;  ///< in the sorted order
    float low[3], high[3];     ///< box of its samples (m)
  };
  /// What is too flat to be summed: kernels::NeighbourhoodBatch::flat_rms and flat_slope.
  struct Flatness {
    float rms, slope;
  };
  struct Candidate {
    std::uint32_t sample;
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
  struct Scratch {
    CandidateList near;
    AlignedArray<std::byte> kernel;
    AlignedArray<kernels::Moments> moments;
    kernels::FitBatch fit;
    std::vector<std::uint32_t> sample;  ///< of each entry of `moments`: position in the sorted order
    std::vector<std::uint32_t> whole;   ///< entries whose moments are valid
    std::vector<Vector3> axis;          ///< by position in `whole`, when the axis is not the quadric's
    std::vector<Candidate> candidates;
    AlignedArray<float> x, y, z;
    std::vector<Found> found;
    StepSeconds seconds;
  };

  void sort_samples(const float* xyz, std::uint32_t n);
  void make_groups(std::uint32_t n);
  void run_groups(std::size_t first_group, std::size_t last_group, double radius, Flatness flatness, Step* steps,
                  Scratch& s) const;
  void fit(double radius, Step* steps, Scratch& s) const;
  void find_shells(Step* steps, Scratch& s) const;
  void find_cylinders(double radius, Step* steps, Scratch& s) const;
  Step judge(const Candidate& candidate, double radius, Scratch& s, Found& found) const;

  const Options* options_;
  Conditions conditions_;
  const TileStore* tiles_ = nullptr;
  const NeighbourIndex* index_ = nullptr;
  const DepthImage* image_ = nullptr;  ///< not null: the default method
  std::optional<Vector3> viewpoint_;
  std::vector<double> radii_;
  std::vector<Flatness> flatness_;  ///< for each radius: what the kernel need not sum
  AlignedArray<float> normals_;
  AlignedArray<std::uint64_t> keys_, other_keys_;
  AlignedArray<float> sorted_;          ///< xyz in the sorted order
  AlignedArray<std::uint32_t> number_;  ///< sorted order -> sample
  std::vector<Group> groups_;
  std::vector<Step> steps_;
  std::vector<Found> merged_;
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace handhold
