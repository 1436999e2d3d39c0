// Each kernel with each instruction set, and the classic stage that it replaces. Names: kernel/set/size.
//
// Counters: per_solve, per_point, ... are the time of one call divided by what it did.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "baseline/stages.h"
#include "handhold/options.h"
#include "kernels.h"
#include "scene.h"

namespace handhold::bench {
namespace {

using namespace kernels;

// Memory that starts on a cache line and vectors of the widest set.
template <class T>
class Aligned {
 public:
  explicit Aligned(std::size_t size)
      : size_(size), data_(static_cast<T*>(::operator new[](size * sizeof(T), std::align_val_t(64)))) {}
  T* data() { return data_.get(); }
  T& operator[](std::size_t i) { return data_.get()[i]; }
  std::size_t size() const { return size_; }

 private:
  struct Free {
    void operator()(T* p) const { ::operator delete[](p, std::align_val_t(64)); }
  };
  std::size_t size_;
  std::unique_ptr<T, Free> data_;
};

benchmark::Counter each(double count) {
  return benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

// An organized cloud in tiles of 4x4 pixels, blocks of 16x16.
struct TiledScene {
  explicit TiledScene(const Cloud& cloud, const Kernels& k)
      : columns(cloud.width / 16),
        blocks(static_cast<std::int32_t>(columns * (cloud.height / 16))),
        points(768 * std::size_t(blocks)),
        boxes(96 * std::size_t(blocks)),
        sums(160 * std::size_t(blocks)),
        full(std::size_t(blocks)) {
    for (std::int32_t block = 0; block < blocks; ++block) {
      for (int i = 0; i < 256; ++i) {
        const int tile = i / 16, pixel = i % 16;
        const std::size_t u = std::size_t(block % columns) * 16 + (tile % 4) * 4 + pixel % 4;
        const std::size_t v = std::size_t(block / columns) * 16 + (tile / 4) * 4 + pixel / 4;
        for (int axis = 0; axis < 3; ++axis)
          points[768 * std::size_t(block) + 48 * tile + 16 * axis + pixel] =
              cloud.xyz[3 * (v * cloud.width + u) + std::size_t(axis)];
      }
      const std::size_t b = std::size_t(block);
      k.finish_block(&points[768 * b], &boxes[96 * b], &full[b], &sums[160 * b]);
    }
  }
  Tiles tiles() { return {points.data(), boxes.data(), full.data(), sums.data(), blocks}; }

  std::int32_t columns, blocks;
  Aligned<float> points, boxes, sums;
  Aligned<std::uint16_t> full;
};

// The blocks whose boxes meet the ball about `center`: what an index would return.
struct BlockList {
  BlockList(TiledScene& scene, const float* center, float radius) : box(6) {
    std::vector<std::array<float, 6>> found_boxes;
    for (std::int32_t b = 0; b < scene.blocks; ++b) {
      std::array<float, 6> all;
      for (int row = 0; row < 6; ++row) {
        const float* tiles = &scene.boxes[96 * std::size_t(b) + 16 * std::size_t(row)];
        all[row] = row < 3 ? *std::min_element(tiles, tiles + 16) : *std::max_element(tiles, tiles + 16);
      }
      float distance2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const float outside = std::max({all[axis] - center[axis], 0.0f, center[axis] - all[axis + 3]});
        distance2 += outside * outside;
      }
      if (!(distance2 <= radius * radius)) continue;
      block.push_back(std::uint32_t(b));
      found_boxes.push_back(all);
    }
    while (block.size() % 16 || block.empty()) {
      block.push_back(0);
      found_boxes.push_back({kFar, kFar, kFar, -kFar, -kFar, -kFar});
    }
    for (int row = 0; row < 6; ++row) {
      box[row] = std::make_unique<Aligned<float>>(block.size());
      for (std::size_t i = 0; i < block.size(); ++i) (*box[row])[i] = found_boxes[i][row];
    }
  }
  Candidates candidates() {
    Candidates c{};
    for (int row = 0; row < 6; ++row) c.boxes[row] = box[row]->data();
    c.block = block.data();
    c.padded = static_cast<std::int32_t>(block.size());
    return c;
  }

  std::vector<std::unique_ptr<Aligned<float>>> box;
  std::vector<std::uint32_t> block;
};

const Cloud& scene_cloud() {
  static const Cloud cloud = make_scene();
  return cloud;
}

// 64 samples about the middle of the picture, about as dense as 5,000 samples of the frame.
std::vector<std::array<float, 3>> sample_group() {
  const Cloud& cloud = scene_cloud();
  std::vector<std::array<float, 3>> all = draw_samples(cloud.view(), 5000), group;
  const float* middle = cloud.view().point(cloud.width / 2 + std::size_t(cloud.height / 2) * cloud.width);
  std::sort(all.begin(), all.end(), [&](const auto& a, const auto& b) {
    const auto distance2 = [&](const auto& p) {
      return (p[0] - middle[0]) * (p[0] - middle[0]) + (p[1] - middle[1]) * (p[1] - middle[1]) +
             (p[2] - middle[2]) * (p[2] - middle[2]);
    };
    return distance2(a) < distance2(b);
  });
  for (int i = 0; i < kMaxGroup; ++i) group.push_back(all[std::size_t(i)]);
  return group;
}

// Moments of a noisy cylinder's patch of each lane's own radius and size, in the frame of its normal.
FitBatch make_fit_batch() {
  FitBatch batch{};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, 0.03);
  for (int lane = 0; lane < kBatch; ++lane) {
    const double radius = 0.6 + 0.1 * lane;
    for (int n = 0; n < 500;) {
      const double y = uniform(random), x = uniform(random);
      const double z = std::sqrt(std::max(0.0, radius * radius - y * y)) - radius + noise(random);
      if (std::abs(y) > radius || x * x + y * y + z * z > 1) continue;
      ++n;
      double px[5] = {1}, py[5] = {1}, pz[5] = {1};
      for (int e = 1; e < 5; ++e) px[e] = px[e - 1] * x, py[e] = py[e - 1] * y, pz[e] = pz[e - 1] * z;
      for (int i = 0; i <= 4; ++i)
        for (int j = 0; i + j <= 4; ++j)
          for (int k = 0; i + j + k <= 4; ++k) batch.moments[moment_index(i, j, k)][lane] += px[i] * py[j] * pz[k];
    }
  }
  return batch;
}

using FitKernel = void (*Kernels::*)(FitBatch&);

void run_fit(benchmark::State& state, const Kernels& k, FitKernel kernel) {
  FitBatch batch = make_fit_batch();
  k.taubin(batch);
  k.curvature(batch);
  for (int lane = 0; lane < kBatch; ++lane)
    if (batch.status[lane] != kFitOk) return state.SkipWithError("the fit of a cylinder says flat");
  for (auto _ : state) {
    (k.*kernel)(batch);
    benchmark::DoNotOptimize(batch);
  }
  state.counters["per_solve"] = each(kBatch);
}

void run_moments(benchmark::State& state, const Kernels& k, float radius) {
  TiledScene scene(scene_cloud(), k);
  const std::vector<std::array<float, 3>> group = sample_group();
  float middle[3] = {}, reach = 0;
  for (const auto& s : group)
    for (int axis = 0; axis < 3; ++axis) middle[axis] += s[axis] / static_cast<float>(group.size());
  for (const auto& s : group) reach = std::max(reach, std::hypot(s[0] - middle[0], s[1] - middle[1], s[2] - middle[2]));
  BlockList list(scene, middle, reach + radius);
  const Tiles tiles = scene.tiles();
  const Candidates candidates = list.candidates();
  Aligned<char> scratch(scratch_bytes(tiles.blocks));
  std::vector<Moments> out(kMaxGroup);
  NeighbourhoodBatch batch{};
  batch.centre = group.front().data();
  batch.n = kMaxGroup;
  batch.radius = radius;
  batch.flat_rms = 0;
  batch.min_points = 1;
  for (auto _ : state) {
    k.moments(tiles, candidates, batch, scratch.data(), out.data());
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  double points = 0;
  for (const Moments& m : out) points += m.count;
  state.counters["neighbours"] = points / kMaxGroup;
  state.counters["per_neighbourhood"] = each(kMaxGroup);
  state.counters["per_point"] = each(points);
}

ShellQuery shell_query() {
  ShellQuery query{};
  query.axis[2] = 1;
  query.half_width = 0.01f;
  query.start_radius = 0.014f;
  query.max_radius = 0.043f;
  query.gap = 0.01f;
  query.max_gap_points = 4;
  query.min_inner_points = 33;
  return query;
}

// Distances as beside a cylinder of 20 mm: a cluster of points at its radius, a share of `clutter` spread evenly.
Aligned<float> make_rho2(int n, double clutter) {
  Aligned<float> rho2(std::size_t(n + 15) / 16 * 16);
  std::mt19937 random(4);
  std::normal_distribution<double> surface(0.02, 0.001);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (std::size_t i = 0; i < rho2.size(); ++i) {
    const double rho = uniform(random) < clutter ? 0.053 * std::sqrt(uniform(random)) : surface(random);
    rho2[i] = i < std::size_t(n) ? static_cast<float>(rho * rho) : kFar;
  }
  return rho2;
}

void run_shell_gap(benchmark::State& state, const Kernels& k, int n, double clutter) {
  Aligned<float> rho2 = make_rho2(n, clutter);
  ShellQuery query = shell_query();
  query.max_gap_points = n / 200;
  ShellResult result{};
  for (auto _ : state) {
    k.shell_gap(rho2.data(), n, query, result);
    benchmark::DoNotOptimize(result);
  }
  state.counters["per_point"] = each(n);
  state.SetLabel(result.status == kShellFound ? "gap found" : "no gap");
}

void run_shell(benchmark::State& state, const Kernels& k) {
  TiledScene scene(scene_cloud(), k);
  const std::array<float, 3> sample = sample_group().front();
  ShellQuery query = shell_query();
  std::copy(sample.begin(), sample.end(), query.centre);
  BlockList list(scene, query.centre, std::hypot(query.max_radius + query.gap, query.half_width));
  const Tiles tiles = scene.tiles();
  const Candidates candidates = list.candidates();
  Aligned<char> scratch(scratch_bytes(tiles.blocks));
  ShellResult result{};
  for (auto _ : state) {
    k.shell(tiles, candidates, query, scratch.data(), result);
    benchmark::DoNotOptimize(result);
  }
}

void run_align(benchmark::State& state, const Kernels& k, int n) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-0.5f, 0.5f);
  const int padded = (n + 31) / 32 * 32;
  std::vector<Aligned<float>> arrays;
  for (int a = 0; a < 7; ++a) {
    arrays.emplace_back(std::size_t(padded));
    for (int i = 0; i < padded; ++i) arrays[a][std::size_t(i)] = i < n ? 0.3f * uniform(random) : NAN;
  }
  for (int i = 0; i < n; ++i) {
    float* axis[3] = {&arrays[3][std::size_t(i)], &arrays[4][std::size_t(i)], &arrays[5][std::size_t(i)]};
    *axis[2] += 0.3f;
    const float length = std::hypot(*axis[0], *axis[1], *axis[2]);
    for (float* component : axis) *component /= length;
  }
  const AffordanceArrays affordances = {arrays[0].data(), arrays[1].data(), arrays[2].data(), arrays[3].data(),
                                        arrays[4].data(), arrays[5].data(), arrays[6].data(), padded};
  const AlignLimits limits = {std::sin(0.35f), 0.01f, 0.005f};
  std::vector<std::uint32_t> row(std::size_t(padded) / 32);
  for (auto _ : state) {
    for (int i = 0; i < n; ++i) k.align(affordances, i, limits, row.data());
    benchmark::DoNotOptimize(row.data());
    benchmark::ClobberMemory();
  }
  state.counters["per_pair"] = each(double(n) * n);
}

