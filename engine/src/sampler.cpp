#include "sampler.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "bend.h"
#include "kernels.h"
#include "proposals.h"
#include "vec3.h"

namespace handhold {
namespace {

using kernels::kTries;
/// Every round waits for the one before. The default method finds as much with seven as with the paper's ten.
constexpr int kPaperRounds = 10, kRounds = 7;
/// Points that a uniform draw passes over at most.
constexpr int kFlatTries = 16;
/// Uniform draws that are made side by side.
constexpr int kUniformAtOnce = 32;

Vector3 to_double(const float* p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

}  // namespace

Sampler::Sampler(const Options& options) : options_(&options) {
  const std::vector<double> radii = options.effective_radius();
  snap_radius_ = static_cast<float>(*std::max_element(radii.begin(), radii.end()));
}

std::vector<int> Sampler::rounds(const Options& options) {
  const int n = options.samples;
  if (options.strategy == Strategy::kUniform) return {n};
  const int first = std::max(1, n <= 2000 ? n / 2 : static_cast<int>(static_cast<std::int64_t>(n) * 4 / 10));
  const int rest = n - first, rounds = options.method == Method::kPaper ? kPaperRounds : kRounds;
  std::vector<int> sizes{first};
  for (int i = 0; i < rounds && rest > 0; ++i) {
    const int size = rest / rounds + (i == rounds - 1 ? rest % rounds : 0);
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

void Sampler::begin(const TileStore& tiles, const NeighbourIndex& index, const DepthImage* image) {
  tiles_ = &tiles;
  image_ = image && !image->empty() ? image : nullptr;
  index_ = &index;
  inside_.clear();
  if (!options_->workspace) return;
  for (std::size_t rank = 0; rank < tiles.finite_points(); ++rank) {
    float p[3];
    tiles.finite_point(rank, p);
    if (in_workspace(p)) inside_.push_back(rank);
  }
}

/// At most kUniformAtOnce samples in a row.
void Sampler::draw_uniform(int round, int sample, int n, float* xyz) const {
  std::array<std::optional<CounterRandom>, kUniformAtOnce> random;
  std::array<int, kUniformAtOnce> left{};
  for (int i = 0; i < n; ++i) {
    random[static_cast<std::size_t>(i)].emplace(options_->seed, uniform_stream(round),
                                                static_cast<std::uint64_t>(sample + i));
    left[static_cast<std::size_t>(i)] = i;
  }
  const double reach = options_->effective_reach();
  for (int attempt = 0; attempt < (image_ ? kFlatTries : 1) && n > 0; ++attempt) {
    // All points first: they are far apart in memory, and the machine fetches several at a time.
    for (int k = 0; k < n; ++k) {
      const auto i = static_cast<std::size_t>(left[static_cast<std::size_t>(k)]);
      const std::uint64_t rank = random[i]->below(points());
      tiles_->finite_point(options_->workspace ? inside_[rank] : rank, xyz + 3 * i);
    }
    if (!image_) return;
    const auto end = std::remove_if(left.begin(), left.begin() + n,
                                    [&](int i) { return bends(*image_, to_double(xyz + 3 * i), reach); });
    n = static_cast<int>(end - left.begin());
  }
}

void Sampler::uniform(int round, int n, float* xyz, const Budget& budget) const {
  tbb::parallel_for(tbb::blocked_range<int>(0, n, 4 * kUniformAtOnce), [&](const auto& range) {
    for (int i = range.begin(); i < range.end(); i += kUniformAtOnce) {
      if (budget.spent()) return;
      draw_uniform(round, i, std::min(kUniformAtOnce, range.end() - i), xyz + 3 * i);
    }
  });
  budget.check();
}

namespace {

/// Cells of centres: wide enough that the few nearest hold what is within a draw's usual distance.
constexpr double kCellSigmas = 2.5;
constexpr std::int64_t kCellBias = 1 << 20;
/// Entries either way of a centre's that are looked at first, and how many are few.
constexpr std::size_t kBeside = 16, kMoreBeside = 64, kFew = 2048;
std::int64_t cell_of(double x, double size) {
  return static_cast<std::int64_t>(std::floor(std::clamp(x / size, -1.0e6, 1.0e6))) + kCellBias;
}
std::uint64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::uint64_t>(z << 42 | y << 21 | x);
}

}  // namespace

void Sampler::set_centres(const std::vector<Vector3>& centres) {
  // Most often some are added to those of the last time, which are in order already.
  const std::size_t known = entries_.size() == centres_.size() && centres_.size() <= centres.size() &&
                                    std::equal(centres_.begin(), centres_.end(), centres.begin())
                                ? centres_.size()
                                : 0;
  centres_ = centres;
  entries_.resize(known);
  if (options_->strategy == Strategy::kSum || centres.empty()) return;
  const double size = kCellSigmas * options_->effective_proposal_sigma();
  for (auto i = static_cast<std::uint32_t>(known); i < centres.size(); ++i) {
    const Vector3& c = centres[i];
    entries_.push_back({cell_key(cell_of(c[0], size), cell_of(c[1], size), cell_of(c[2], size)), i, c});
  }
  const auto before = [](const Entry& a, const Entry& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.centre < b.centre;
  };
  const auto added = entries_.begin() + static_cast<std::ptrdiff_t>(known);
  std::sort(added, entries_.end(), before);
  merged_.resize(entries_.size());
  std::merge(entries_.begin(), added, added, entries_.end(), merged_.begin(), before);
  std::swap(entries_, merged_);
  entry_of_.resize(centres.size());
  double farthest = 0;
  for (std::size_t k = 0; k < 3; ++k) rough_[k].assign(entries_.size() + 15, 0.0f);
  for (std::uint32_t e = 0; e < entries_.size(); ++e) {
    entry_of_[entries_[e].centre] = e;
    const Vector3 p = entries_[e].position - entries_.front().position;
    for (std::size_t k = 0; k < 3; ++k) rough_[k][e] = static_cast<float>(p[k]);
    farthest = std::max(farthest, norm(p));
  }
  // Twice what single precision can be wrong by in a difference of two positions.
  slack_ = 0x1p-21 * (farthest + 10 * options_->effective_proposal_sigma());
}

/// Whether `centre` is the nearest to the position; of equally near ones the first.
bool Sampler::is_nearest(std::size_t centre, const Vector3& position) const {
  const Vector3 to_centre = position - centres_[centre], rough = position - entries_.front().position;
  const double d2 = dot(to_centre, to_centre), d = std::sqrt(d2);
  const auto x = static_cast<float>(rough[0]), y = static_cast<float>(rough[1]), z = static_cast<float>(rough[2]);
  const float *px = rough_[0].data(), *py = rough_[1].data(), *pz = rough_[2].data();
  // Nearer than `sure` is nearer, whatever the rounding; beyond `perhaps` is farther.
  const auto sure = static_cast<float>(d2 - 4 * d * slack_),
             perhaps = static_cast<float>(d2 + 4 * (d + slack_) * slack_);
  const auto distance2 = [&](std::size_t i) {
    const float a = px[i] - x, b = py[i] - y, c = pz[i] - z;
    return a * a + b * b + c * c;
  };
  // Most that surely_loses did not see lose against a centre a little farther in the order.
  const std::size_t at = entry_of_[centre], n = entries_.size();
  const float place[3] = {x, y, z};
  const auto any_nearer = [&](std::size_t from, std::size_t to, float limit) {
    return kernels::kernels().any_nearer(px + from, py + from, pz + from, static_cast<std::int32_t>(to - from), place,
                                         limit);
  };
  if (any_nearer(at < kMoreBeside ? 0 : at - kMoreBeside, std::min(n, at + kMoreBeside), sure)) return false;
  // Of few centres all are looked at faster than the near ones are found.
  if (n <= kFew && !any_nearer(0, at, perhaps) && !any_nearer(at + 1, n, perhaps)) return true;
  const auto beats = [&](const Entry& e) {
    const Vector3 away = position - e.position;
    const double e2 = dot(away, away);
    return e2 < d2 || (e2 == d2 && e.centre < centre);
  };
  const double size = kCellSigmas * options_->effective_proposal_sigma(), reach = d * (1 + 1e-12);
  std::int64_t low[3], high[3];
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = cell_of(position[k] - reach, size), high[k] = cell_of(position[k] + reach, size);
  }
  for (std::int64_t cz = low[2]; cz <= high[2]; ++cz) {
    for (std::int64_t cy = low[1]; cy <= high[1]; ++cy) {
      const std::uint64_t end = cell_key(high[0], cy, cz);
      const auto from = std::lower_bound(entries_.begin(), entries_.end(), cell_key(low[0], cy, cz),
                                         [](const Entry& entry, std::uint64_t key) { return entry.cell < key; });
      for (auto i = static_cast<std::size_t>(from - entries_.begin()); i < entries_.size() && entries_[i].cell <= end;
           ++i) {
        if (distance2(i) <= perhaps && beats(entries_[i])) return false;
      }
    }
  }
  return true;
}

/// Draws of a sample from an attempt on.
void Sampler::draw_some(int round, int sample, int attempt, Some& some) const {
  const std::uint64_t stream = CounterRandom::stream_state(options_->seed, proposal_stream(round));
  static_assert(kNormalWords == 2 * kDraws);
  std::uint64_t words[kNormalWords];
  for (int i = 0; i < kDraws; ++i) {
    const auto number = static_cast<std::uint64_t>(sample) * kTries + static_cast<std::uint64_t>(attempt + i);
    CounterRandom random(stream, number);
    some.centre[i] = static_cast<std::size_t>(random.below(centres_.size()));
    words[i] = random.next(), words[kDraws + i] = random.next();
  }
  // The second half's second values are not needed.
  float second[kNormalWords];
  normal_pairs(words, some.normal, second);
  std::copy(second, second + kDraws, some.normal + 2 * kDraws);
}

Sampler::Draw Sampler::draw_of(const Some& some, int i) const {
  const std::size_t j = some.centre[i];
  const double sigma = options_->effective_proposal_sigma();
  Vector3 x = centres_[j];
  for (std::size_t k = 0; k < 3; ++k)
    x[k] += sigma * static_cast<double>(some.normal[k * kDraws + static_cast<std::size_t>(i)]);
  // g_max: all Gaussians have the same covariance, so the largest one at x belongs to the nearest centre. Algorithm 2
  // accepts when that is the one drawn from.
  return {j, x, options_->strategy == Strategy::kSum || is_nearest(j, x)};
}

Sampler::Draw Sampler::draw(int round, int sample, int attempt) const {
  Some some;
  draw_some(round, sample, attempt, some);
  return draw_of(some, 0);
}

/// Whether a draw is so much nearer to a centre beside its own that no rounding can matter: of g_max most are.
bool Sampler::surely_loses(const Some& some, int i) const {
  if (options_->strategy == Strategy::kSum) return false;
  const std::size_t at = entry_of_[some.centre[i]], n = entries_.size();
  const auto sigma = static_cast<float>(options_->effective_proposal_sigma());
  float place[3], d2 = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const float step = sigma * some.normal[k * kDraws + static_cast<std::size_t>(i)];
    place[k] = rough_[k][at] + step, d2 += step * step;
  }
  const float limit = d2 - 8 * std::sqrt(d2) * static_cast<float>(slack_);
  const std::size_t from = at < kBeside ? 0 : at - kBeside, to = std::min(n, at + kBeside);
  return kernels::kernels().any_nearer(rough_[0].data() + from, rough_[1].data() + from, rough_[2].data() + from,
                                       static_cast<std::int32_t>(to - from), place, limit);
}

/// The next draw of a sample that is accepted, from this attempt on; false: there is none.
bool Sampler::next(int round, int sample, int attempt, Proposal& proposal) const {
  Some some;
  for (int first = attempt; attempt < kTries; ++attempt) {
    if ((attempt - first) % kDraws == 0) draw_some(round, sample, attempt, some);
    if (surely_loses(some, (attempt - first) % kDraws)) continue;
    const Draw d = draw_of(some, (attempt - first) % kDraws);
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
  const kernels::Candidates near = s.near.view();
  if (!options_->workspace) {
    float offset[3];
    if (!kernels::kernels().nearest(tiles_->view(), near, c, radius, offset)) return false;
    for (std::size_t k = 0; k < 3; ++k) xyz[k] = c[k] + offset[k];
    return true;
  }
  const std::size_t capacity = static_cast<std::size_t>(near.padded) * 256 + 16;
  s.x.require(capacity), s.y.require(capacity), s.z.require(capacity);
  const int n =
      kernels::kernels().collect(tiles_->view(), near, c, radius, nullptr, s.x.data(), s.y.data(), s.z.data());
  float best2 = std::numeric_limits<float>::infinity();
  for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) {
    const float d2 = s.x[k] * s.x[k] + s.y[k] * s.y[k] + s.z[k] * s.z[k];
    if (d2 >= best2) continue;
    const float p[3] = {c[0] + s.x[k], c[1] + s.y[k], c[2] + s.z[k]};
    if (!in_workspace(p)) continue;
    best2 = d2;
    std::copy(p, p + 3, xyz);
  }
  return best2 < std::numeric_limits<float>::infinity();
}

/// Brings near proposals to the cloud; those that are too far from it stay in the list.
void Sampler::snap(std::vector<Proposal>& proposals, Scratch& s, float* xyz) const {
  for (const float share : {kernels::kNearShare, 1.0f}) {
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

void Sampler::propose(int round, int n, float* xyz, const Budget& budget) {
  if (centres_.empty()) {
    uniform(round, n, xyz, budget);
    return;
  }
  proposals_.resize(static_cast<std::size_t>(n));
  tbb::parallel_for(tbb::blocked_range<int>(0, n, 16), [&](const auto& range) {
    for (int i = range.begin(); i < range.end(); ++i) {
      if (i % 16 == 0 && budget.spent()) return;
      Proposal& p = proposals_[static_cast<std::size_t>(i)];
      if (next(round, i, 0, p)) continue;
      p.attempt = kTries;
      draw_uniform(round, i, 1, xyz + 3 * i);
    }
  });
  budget.check();
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
      if (run % 4 == 0 && budget.spent()) return;
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
        if (!s.run.empty()) draw_uniform(round, p.sample, 1, xyz + 3 * p.sample);
      }
    }
  });
  budget.check();
}

}  // namespace handhold
