// Where to look (paper, section 3.4).
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <cstdint>
#include <vector>

#include "budget.h"
#include "depth_image.h"
#include "handhold/options.h"
#include "index.h"
#include "tiles.h"

namespace handhold {

/// Draws the samples of one frame. Every draw is a function of (seed, round, number of the sample): it does not depend
/// on the number of threads.
class Sampler {
 public:
  explicit Sampler(const Options& options);

  /// Samples of each round: one round for uniform sampling; otherwise half of the samples (0.4 of more than 2000) and
  /// ten equal rounds (by the default method: seven), the last one with the remainder.
  static std::vector<int> rounds(const Options& options);

  /// Stream of the random numbers of a round's uniform draws.
  static constexpr std::uint64_t uniform_stream(int round) { return 2 * static_cast<std::uint64_t>(round); }
  /// Of its proposals.
  static constexpr std::uint64_t proposal_stream(int round) { return uniform_stream(round) + 1; }

  /// Takes the points of a frame. With a workspace, only points inside are drawn; with an image, uniform draws pass
  /// over points whose surroundings are flat or hollow.
  void begin(const TileStore& tiles, const NeighbourIndex& index, const DepthImage* image = nullptr);
  /// Number of points that can be drawn; 0: no sample is possible.
  std::size_t points() const { return options_->workspace ? inside_.size() : tiles_->finite_points(); }

  /// n samples, uniformly over the points. xyz: 3 * n (m).
  /// @throws Budget::Spent; so does propose
  void uniform(int round, int n, float* xyz, const Budget& budget = {}) const;

  /// The centres of the affordances found so far (m): what proposals are drawn about.
  void set_centres(const std::vector<Vector3>& centres);

  /// n samples from the proposal distribution about the centres, brought to the nearest point of the cloud within the
  /// first radius. A sample that finds none in 100 tries is drawn uniformly. Parallel. With no centres all are uniform.
  void propose(int round, int n, float* xyz, const Budget& budget = {});

  /// The raw draw of Algorithm 2 (or of g_sum) before it is brought to the cloud: which centre, where, and whether it
  /// is accepted. For tests of the distribution.
  struct Draw {
    std::size_t centre;
    Vector3 position;
    bool accepted;
  };
  Draw draw(int round, int sample, int attempt) const;

 private:
  void draw_uniform(int round, int sample, int n, float* xyz) const;
  /// Draws in a row of one sample.
  static constexpr int kDraws = 8;
  struct Some {
    std::size_t centre[kDraws];
    float normal[3 * kDraws];  ///< all first coordinates, all second ones, all third ones
  };
  void draw_some(int round, int sample, int attempt, Some& some) const;
  Draw draw_of(const Some& some, int i) const;
  bool surely_loses(const Some& some, int i) const;
  bool is_nearest(std::size_t centre, const Vector3& position) const;
  bool in_workspace(const float* p) const;

  /// A draw that was accepted, on its way to the cloud.
  struct Proposal {
    std::uint64_t cell;  ///< those of one cell are taken together
    int sample, attempt;
    std::array<float, 3> position;  ///< m
  };
  struct Scratch {
    CandidateList near;
    AlignedArray<float> x, y, z;
    std::vector<Proposal> run, lost;
  };
  bool next(int round, int sample, int attempt, Proposal& proposal) const;
  bool nearest(const Proposal& proposal, float radius, Scratch& s, float* xyz) const;
  void snap(std::vector<Proposal>& proposals, Scratch& s, float* xyz) const;
  const Options* options_;
  const TileStore* tiles_ = nullptr;
  const NeighbourIndex* index_ = nullptr;
  const DepthImage* image_ = nullptr;
  float snap_radius_ = 0;              ///< m; a proposal goes to the nearest point within this
  std::vector<std::uint64_t> inside_;  ///< ranks of the points in the workspace
  /// Centres sorted by cell, so that the ones near a place stand together.
  struct Entry {
    std::uint64_t cell;
    std::uint32_t centre;
    Vector3 position;
  };
  std::vector<Vector3> centres_;
  std::vector<Entry> entries_, merged_;
  std::vector<std::uint32_t> entry_of_;  ///< centre -> its entry
  /// The entries' positions relative to the first one, in single precision (m); with 15 more numbers.
  std::array<std::vector<float>, 3> rough_;
  double slack_ = 0;  ///< m; how wrong they may be
  std::vector<Proposal> proposals_;
  std::vector<std::size_t> runs_;  ///< the first proposal of each cell, and the end
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace handhold
