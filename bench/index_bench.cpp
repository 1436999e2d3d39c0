// Neighbours of the same samples by every index: building it, fetching the points of every ball, and, for the engine's
// own, fetching candidate blocks alone and summing moments. One thread.
//
// Before anything is timed, each index must return what a search of all points returns; one that does not is reported
// as an error instead of a time. HANDHOLD_BENCH_CLOUD names the cloud, as in frame_bench.
#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <nanoflann.hpp>
#include <string>
#include <vector>

#include "aligned.h"
#include "baseline/stages.h"
#include "index.h"
#include "kernels.h"
#include "scene.h"

namespace handhold::bench {
namespace {

using Sample = std::array<float, 3>;
using Offsets = std::vector<std::array<float, 3>>;  // points minus their sample (m)
// Called with a sample's number and its neighbours.
using Check = std::function<void(std::size_t, const Offsets&)>;

constexpr float kRadius = 0.025f;  // m
constexpr int kSamples = 20000;
constexpr std::size_t kChecked = 300;  // samples that are searched by brute force

// Order along a Morton curve of 8 mm cells: what stands together in space stands together in the list.
std::vector<Sample> sorted_samples(const Cloud& cloud, int count) {
  std::vector<Sample> samples = draw_samples(cloud.view(), count);
  Sample low = {1e9f, 1e9f, 1e9f};
  for (const Sample& s : samples)
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], s[k]);
  const auto spread = [](std::uint64_t v) {  // 21 bits to every third bit
    std::uint64_t bits = 0;
    for (int i = 0; i < 21; ++i) bits |= (v >> i & 1) << (3 * i);
    return bits;
  };
  const auto key = [&](const Sample& s) {
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) code |= spread(static_cast<std::uint64_t>((s[k] - low[k]) / 0.008f)) << k;
    return code;
  };
  std::sort(samples.begin(), samples.end(), [&](const Sample& a, const Sample& b) {
    const std::uint64_t ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  return samples;
}

struct Group {
  std::size_t begin, end;
  Sample low, high;  // m; box of its samples
};

// Runs of at most kMaxGroup samples whose box has a diagonal of at most four radii.
std::vector<Group> make_groups(const std::vector<Sample>& samples, std::size_t largest) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!groups.empty() && i - groups.back().begin < largest) {
      Group grown = groups.back();
      float diagonal2 = 0;
      for (int k = 0; k < 3; ++k) {
        grown.low[k] = std::min(grown.low[k], samples[i][k]);
        grown.high[k] = std::max(grown.high[k], samples[i][k]);
        diagonal2 += (grown.high[k] - grown.low[k]) * (grown.high[k] - grown.low[k]);
      }
      grown.end = i + 1;
      if (diagonal2 <= 16 * kRadius * kRadius) {
        groups.back() = grown;
        continue;
      }
    }
    groups.push_back({i, i + 1, samples[i], samples[i]});
  }
  return groups;
}

struct Scene {
  Cloud cloud;
  std::vector<Sample> samples;
  baseline::PclCloud::Ptr pcl_cloud;
};

// One way to find neighbours.
class Contender {
 public:
  virtual ~Contender() = default;
  virtual void build(const Scene& scene) = 0;
  // Fetches the points of the ball of every sample; returns their number in all. `check` may be empty.
  virtual std::size_t query(const Scene& scene, const Check& check) = 0;
};

// The engine's tiles behind one of its indices; a query serves `group` samples.
class TileContender : public Contender {
 public:
  TileContender(IndexKind kind, std::size_t group) : index_(make_index(kind)), largest_group_(group) {}

  void build(const Scene& scene) override {
    tiles_.build(scene.cloud.view());
    index_->build(tiles_);
    if (groups_.empty()) groups_ = make_groups(scene.samples, largest_group_);
    const std::size_t capacity = 256 * std::size_t(tiles_.blocks()) + 16;
    x_.require(capacity), y_.require(capacity), z_.require(capacity);
    scratch_.require(kernels::scratch_bytes(static_cast<std::int32_t>(tiles_.blocks())));
  }

  std::size_t query(const Scene& scene, const Check& check) override {
    const kernels::Kernels& k = kernels::kernels();
    std::size_t total = 0;
    Offsets offsets;
    for (const Group& group : groups_) {
      list_.fill(tiles_, *index_, group.low.data(), group.high.data(), kRadius);
      for (std::size_t s = group.begin; s < group.end; ++s) {
        const std::int32_t n = k.collect(tiles_.view(), list_.view(), scene.samples[s].data(), kRadius, scratch_.data(),
                                         x_.data(), y_.data(), z_.data());
        total += std::size_t(n);
        if (!check) continue;
        offsets.clear();
        for (std::size_t i = 0; i < std::size_t(n); ++i) offsets.push_back({x_[i], y_[i], z_[i]});
        check(s, offsets);
      }
    }
    return total;
  }

