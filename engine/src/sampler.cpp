#include "sampler.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "random.h"
#include "vec3.h"

namespace handhold {
namespace {

constexpr int kTries = 100;
constexpr int kRounds = 10;
/// Streams of the random numbers: a round's uniform draws and its proposals do not share one.
constexpr std::uint64_t uniform_stream(int round) {
  return 2 * static_cast<std::uint64_t>(round);
}
constexpr std::uint64_t proposal_stream(int round) {
  return 2 * static_cast<std::uint64_t>(round) + 1;
}

}  // namespace

std::vector<int> Sampler::rounds(const Options& options) {
  const int n = options.samples;
  if (options.strategy == Strategy::kUniform) return {n};
  const int first = std::max(1, n <= 2000 ? n / 2 : static_cast<int>(static_cast<std::int64_t>(n) * 4 / 10));
  const int rest = n - first;
  std::vector<int> sizes{first};
  for (int i = 0; i < kRounds && rest > 0; ++i) {
    const int size = rest / kRounds + (i == kRounds - 1 ? rest % kRounds : 0);
    if (size > 0) sizes.push_back(size);
  }
  return sizes;
}

bool Sampler::in_workspace(const float* p) const {
  const auto& w = *options_->workspace;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(p[k] >= w[2 * k] && p[k] <= w[2 * k + 1])) return false;
  }
  return true;
}

void Sampler::begin(const TileStore& tiles, const NeighbourIndex& index) {
  tiles_ = &tiles;
  index_ = &index;
  const std::vector<double> radii = options_->effective_radius();
  snap_radius_ = static_cast<float>(*std::max_element(radii.begin(), radii.end()));
  inside_.clear();
  if (!options_->workspace) return;
  for (std::size_t rank = 0; rank < tiles.finite_points(); ++rank) {
    float p[3];
    tiles.finite_point(rank, p);
    if (in_workspace(p)) inside_.push_back(rank);
  }
}

void Sampler::draw_uniform(int round, int sample, float* xyz) const {
  CounterRandom random(options_->seed, uniform_stream(round), static_cast<std::uint64_t>(sample));
  const std::uint64_t i = random.below(points());
  tiles_->finite_point(options_->workspace ? inside_[i] : i, xyz);
}

void Sampler::uniform(int round, int n, float* xyz) const {
  tbb::parallel_for(tbb::blocked_range<int>(0, n, 1024), [&](const auto& range) {
    for (int i = range.begin(); i < range.end(); ++i) draw_uniform(round, i, xyz + 3 * i);
  });
}

namespace {

/// Cells of centres: wide enough that the few nearest hold what is within a draw's usual distance.
constexpr double kCellSigmas = 2.5;
constexpr std::int64_t kCellBias = 1 << 20;
std::int64_t cell_of(double x, double size) {
  return static_cast<std::int64_t>(std::floor(std::clamp(x / size, -1.0e6, 1.0e6))) + kCellBias;
}
std::uint64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::uint64_t>(z << 42 | y << 21 | x);
}

}  // namespace

void Sampler::set_centres(const std::vector<Vector3>& centres) {
  centres_ = centres;
  entries_.clear();
  if (options_->strategy != Strategy::kMax) return;
  const double size = kCellSigmas * options_->effective_proposal_sigma();
  for (std::uint32_t i = 0; i < centres.size(); ++i) {
    const Vector3& c = centres[i];
    entries_.push_back({cell_key(cell_of(c[0], size), cell_of(c[1], size), cell_of(c[2], size)), i, c});
  }
  std::sort(entries_.begin(), entries_.end(),
            [](const Entry& a, const Entry& b) { return a.cell != b.cell ? a.cell < b.cell : a.centre < b.centre; });
  entry_of_.resize(centres.size());
  for (std::uint32_t e = 0; e < entries_.size(); ++e) entry_of_[entries_[e].centre] = e;
}

/// Whether `centre` is the nearest to the position; of equally near ones the first.
bool Sampler::is_nearest(std::size_t centre, const Vector3& position) const {
  const Vector3 to_centre = position - centres_[centre];
  const double d2 = dot(to_centre, to_centre);
  const auto beats = [&](const Entry& e) {
    const Vector3 d = position - e.position;
    const double e2 = dot(d, d);
    return e2 < d2 || (e2 == d2 && e.centre < centre);
  };
  // Most draws lose against a centre beside the one they were drawn from.
  const std::size_t at = entry_of_[centre];
  const std::size_t first = at < 16 ? 0 : at - 16, last = std::min(entries_.size(), at + 16);
  for (std::size_t i = first; i < last; ++i) {
    if (beats(entries_[i])) return false;
  }
  const double size = kCellSigmas * options_->effective_proposal_sigma(), reach = std::sqrt(d2) * (1 + 1e-12);
  std::int64_t low[3], high[3];
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = cell_of(position[k] - reach, size), high[k] = cell_of(position[k] + reach, size);
  }
  for (std::int64_t z = low[2]; z <= high[2]; ++z) {
    for (std::int64_t y = low[1]; y <= high[1]; ++y) {
      const std::uint64_t end = cell_key(high[0], y, z);
      auto e = std::lower_bound(entries_.begin(), entries_.end(), cell_key(low[0], y, z),
                                [](const Entry& entry, std::uint64_t key) { return entry.cell < key; });
      for (; e != entries_.end() && e->cell <= end; ++e) {
        if (beats(*e)) return false;
      }
    }
  }
  return true;
}