// ---- The classic stages -------------------------------------------------------------------------------------------

struct ClassicScene {
  ClassicScene() : cloud(baseline::to_pcl(scene_cloud().view())), search(cloud, baseline::Search::kKdTree) {
    const std::array<float, 3> s = sample_group().front();
    sample = Eigen::Vector3f(s[0], s[1], s[2]);
  }
  baseline::PclCloud::Ptr cloud;
  baseline::RadiusSearch search;
  Eigen::Vector3f sample;
};

void run_classic_fit(benchmark::State& state) {
  ClassicScene scene;
  const std::vector<int>& neighbours = scene.search.find(scene.sample, 0.025);
  for (auto _ : state) {
    auto quadric = baseline::fit_quadric(*scene.cloud, neighbours, scene.sample, 0.025);
    benchmark::DoNotOptimize(quadric);
  }
  state.counters["neighbours"] = double(neighbours.size());
  state.counters["per_solve"] = each(1);
}

void run_classic_curvature(benchmark::State& state) {
  ClassicScene scene;
  const std::vector<int>& neighbours = scene.search.find(scene.sample, 0.025);
  const auto quadric = baseline::fit_quadric(*scene.cloud, neighbours, scene.sample, 0.025);
  for (auto _ : state) {
    auto curvature = baseline::estimate_curvature(quadric, *scene.cloud, neighbours, scene.sample, 0.025,
                                                  baseline::CurvaturePoints::kRandom);
    benchmark::DoNotOptimize(curvature);
  }
  state.counters["per_solve"] = each(1);
}

