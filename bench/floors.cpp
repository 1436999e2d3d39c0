#include "floors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "aligned.h"
#include "index.h"
#include "search.h"
#include "tiles.h"

#define HANDHOLD_ISA_SCALAR
#define HANDHOLD_LANE lane_counted
#include "circle.h"
#include "cuda/frame.h"
#include "curvature.h"
#include "moment_sums.h"
#include "taubin.h"

namespace handhold::bench {
namespace {

Operations tally;

/// A number that counts what is done to it. A change of sign and a selection cost no arithmetic.
template <class T>
struct Counted {
  T v;
  Counted() = default;
  Counted(T a) : v(a) {}
  static Counted simple(T a) {
    ++tally.simple;
    return a;
  }
  static Counted slow(T a) {
    ++tally.slow;
    return a;
  }
  static bool compared(bool is) {
    ++tally.simple;
    return is;
  }
  friend Counted operator+(Counted a, Counted b) { return simple(a.v + b.v); }
  friend Counted operator-(Counted a, Counted b) { return simple(a.v - b.v); }
  friend Counted operator*(Counted a, Counted b) { return simple(a.v * b.v); }
  friend Counted operator/(Counted a, Counted b) { return slow(a.v / b.v); }
  friend Counted operator-(Counted a) { return -a.v; }
  friend Counted fma(Counted a, Counted b, Counted c) { return simple(std::fma(a.v, b.v, c.v)); }
  friend Counted fnma(Counted a, Counted b, Counted c) { return simple(std::fma(-a.v, b.v, c.v)); }
  friend Counted sqrt(Counted a) { return slow(std::sqrt(a.v)); }
  friend Counted abs(Counted a) { return std::fabs(a.v); }
  friend Counted min(Counted a, Counted b) { return simple(a.v < b.v ? a.v : b.v); }
  friend Counted max(Counted a, Counted b) { return simple(a.v > b.v ? a.v : b.v); }
  friend bool operator<(Counted a, Counted b) { return compared(a.v < b.v); }
  friend bool operator<=(Counted a, Counted b) { return compared(a.v <= b.v); }
  friend bool operator>(Counted a, Counted b) { return compared(a.v > b.v); }
  friend bool operator>=(Counted a, Counted b) { return compared(a.v >= b.v); }
};

/// What `run` does.
template <class Run>
Operations counted(Run&& run) {
  tally = {};
  run();
  return std::exchange(tally, {});
}

// What the device keeps (kernels/cuda/frame.h), in bytes.
constexpr double kSource = 3 * sizeof(float);  ///< of a point as it comes
/// Of a block: points, boxes and sums of its tiles; which are full, how many points stand before each; its own points
/// and box.
constexpr double kBlockPoints = 4.0 * 768, kBlockBoxes = 4.0 * 96, kBlockSums = 4.0 * 160, kBlockFull = 2,
                 kBlockBefore = 32, kBlockCount = 4, kBlockBox = 24;
constexpr double kBlock = kBlockPoints + kBlockBoxes + kBlockSums + kBlockFull + kBlockBefore + kBlockCount + kBlockBox;
constexpr double kRank = 4;                                        ///< of a block: its first point's number
constexpr double kPosition = 12, kEnd = 1;                         ///< of a sample
constexpr double kListed = 4 + 17 * 4, kPlane = 12;                /**< of a slot: sample and blocks, rough plane, */
constexpr double kTotal = 8.0 * kernels::kMoments, kQuadric = 80;  ///< sums, coefficients
constexpr double kCandidate = sizeof(kernels::FrameCandidate), kFound = sizeof(kernels::FoundShell);
constexpr double kShellRow = 8 * sizeof(float);  ///< of a shell, for its alignment
constexpr double kHead = 128;                    ///< of the report

/// The points of an unorganized cloud are read for their keys, and keys and numbers written, read, and written in
/// order. A radix sort does this several times.
double sorting(const FrameSizes& s) {
  return s.organized ? 0 : s.points * (kSource + 3 * (s.key_bytes + 4));
}
double report(const FrameSizes& s) {
  return kHead + s.samples * kEnd + s.found * kFound;
}

}  // namespace

Operations operations_of_point() {
  using F = Counted<float>;
  return counted([] {
    F s[34];
    for (F& sum : s) sum = F(0.0f);
    const F a(0.1f), b(0.2f), cu(0.3f), cv(0.4f), cw(0.5f);
    const F x = F(0.31f) - cu, y = F(0.41f) - cv;
    lane_counted::add_point<0, 34>(s, x, y, fnma(a, x, fnma(b, y, F(0.51f) - cw)));
  });
}

Operations operations_of_block() {
  // A tile: three differences, three products of the norm and a comparison; three weighted coordinates and four sums;
  // six times a fused product and an addition.
  return {16.0 * (3 + 3 + 1 + 3 + 4 + 2 * 6), 0};
}

FitOperations operations_of_fit(const std::vector<std::array<double, kernels::kMoments>>& moments) {
  using R = Counted<double>;
  using namespace lane_counted;
  FitOperations mean;
  if (moments.empty()) return mean;
  const auto add = [&](Operations& to, const Operations& more) {
    const double n = static_cast<double>(moments.size());
    to.simple += more.simple / n, to.slow += more.slow / n;
  };
  for (const auto& numbers : moments) {
    R m[kernels::kMoments], c[10], lambda;
    // Both steps make moments of the sums first. Here they are moments already; the count is the same.
    const Operations loading = counted([&] {
      for (int k = 0; k < kernels::kMoments; ++k) m[k] = numbers[static_cast<std::size_t>(k)];
      moments_from_sums(m, 1.0f, R(0.0), R(0.0));
    });
    add(mean.quadric, loading), add(mean.circle, loading);
    bool flat = false;
    add(mean.quadric, counted([&] { flat = taubin_fit(m, c, lambda); }));
    if (flat) continue;
    add(mean.circle, counted([&] {
          const Quadric<R> quadric(c);
          const lane_counted::Vec3<R> foot = quadric.foot({R(0.0), R(0.0), R(0.0)});
          const Principal<R> p = principal_at(quadric, foot);
          median_curvature(quadric, m, foot, p);
          lane_counted::Vec3<R> centre;
          R radius;
          circle_fit(m, p.minor_axis, centre, radius);
        }));
  }
  return mean;
}

Looked look(const Options& options, const CloudView& cloud, const std::vector<Sample>& samples) {
  constexpr std::size_t kSome = 512;
  const Scale scale = scales_of(options).front();
  const auto radius = static_cast<float>(scale.radius);
  TileStore tiles;
  tiles.build(cloud);
  const auto index = make_index(options.index);
  index->build(tiles);
  Looked all;
  all.blocks = tiles.blocks(), all.finite = tiles.finite_points();
  AlignedArray<char> scratch;
  scratch.require(kernels::scratch_bytes(static_cast<std::int32_t>(tiles.blocks())));
  CandidateList near;
  const std::size_t every = std::max<std::size_t>(1, samples.size() / kSome);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    float centre[3];
    for (std::size_t k = 0; k < 3; ++k) centre[k] = static_cast<float>(samples[i].position[k]);
    near.fill(tiles, *index, centre, centre, radius);
    const kernels::Candidates blocks = near.view();
    for (std::int32_t b = 0; b < blocks.padded; ++b) {
      double apart2 = 0;
      for (int k = 0; k < 3; ++k) {
        const double outside = std::max({0.0, static_cast<double>(blocks.boxes[k][b] - centre[k]),
                                         static_cast<double>(centre[k] - blocks.boxes[k + 3][b])});
        apart2 += outside * outside;
      }
      all.touched += apart2 <= scale.radius * scale.radius;
    }
    kernels::Moments m;
    kernels::kernels().moments(tiles.view(), blocks, {centre, 1, radius, scale.flat_rms, 0, scale.flat_slope},
                               scratch.data(), &m);
    if (m.skipped) continue;
    ++all.summed, all.points += static_cast<std::uint64_t>(m.count);
    if (i / every >= all.moments.size() && m.count >= options.min_neighbours) {
      auto& kept = all.moments.emplace_back();
      std::copy_n(m.sum, kernels::kMoments, kept.begin());
    }
  }
  return all;
}