Sampler::Draw Sampler::draw(int round, int sample, int attempt) const {
  const auto number = static_cast<std::uint64_t>(sample) * kTries + static_cast<std::uint64_t>(attempt);
  CounterRandom random(options_->seed, proposal_stream(round), number);
  const auto j = static_cast<std::size_t>(random.below(centres_.size()));
  double a, b, c, unused;
  random.normal_pair(a, b);
  random.normal_pair(c, unused);
  const double sigma = options_->effective_proposal_sigma();
  const Vector3 x = centres_[j] + Vector3{sigma * a, sigma * b, sigma * c};
  // g_max: all Gaussians have the same covariance, so the largest one at x belongs to the nearest centre. Algorithm 2
  // accepts when that is the one drawn from.
  return {j, x, options_->strategy == Strategy::kSum || is_nearest(j, x)};
}

/// The next draw of a sample that is accepted, from this attempt on; false: there is none.
bool Sampler::next(int round, int sample, int attempt, Proposal& proposal) const {
  for (; attempt < kTries; ++attempt) {
    const Draw d = draw(round, sample, attempt);
    if (!d.accepted) continue;
    const double size = kCellSigmas * options_->effective_proposal_sigma();
    const Vector3& x = d.position;
    proposal.cell = cell_key(cell_of(x[0], size), cell_of(x[1], size), cell_of(x[2], size));
    proposal.sample = sample, proposal.attempt = attempt;
    for (std::size_t k = 0; k < 3; ++k) proposal.position[k] = static_cast<float>(x[k]);
    return true;
  }
  return false;
}

/// The nearest point of the cloud within the radius, from the blocks of s.near; false: there is none.
bool Sampler::nearest(const Proposal& proposal, float radius, Scratch& s, float* xyz) const {
  const float* c = proposal.position.data();
  const std::size_t capacity = static_cast<std::size_t>(s.near.view().padded) * 256 + 16;
  s.x.require(capacity), s.y.require(capacity), s.z.require(capacity);
  const int n =
      kernels::kernels().collect(tiles_->view(), s.near.view(), c, radius, nullptr, s.x.data(), s.y.data(), s.z.data());
  float best2 = std::numeric_limits<float>::infinity();
  for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) {
    const float d2 = s.x[k] * s.x[k] + s.y[k] * s.y[k] + s.z[k] * s.z[k];
    if (d2 >= best2) continue;
    const float p[3] = {c[0] + s.x[k], c[1] + s.y[k], c[2] + s.z[k]};
    if (options_->workspace && !in_workspace(p)) continue;
    best2 = d2;
    std::copy(p, p + 3, xyz);
  }
  return best2 < std::numeric_limits<float>::infinity();
}

/// Brings near proposals to the cloud; those that are too far from it stay in the list.
void Sampler::snap(std::vector<Proposal>& proposals, Scratch& s, float* xyz) const {
  // Larger balls only if the smaller ones are empty: half of the draws lie within 0.45 of the radius of a surface.
  for (const float share : {0.2f, 0.45f, 0.7f, 1.0f}) {
    if (proposals.empty()) return;
    std::array<float, 3> low = proposals.front().position, high = low;
    for (const Proposal& p : proposals) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], p.position[k]), high[k] = std::max(high[k], p.position[k]);
      }
    }
    const float radius = share * snap_radius_;
    s.near.fill(*tiles_, *index_, low.data(), high.data(), radius);
    const auto found = [&](const Proposal& p) { return nearest(p, radius, s, xyz + 3 * p.sample); };
    proposals.erase(std::remove_if(proposals.begin(), proposals.end(), found), proposals.end());
  }
}

void Sampler::propose(int round, int n, float* xyz) {
  if (centres_.empty()) {
    uniform(round, n, xyz);
    return;
  }
  proposals_.resize(static_cast<std::size_t>(n));
  tbb::parallel_for(tbb::blocked_range<int>(0, n, 16), [&](const auto& range) {
    for (int i = range.begin(); i < range.end(); ++i) {
      Proposal& p = proposals_[static_cast<std::size_t>(i)];
      if (next(round, i, 0, p)) continue;
      p.attempt = kTries;
      draw_uniform(round, i, xyz + 3 * i);
    }
  });
  const auto none = [](const Proposal& p) { return p.attempt == kTries; };
  proposals_.erase(std::remove_if(proposals_.begin(), proposals_.end(), none), proposals_.end());
  std::sort(proposals_.begin(), proposals_.end(), [](const Proposal& a, const Proposal& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.sample < b.sample;
  });
  runs_.clear();
  for (std::size_t i = 0; i < proposals_.size(); ++i) {
    if (i == 0 || proposals_[i].cell != proposals_[i - 1].cell) runs_.push_back(i);
  }
  const std::size_t runs = runs_.size();
  runs_.push_back(proposals_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, runs, 4), [&](const auto& range) {
    Scratch& s = scratch_.local();
    for (std::size_t run = range.begin(); run < range.end(); ++run) {
      s.run.assign(proposals_.begin() + static_cast<std::ptrdiff_t>(runs_[run]),
                   proposals_.begin() + static_cast<std::ptrdiff_t>(runs_[run + 1]));
      snap(s.run, s, xyz);
      s.lost = s.run;
      for (Proposal p : s.lost) {
        // Far from the cloud: the sample is drawn again.
        for (s.run.assign(1, p); !s.run.empty() && next(round, p.sample, p.attempt + 1, p);) {
          s.run.assign(1, p);
          snap(s.run, s, xyz);
        }
        if (!s.run.empty()) draw_uniform(round, p.sample, xyz + 3 * p.sample);
      }
    }
  });
}

}  // namespace handhold