  // Candidate blocks alone; returns their number.
  std::size_t query_blocks() {
    std::size_t total = 0;
    for (const Group& group : groups_) {
      list_.fill(tiles_, *index_, group.low.data(), group.high.data(), kRadius);
      total += std::size_t(list_.view().padded);
    }
    return total;
  }

  // Moments of every ball; returns the number of points in all.
  std::size_t sum_moments(const Scene& scene) {
    const kernels::Kernels& k = kernels::kernels();
    std::size_t total = 0;
    moments_.resize(kernels::kMaxGroup);
    for (const Group& group : groups_) {
      list_.fill(tiles_, *index_, group.low.data(), group.high.data(), kRadius);
      kernels::NeighbourhoodBatch batch{};
      batch.centre = scene.samples[group.begin].data();
      batch.n = static_cast<std::int32_t>(group.end - group.begin);
      batch.radius = kRadius;
      batch.flat_rms = 0;
      batch.min_points = 1;
      k.moments(tiles_.view(), list_.view(), batch, scratch_.data(), moments_.data());
      for (std::int32_t i = 0; i < batch.n; ++i) total += std::size_t(moments_[std::size_t(i)].count);
    }
    return total;
  }

 private:
  TileStore tiles_;
  std::unique_ptr<NeighbourIndex> index_;
  std::size_t largest_group_;
  std::vector<Group> groups_;
  CandidateList list_;
  AlignedArray<float> x_, y_, z_;
  AlignedArray<char> scratch_;
  std::vector<kernels::Moments> moments_;
};

class PclContender : public Contender {
 public:
  explicit PclContender(baseline::Search kind) : kind_(kind) {}
  void build(const Scene& scene) override {
    search_ = std::make_unique<baseline::RadiusSearch>(scene.pcl_cloud, kind_);
  }
  std::size_t query(const Scene& scene, const Check& check) override {
    std::size_t total = 0;
    Offsets offsets;
    for (std::size_t s = 0; s < scene.samples.size(); ++s) {
      const Sample& p = scene.samples[s];
      const std::vector<int>& found = search_->find({p[0], p[1], p[2]}, kRadius);
      total += found.size();
      if (!check) continue;
      offsets.clear();
      for (const int i : found) {
        const pcl::PointXYZ& q = (*scene.pcl_cloud)[std::size_t(i)];
        offsets.push_back({q.x - p[0], q.y - p[1], q.z - p[2]});
      }
      check(s, offsets);
    }
    return total;
  }

 private:
  baseline::Search kind_;
  std::unique_ptr<baseline::RadiusSearch> search_;
};

class NanoflannContender : public Contender {
 public:
  void build(const Scene& scene) override {
    points_.clear();
    for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
      const float* p = &scene.cloud.xyz[3 * i];
      if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) points_.push_back({p[0], p[1], p[2]});
    }
    tree_ = std::make_unique<Tree>(3, *this, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  }
  std::size_t query(const Scene& scene, const Check& check) override {
    std::size_t total = 0;
    Offsets offsets;
    const nanoflann::SearchParams unsorted(0, 0, false);
    for (std::size_t s = 0; s < scene.samples.size(); ++s) {
      const Sample& p = scene.samples[s];
      tree_->radiusSearch(p.data(), kRadius * kRadius, found_, unsorted);
      total += found_.size();
      if (!check) continue;
      offsets.clear();
      for (const auto& [i, distance2] : found_)
        offsets.push_back({points_[i][0] - p[0], points_[i][1] - p[1], points_[i][2] - p[2]});
      check(s, offsets);
    }
    return total;
  }

  // What nanoflann asks of a data set.
  std::size_t kdtree_get_point_count() const { return points_.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t dimension) const { return points_[i][dimension]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

 private:
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, NanoflannContender>,
                                                   NanoflannContender, 3, std::uint32_t>;
  std::vector<Sample> points_;
  std::unique_ptr<Tree> tree_;
  std::vector<std::pair<std::uint32_t, float>> found_;
};

// Sorted, without those within 1 um of the sphere, on which side of which rounding decides.
Offsets canonical(Offsets offsets) {
  const auto on_sphere = [](const std::array<float, 3>& d) {
    return std::abs(std::hypot(double(d[0]), double(d[1]), double(d[2])) - double(kRadius)) < 1e-6;
  };
  offsets.erase(std::remove_if(offsets.begin(), offsets.end(), on_sphere), offsets.end());
  std::sort(offsets.begin(), offsets.end());
  return offsets;
}