Floor floor_of(const Work& w, const Rates& r) {
  Floor floor{0, "-"};
  const auto add = [&](double amount, double rate, const char* by) {
    const double seconds = amount > 0 && rate > 0 ? amount / rate : 0;
    if (seconds > floor.seconds) floor = {seconds, by};
  };
  add(w.up, r.up, "upload"), add(w.down, r.down, "download"), add(w.memory, r.memory, "memory");
  add(w.fp32, r.fp32, "FP32"), add(w.fp64, r.fp64, "FP64");
  return floor;
}

std::array<Work, kStages> work_of_stages(const FrameSizes& s, const Looked& l) {
  const auto blocks = static_cast<double>(l.blocks), slots = static_cast<double>(l.summed);
  const FitOperations fit = operations_of_fit(l.moments);
  const double numbers = s.organized ? 4 * blocks : 4 * static_cast<double>(l.finite);
  std::array<Work, kStages> work{};
  work[0].up = kSource * s.points;
  work[1].memory = sorting(s) + kSource * s.points + numbers + kBlock * blocks;
  work[2].memory = (2 * kBlockBox + kBlockCount + kRank) * blocks;
  work[3].memory = (kBlockBox + kBlockSums) * blocks + (kPosition + kEnd) * s.samples + (kListed + kPlane) * slots;
  work[3].fp32 = static_cast<double>(l.touched) * operations_of_block().all();
  work[4].memory = (kBlockPoints + kBlockBoxes + kBlockFull) * blocks + (kListed + kPlane + kPosition + kTotal) * slots;
  work[4].fp32 = static_cast<double>(l.points) * operations_of_point().all();
  work[5].memory = (4 + 8 + kTotal + kQuadric + kEnd) * slots;
  work[5].fp64 = slots * fit.quadric.all();
  work[6].memory = (4 + kPlane + kTotal + kQuadric + kEnd + kPosition) * slots + kCandidate * s.candidates;
  work[6].fp64 = slots * fit.circle.all();
  work[7].memory = (kCandidate + kEnd) * s.candidates + kFound * s.found;
  work[8].memory = (kFound + 2 * kShellRow + 4) * s.found;
  work[9].down = report(s);
  return work;
}