void run_classic_circle(benchmark::State& state) {
  ClassicScene scene;
  const std::vector<int>& neighbours = scene.search.find(scene.sample, 0.025);
  for (auto _ : state) {
    auto circle = baseline::fit_circle(*scene.cloud, neighbours, scene.sample, Eigen::Vector3d::UnitX());
    benchmark::DoNotOptimize(circle);
  }
  state.counters["neighbours"] = double(neighbours.size());
  state.counters["per_solve"] = each(1);
}

void run_classic_shell(benchmark::State& state) {
  ClassicScene scene;
  const ShellQuery query = shell_query();
  const baseline::ShellLimits limits = {query.half_width,
                                        query.start_radius,
                                        query.max_radius,
                                        query.gap,
                                        query.max_gap_points,
                                        query.min_inner_points,
                                        0.001};
  std::vector<float> rho2;
  for (auto _ : state) {
    auto shell = baseline::find_shell(*scene.cloud, scene.search, scene.sample.cast<double>(), Eigen::Vector3d::UnitZ(),
                                      limits, rho2);
    benchmark::DoNotOptimize(shell);
  }
}

void register_all() {
  int sets = 0;
  const char* const* names = available(&sets);
  const auto add = [&](const std::string& name, auto&& run) { benchmark::RegisterBenchmark(name.c_str(), run); };
  const auto for_each_set = [&](const std::string& kernel, const std::string& size, auto&& run) {
    for (int i = 0; i < sets; ++i) {
      const Kernels& k = *kernels::kernels(names[i]);
      add(kernel + '/' + names[i] + size, [&k, run](benchmark::State& state) { run(state, k); });
    }
  };
  for (const float radius : {0.015f, 0.025f, 0.04f})
    for_each_set("moments", "/radius_mm:" + std::to_string(std::lround(radius * 1000)),
                 [radius](benchmark::State& state, const Kernels& k) { run_moments(state, k, radius); });
  const std::pair<const char*, FitKernel> fits[] = {
      {"taubin", &Kernels::taubin}, {"curvature", &Kernels::curvature}, {"circle", &Kernels::circle}};
  for (const auto& [name, kernel] : fits)
    for_each_set(name, "", [kernel = kernel](benchmark::State& state, const Kernels& k) { run_fit(state, k, kernel); });
  // One in a hundred points off the surface leaves a gap; a third of them leaves none up to the last radius.
  for (const auto& [name, clutter] : {std::pair("shell_gap", 0.01), std::pair("shell_gap_crowded", 0.33)})
    for (const int n : {64, 512, 4096})
      for_each_set(
          name, "/points:" + std::to_string(n),
          [n, clutter = clutter](benchmark::State& state, const Kernels& k) { run_shell_gap(state, k, n, clutter); });
  for_each_set("shell", "", run_shell);
  for (const int n : {64, 512, 4096})
    for_each_set("align", "/affordances:" + std::to_string(n),
                 [n](benchmark::State& state, const Kernels& k) { run_align(state, k, n); });
  add("fit/classic", run_classic_fit);
  add("curvature/classic", run_classic_curvature);
  add("circle/classic", run_classic_circle);
  add("shell/classic", run_classic_shell);
}

}  // namespace
}  // namespace handhold::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  handhold::bench::register_all();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