// What every contender must find at every k-th sample.
class Truth {
 public:
  explicit Truth(const Scene& scene) : step_(std::max<std::size_t>(1, scene.samples.size() / kChecked)) {
    for (std::size_t s = 0; s < scene.samples.size(); s += step_) {
      const Sample& p = scene.samples[s];
      Offsets offsets;
      for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
        const float* q = &scene.cloud.xyz[3 * i];
        const std::array<float, 3> d = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
        if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < 1.1f * kRadius * kRadius) offsets.push_back(d);
      }
      const auto outside = [](const std::array<float, 3>& d) {
        return std::hypot(double(d[0]), double(d[1]), double(d[2])) > double(kRadius);
      };
      offsets.erase(std::remove_if(offsets.begin(), offsets.end(), outside), offsets.end());
      lists_.push_back(canonical(std::move(offsets)));
    }
  }

  // Empty, or what is wrong with the contender.
  std::string judge(const Scene& scene, Contender& contender) const {
    std::size_t checked = 0, wrong = 0;
    contender.query(scene, [&](std::size_t s, const Offsets& offsets) {
      if (s % step_) return;
      ++checked;
      wrong += canonical(offsets) != lists_[s / step_];
    });
    if (checked == lists_.size() && !wrong) return "";
    return std::to_string(wrong) + " of " + std::to_string(lists_.size()) + " samples have other neighbours";
  }

 private:
  std::size_t step_;
  std::vector<Offsets> lists_;
};

template <class Run>
void add(const std::string& name, tbb::task_arena& arena, Run&& run) {
  benchmark::RegisterBenchmark(name.c_str(), [&arena, run](benchmark::State& state) {
    arena.execute([&] { run(state); });
  })->Unit(benchmark::kMillisecond);
}

void register_contender(const std::string& name, Contender& contender, const Scene& scene, const Truth& truth,
                        tbb::task_arena& arena) {
  add("index_build/" + name, arena, [&](benchmark::State& state) {
    for (auto _ : state) contender.build(scene);
  });
  add("index_query/" + name + "/samples:" + std::to_string(scene.samples.size()), arena, [&](benchmark::State& state) {
    contender.build(scene);
    const std::string error = truth.judge(scene, contender);
    if (!error.empty()) return state.SkipWithError(error.c_str());
    std::size_t points = 0;
    for (auto _ : state) points = contender.query(scene, nullptr);
    state.counters["neighbours"] = double(points) / double(scene.samples.size());
  });
}

// `name` without the tiles' own measurements is no contender for them.
void register_tiles(const std::string& name, TileContender& contender, const Scene& scene, const Truth& truth,
                    tbb::task_arena& arena) {
  register_contender(name, contender, scene, truth, arena);
  const std::string size = "/samples:" + std::to_string(scene.samples.size());
  add("index_blocks/" + name + size, arena, [&](benchmark::State& state) {
    contender.build(scene);
    for (auto _ : state) benchmark::DoNotOptimize(contender.query_blocks());
  });
  add("index_moments/" + name + size, arena, [&](benchmark::State& state) {
    contender.build(scene);
    const std::size_t expected = contender.query(scene, nullptr);
    std::size_t points = 0;
    for (auto _ : state) points = contender.sum_moments(scene);
    if (points != expected) return state.SkipWithError("moments count other points than the query finds");
    state.counters["neighbours"] = double(points) / double(scene.samples.size());
  });
}

void run(int argc, char** argv) {
  std::string cloud_name;
  Scene scene;
  scene.cloud = load_scene("", &cloud_name);
  scene.samples = sorted_samples(scene.cloud, kSamples);
  scene.pcl_cloud = baseline::to_pcl(scene.cloud.view());
  const Truth truth(scene);
  tbb::task_arena arena(1);

  TileContender embree_grouped(IndexKind::kEmbree, kernels::kMaxGroup), embree_single(IndexKind::kEmbree, 1);
  TileContender grid_grouped(IndexKind::kGrid, kernels::kMaxGroup), grid_single(IndexKind::kGrid, 1);
  PclContender pcl_kdtree(baseline::Search::kKdTree), pcl_organized(baseline::Search::kOrganized);
  NanoflannContender nanoflann_tree;
  register_tiles("embree_grouped", embree_grouped, scene, truth, arena);
  register_tiles("embree_single", embree_single, scene, truth, arena);
  register_tiles("grid_grouped", grid_grouped, scene, truth, arena);
  register_tiles("grid_single", grid_single, scene, truth, arena);
  register_contender("pcl_kdtree", pcl_kdtree, scene, truth, arena);
  if (scene.cloud.height > 1) register_contender("pcl_organized", pcl_organized, scene, truth, arena);
  register_contender("nanoflann", nanoflann_tree, scene, truth, arena);

  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) throw std::invalid_argument("unknown argument; see --help");
  benchmark::AddCustomContext("cloud", cloud_name + ", " + std::to_string(scene.cloud.size()) + " points");
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}

}  // namespace
}  // namespace handhold::bench

int main(int argc, char** argv) try { handhold::bench::run(argc, argv); } catch (const std::exception& error) {
  std::fprintf(stderr, "index_bench: %s\n", error.what());
  return 1;
}