Work work_of_frame(const FrameSizes& s, const Looked& l, bool upload) {
  const auto blocks = static_cast<double>(l.blocks), slots = static_cast<double>(l.summed);
  Work all;
  for (const Work& stage : work_of_stages(s, l)) all.fp32 += stage.fp32, all.fp64 += stage.fp64;
  all.up = upload ? kSource * s.points : 0;
  all.down = report(s);
  all.memory = kSource * s.points + sorting(s) + 2 * (kBlock + kRank) * blocks + 2 * kPosition * s.samples +
               2 * (kListed + kPlane + kTotal + kQuadric) * slots + 2 * kCandidate * s.candidates + report(s);
  return all;
}

const std::vector<std::string>& formulas() {
  static const std::vector<std::string> lines = [] {
    const auto whole = [](double x) { return std::to_string(static_cast<long long>(std::llround(x))); };
    const auto sum = [&](double x, const char* of) { return whole(x) + " " + of; };
    const Operations point = operations_of_point();
    return std::vector<std::string>{
        "P points, B blocks of 256, S samples, K neighbourhoods that are summed, N points in their balls,",
        "T blocks that a ball touches, C candidates, A shells; bytes:",
        "upload    " + sum(kSource, "P over the bus, by the rate of a pinned copy"),
        "tiles     " + sum(kSource, "P read, ") + sum(kBlock, "B written; unorganized: and ") + whole(kSource) +
            " P read, 3 (key + 4) P read or written, once each (a radix sort does it several times)",
        "tree      " + sum(2 * kBlockBox + kBlockCount + kRank, "B"),
        "look      " + sum(kBlockBox + kBlockSums, "B read once, ") + sum(kPosition + kEnd, "S + ") +
            sum(kListed + kPlane, "K written; ") +
            sum(operations_of_block().all(), "T operations, FP32 (boxes left out)"),
        "sums      " + sum(kBlockPoints + kBlockBoxes + kBlockFull, "B read once, ") +
            sum(kListed + kPlane + kPosition, "K read, ") + sum(kTotal, "K written; ") +
            sum(point.all(), "N operations, FP32 (tests of points left out)"),
        "quadric   " + sum(4 + 8 + kTotal, "K read, ") + sum(kQuadric + kEnd, "K written; FP64 operations as counted"),
        "circle    " + sum(4 + kPlane + kTotal + kQuadric + kEnd + kPosition, "K read, ") +
            sum(kCandidate, "C written; FP64 operations as counted"),
        "shell     " + sum(kCandidate + kEnd, "C + ") +
            sum(kFound, "A (points are in the cache by then; operations not counted)"),
        "align     " + sum(kFound + 2 * kShellRow + 4, "A (operations not counted)"),
        "download  " + whole(kHead) + " + S + " + sum(kFound, "A over the bus"),
        "frame     memory: " + sum(kSource, "P + 2 x ") + sum(kBlock + kRank, "B + 2 x ") + sum(kPosition, "S + 2 x ") +
            sum(kListed + kPlane + kTotal + kQuadric, "K + 2 x ") +
            sum(kCandidate, "C + the report: what is written is read once"),
        "an operation is one lane's addition, product, fused product or comparison; a division or root counts as " +
            whole(Operations::kSlow),
        "floor = the slowest of bytes / rate and operations / (multiprocessors x clock x lanes)",
    };
  }();
  return lines;
}

}  // namespace handhold::bench
