// What the CUDA backend is worth: each stage of a frame and whole frames, beside the CPU's and beside the least time
// that the card could take, and frames a second with several in flight. By the paper's method with uniform samples.
//
// On the way it checks that both find the same. --dry goes through all of it without a GPU, on stages that run on the
// CPU: the times of such a run mean nothing.
#include <tbb/info.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "atomic_file.h"
#include "bounds.h"
#include "cuda/cuda_frame.h"
#include "cuda_card.h"
#include "device_frame.h"
#include "floors.h"
#include "handhold/device.h"
#include "handhold/localizer.h"
#include "handles.h"
#include "kernels.h"
#include "localizer_detail.h"
#include "result_difference.h"
#include "sampler.h"
#include "scene.h"
#include "search.h"
#include "table.h"
#ifdef HANDHOLD_WITH_HOST_STAGES
#include "host_frame.h"
#endif

namespace handhold::bench {
namespace {

using Clock = std::chrono::steady_clock;
double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

struct Arguments {
  std::string cloud, json, write_raw;
  bool quick = false, dry = false;
  int threads = std::min(16, static_cast<int>(tbb::info::default_concurrency()));
  int seed = 1;
};

/// How much is done. Seconds bound what is repeated.
struct Effort {
  std::vector<int> samples = {2000, 5000, 20'000, 100'000, 1'000'000};
  int most_on_cpu = 100'000;  ///< samples; the CPU looks at more of them once only, to be compared
  int stage_samples = 20'000, flight_samples = 5000;
  int stage_repeats = 50;
  int most_repeats = 50, least_repeats = 3;
  double row_seconds = 1.5;      ///< for a row of the table of whole frames
  double flight_seconds = 0.75;  ///< for a row of the tables of frames a second
  std::vector<int> in_flight = {1, 2, 4, 8};
  int clouds = 16;  ///< in turn
};
Effort effort_of(const Arguments& a) {
  Effort e;
  if (a.quick) e.row_seconds = 0.4, e.flight_seconds = 0.2, e.least_repeats = 1;
  if (a.dry) {
    e.samples = {300, 1000}, e.most_on_cpu = 300, e.stage_samples = 1000, e.flight_samples = 300;
    e.row_seconds = 0.05, e.flight_seconds = 0.05, e.in_flight = {1, 2}, e.clouds = 3;
  }
  return e;
}

// ---- Clouds ---------------------------------------------------------------------------------------------------------

constexpr const char* kRaw = ".raw";
bool is_raw(const std::string& path) {
  return path.size() > 4 && path.compare(path.size() - 4, 4, kRaw) == 0;
}

/// Width and height in 32 bits each, then x, y and z of each point: for builds without a reader of PCD.
Cloud read_raw(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::uint32_t shape[2] = {};
  Cloud cloud;
  if (file.read(reinterpret_cast<char*>(shape), sizeof shape)) {
    cloud.width = shape[0], cloud.height = shape[1];
    if (cloud.size() > 0 && cloud.size() < std::size_t{1} << 28) {
      cloud.xyz.resize(3 * cloud.size());
      file.read(reinterpret_cast<char*>(cloud.xyz.data()),
                static_cast<std::streamsize>(sizeof(float) * cloud.xyz.size()));
      if (file && file.peek() == std::ifstream::traits_type::eof()) return cloud;
    }
  }
  throw std::runtime_error(path + ": is not a raw cloud (width, height, and so many points of three floats)");
}
void write_raw(const std::string& path, const Cloud& cloud) {
  const std::uint32_t shape[2] = {cloud.width, cloud.height};
  std::string bytes(reinterpret_cast<const char*>(shape), sizeof shape);
  bytes.append(reinterpret_cast<const char*>(cloud.xyz.data()), sizeof(float) * cloud.xyz.size());
  write_file(path, bytes);
}

Cloud load(const std::string& path, std::string& name) {
  Cloud cloud = is_raw(path) ? read_raw(path) : load_scene(path, &name);
  if (is_raw(path)) name = path;
  if (cloud.size() == 0) throw std::runtime_error(name + ": has no points");
  return cloud;
}

/// The points in another order, no image any more.
Cloud shuffled(const Cloud& cloud) {
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), std::mt19937(7));
  Cloud other;
  other.width = static_cast<std::uint32_t>(cloud.size()), other.height = 1;
  other.viewpoint = cloud.viewpoint;
  other.xyz.reserve(cloud.xyz.size());
  for (const std::uint32_t i : order) {
    const float* p = &cloud.xyz[3 * std::size_t{i}];
    other.xyz.insert(other.xyz.end(), p, p + 3);
  }
  return other;
}

/// Each point a little nearer or farther, by 0.2 mm at a metre: other bytes, the same things to find.
Cloud perturbed(const Cloud& cloud, std::uint32_t seed) {
  Cloud other = cloud;
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(1.0f, 2e-4f);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float factor = noise(random);
    for (std::size_t k = 0; k < 3; ++k) other.xyz[3 * i + k] *= factor;
  }
  return other;
}

// ---- Where it runs --------------------------------------------------------------------------------------------------

Options options_of(int samples, int threads, int seed) {
  Options o;
  o.method = Method::kPaper;
  o.strategy = Strategy::kUniform;
  o.samples = samples;
  o.threads = threads;
  o.seed = static_cast<decltype(o.seed)>(seed);
  return o;
}

std::unique_ptr<DeviceFrame> device_frame(bool dry) {
#ifdef HANDHOLD_WITH_HOST_STAGES
  if (dry) return std::make_unique<test::HostFrame>();
#endif
  (void)dry;
  return make_cuda_frame();
}
Localizer device_localizer(Options options, bool dry) {
  if (dry) return LocalizerInside::on_device(options, device_frame(true));
  options.backend = Backend::kCuda;
  return Localizer(options);
}

/// What DeviceSearch asks a frame for.
kernels::FrameQuery query_of(const Options& options, const CloudView& cloud) {
  const Scale scale = scales_of(options).front();
  kernels::FrameQuery q{};
  q.fit = fit_limits(options, scale.radius, false, cloud.viewpoint);
  q.shell = shell_limits(options);
  q.radius = static_cast<float>(scale.radius);
  q.flat_rms = scale.flat_rms, q.flat_slope = scale.flat_slope;
  q.min_points = options.min_neighbours;
  q.align = align_limits(options);
  q.seed = options.seed, q.stream = Sampler::uniform_stream(0);
  q.samples = static_cast<std::uint32_t>(options.samples);
  return q;
}

/// All samples in one round.
void draw(DeviceFrame& frame, const Options& options, const CloudView& cloud) {
  const kernels::FrameQuery query = query_of(options, cloud);
  frame.draw(&query, 1);
}

// ---- Numbers --------------------------------------------------------------------------------------------------------

struct Spread {
  double median = 0, least = 0, p95 = 0;
};
Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(values.size()))) - 1;
  return {median(values), values.front(), values[at]};
}
template <class Run>
Spread repeated(int times, Run&& run) {
  std::vector<double> values;
  for (int i = 0; i < times; ++i) values.push_back(run());
  return spread_of(std::move(values));
}
/// null where there is nothing to divide by.
Json ratio(double a, double b) {
  return b > 0 ? Json(a / b) : Json(nullptr);
}

// ---- The benchmark --------------------------------------------------------------------------------------------------

class Benchmark {
 public:
  Benchmark(const Arguments& a, Cloud cloud, std::string name)
      : a_(a), effort_(effort_of(a)), cloud_(std::move(cloud)), name_(std::move(name)) {}

  void run() {
    if (!a_.json.empty()) AtomicFile::check_writable(a_.json);
    try {
      run_all();
    } catch (const std::exception& error) {
      json_["error"] = error.what();
      save();
      throw;
    }
  }
  bool all_same() const { return all_same_; }

 private:
  struct Scene {
    const char* name;
    PinnedCloud pinned;
    Cloud cloud;  ///< pageable
  };

  void run_all() {
    machine();
    scenes_.push_back({cloud_.height > 1 ? "organized" : "unorganized", PinnedCloud(cloud_.view(), !a_.dry), cloud_});
    Cloud other = shuffled(cloud_);
    scenes_.push_back({"shuffled", PinnedCloud(other.view(), !a_.dry), std::move(other)});
    stages();
    frames();
    flights();
    const double seconds = 1e-3 * milliseconds_since(start_);
    std::printf("\n%s; %.1f s in all\n",
                all_same_ ? "GPU and CPU find the same to the bit" : "GPU AND CPU DO NOT FIND THE SAME", seconds);
    json_["seconds"] = seconds, json_["same"] = all_same_;
    save();
  }

  void save() const {
    if (!a_.json.empty()) write_file(a_.json, json_.dump(2) + "\n");
  }
  /// A table that is done. What there is so far is written, should the rest fail.
  void show(const char* key, const Table& table) {
    std::fputs(table.text().c_str(), stdout);
    std::fflush(stdout);
    json_[key] = table.json();
    save();
  }
  Options options(int samples, int threads) const { return options_of(samples, threads, a_.seed); }

  void machine() {
    card_ = a_.dry ? assumed_card() : measure_card();
    char date[32];
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    std::strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", &utc);
    const PinnedCloud try_out(cloud_.view(), !a_.dry);
    Table t("machine", {{"what", "", 0}, {"value", "", 0}});
    const auto number = [](double x, const char* unit, int decimals = 0) {
      char text[64];
      std::snprintf(text, sizeof text, "%.*f %s", decimals, x, unit);
      return std::string(text);
    };
    t.add({"date", date});
    t.add({"GPU", card_.name});
    t.add({"compute capability", card_.capability});
    t.add({"driver", card_.driver});
    t.add({"runtime", card_.runtime});
    t.add({"multiprocessors", std::to_string(card_.multiprocessors)});
    t.add({"clock, highest", number(1e-6 * card_.clock, "MHz")});
    t.add({"lanes of a multiprocessor",
           std::to_string(card_.fp32_lanes) + " FP32, " + std::to_string(card_.fp64_lanes) + " FP64"});
    t.add({"memory", number(card_.memory / (1 << 30), "GiB") + ", L2 " + number(card_.l2 / (1 << 20), "MiB")});
    t.add({"memory clock", number(1e-6 * card_.memory_clock, "MHz") + ", " + std::to_string(card_.memory_bits) +
                               " bits: " + number(2e-9 * card_.memory_clock * card_.memory_bits / 8, "GB/s")});
    t.add({"copy on the device, read + written", number(1e-9 * card_.rates.memory, "GB/s")});
    t.add({"copy from pinned memory", number(1e-9 * card_.rates.up, "GB/s", 1)});
    t.add({"copy to pinned memory", number(1e-9 * card_.rates.down, "GB/s", 1)});
    t.add({"memory of the caller, pinned by", try_out.how()});
    t.add({"CPU", std::string(Localizer::isa()) + ", " + std::to_string(a_.threads) + " threads at most"});
    t.add({"cloud", name_ + ", " + std::to_string(cloud_.width) + " x " + std::to_string(cloud_.height)});
    json_["program"] = "handhold_cuda_bench";
    json_["dry"] = a_.dry, json_["quick"] = a_.quick;
    show("machine", t);
    json_["rates_per_s"] = {{"up_bytes", card_.rates.up},
                            {"down_bytes", card_.rates.down},
                            {"memory_bytes", card_.rates.memory},
                            {"fp32_operations", card_.rates.fp32},
                            {"fp64_operations", card_.rates.fp64}};
  }

  // ---- Stages, and their floors -----------------------------------------------------------------------------------

  void stages() {
    Table times("stages of a frame, " + std::to_string(effort_.stage_samples) + " samples, by events (us; median of " +
                    std::to_string(effort_.stage_repeats) + ")",
                {{"cloud", "cloud", 0},
                 {"stage", "stage", 0},
                 {"median_us", "median", 1},
                 {"min_us", "min", 1},
                 {"p95_us", "p95", 1}});
    Table floors("floors of these frames: what has to be moved and computed, over what the card does in a second",
                 {{"cloud", "cloud", 0},
                  {"stage", "stage", 0},
                  {"bus_kb", "bus kB", 1},
                  {"memory_kb", "memory kB", 1},
                  {"fp32_mops", "FP32 Mop", 2},
                  {"fp64_mops", "FP64 Mop", 2},
                  {"floor_us", "floor us", 2},
                  {"floor_by", "by", 0},
                  {"measured_us", "measured us", 1},
                  {"measured_over_floor", "times the floor", 1}});
    Json counts = Json::array();
    for (const Scene& scene : scenes_) stages_of(scene, times, floors, counts);
    show("stages", times);
    std::printf("\n");
    for (const std::string& line : formulas()) std::printf("%s\n", line.c_str());
    std::printf("counted: ");
    for (const Json& c : counts) std::printf("%s\n         ", c.dump().c_str());
    json_["counts"] = std::move(counts);
    json_["formulas"] = formulas();
    show("floors", floors);
  }

  void stages_of(const Scene& scene, Table& times, Table& floors, Json& counts) {
    const Options o = options(effort_.stage_samples, a_.threads);
    const CloudView view = scene.pinned.view();
    RobustBounds bounds;
    bounds.find(view);
    const std::unique_ptr<DeviceFrame> frame = device_frame(a_.dry);
    auto* gpu = dynamic_cast<CudaFrame*>(frame.get());
    DeviceFrame::Found found;
    for (int i = 0; i < 3; ++i) {
      frame->take(view, bounds);
      draw(*frame, o, view);
      found = frame->wait();
    }
    // What was looked at, by the CPU, at the CPU's samples: they are the same.
    Localizer cpu(o);
    const Result expected = cpu.localize(view);
    const std::vector<Sample> samples = cpu.samples();
    const Looked looked = look(o, view, samples);
    const std::uint32_t gpu_summed = gpu ? gpu->counts().summed : static_cast<std::uint32_t>(looked.summed);
    const std::uint32_t gpu_candidates = gpu ? gpu->counts().candidates : found.shells;
    FrameSizes sizes;
    sizes.points = static_cast<double>(view.size());
    sizes.organized = view.width >= 4 && view.height >= 4;
    sizes.key_bytes = 3 * bounds.cells().bits + 1 <= 32 ? 4 : 8;
    sizes.samples = o.samples, sizes.candidates = gpu_candidates, sizes.found = found.shells;
    const Operations point = operations_of_point();
    const FitOperations fit = operations_of_fit(looked.moments);
    counts.push_back({{"cloud", scene.name},
                      {"P", view.size()},
                      {"finite", found.finite},
                      {"B", looked.blocks},
                      {"S", o.samples},
                      {"K", gpu_summed},
                      {"K_cpu", looked.summed},
                      {"N", looked.points},
                      {"T", looked.touched},
                      {"C", gpu_candidates},
                      {"A", found.shells},
                      {"operations_a_point", point.all()},
                      {"operations_a_quadric", std::round(fit.quadric.all())},
                      {"operations_a_circle", std::round(fit.circle.all())}});
    if (gpu_summed != looked.summed || found.finite != looked.finite || found.shells != expected.affordances.size()) {
      all_same_ = false;
    }

    const std::array<Work, kStages> work = work_of_stages(sizes, looked);
    static_assert(CudaFrame::kStages == kStages);
    const auto add = [&](const char* stage, const Work& w, const std::optional<Spread>& t) {
      const Floor floor = floor_of(w, card_.rates);
      const auto us = [](double seconds) { return 1e6 * seconds; };
      if (t) {
        times.add({scene.name, stage, t->median, t->least, t->p95});
      } else {
        times.add({scene.name, stage, nullptr, nullptr, nullptr});
      }
      floors.add({scene.name, stage, 1e-3 * (w.up + w.down), 1e-3 * w.memory, 1e-6 * w.fp32, 1e-6 * w.fp64,
                  us(floor.seconds), floor.by, t ? Json(t->median) : Json(nullptr),
                  t ? ratio(t->median, us(floor.seconds)) : Json(nullptr)});
    };
    Spread sum;
    for (int i = 0; i < CudaFrame::kStages; ++i) {
      const auto stage = static_cast<CudaFrame::Stage>(i);
      std::optional<Spread> t;
      if (gpu) {
        for (int k = 0; k < 3; ++k) gpu->time(stage);
        t = repeated(effort_.stage_repeats, [&] { return 1e3 * static_cast<double>(gpu->time(stage)); });
        sum.median += t->median, sum.least += t->least, sum.p95 += t->p95;
      }
      add(CudaFrame::name(stage), work[static_cast<std::size_t>(i)], t);
    }
    if (gpu) {
      times.add({scene.name, "sum", sum.median, sum.least, sum.p95});
    } else {
      times.add({scene.name, "sum", nullptr, nullptr, nullptr});
    }
    for (const bool upload : {false, true}) {
      std::optional<Spread> t;
      if (gpu) {
        for (int k = 0; k < 3; ++k) gpu->time_frame(upload);
        t = repeated(effort_.stage_repeats, [&] { return 1e3 * static_cast<double>(gpu->time_frame(upload)); });
      }
      add(upload ? "frame + upload" : "frame", work_of_frame(sizes, looked, upload), t);
    }
  }

  // ---- Whole frames -----------------------------------------------------------------------------------------------

  void frames() {
    Table times(
        "whole frames (ms; medians): on the device as one graph, and Localizer::localize on the GPU from memory "
        "that is pinned and that is not, and on the CPU, in turn",
        {{"cloud", "cloud", 0},
         {"samples", "samples", 0},
         {"threads", "threads", 0},
         {"graph_ms", "graph", 3},
         {"graph_upload_ms", "+ upload", 3},
         {"pinned_ms", "pinned", 3},
         {"pageable_ms", "pageable", 3},
         {"handles_ms", "of it handles", 3},
         {"cpu_ms", "CPU", 3},
         {"ratio_pinned", "CPU / pinned", 2},
         {"ratio_pageable", "CPU / pageable", 2},
         {"repeats", "repeats", 0}});
    Table same("are they the same? what differs between the CPU's result and the GPU's (both memories)",
               {{"cloud", "cloud", 0},
                {"samples", "samples", 0},
                {"threads", "threads", 0},
                {"affordances", "affordances", 0},
                {"handles", "handles", 0},
                {"places_differ", "places differ", 0},
                {"steps_differ", "steps differ", 0},
                {"affordances_differ", "affordances differ", 0},
                {"handles_differ", "handles differ", 0},
                {"centre_m", "centre by m", -1},
                {"axis_rad", "axis by rad", -1}});
    const auto rows = [&](const Scene& scene, int samples) {
      frame_rows(scene, samples, times, same);
      json_["frames"] = times.json(), json_["results"] = same.json();
      save();
    };
    const auto print = [&] { show("frames", times), show("results", same); };
    try {
      for (const int samples : effort_.samples) {
        if (samples <= effort_.most_on_cpu) rows(scenes_[0], samples);
      }
      rows(scenes_[1], effort_.stage_samples);
      // What takes the most memory comes last.
      for (const int samples : effort_.samples) {
        if (samples > effort_.most_on_cpu) rows(scenes_[0], samples);
      }
    } catch (...) {
      print();
      throw;
    }
    print();
  }

  void frame_rows(const Scene& scene, int samples, Table& times, Table& same) {
    Spread graph[2];
    bool timed = false;
    {
      const std::unique_ptr<DeviceFrame> frame = device_frame(a_.dry);
      if (auto* gpu = dynamic_cast<CudaFrame*>(frame.get())) {
        const CloudView view = scene.pinned.view();
        RobustBounds bounds;
        bounds.find(view);
        gpu->take(view, bounds);
        draw(*gpu, options(samples, a_.threads), view);
        gpu->wait();
        for (const bool upload : {false, true}) {
          for (int k = 0; k < 3; ++k) gpu->time_frame(upload);
          graph[upload] = repeated(effort_.stage_repeats, [&] { return static_cast<double>(gpu->time_frame(upload)); });
        }
        timed = true;
      }
    }
    std::vector<int> threads = {1};
    if (a_.threads > 1) threads.push_back(a_.threads);
    if (samples > effort_.most_on_cpu) threads = {a_.threads};
    for (const int n : threads) {
      const Options o = options(samples, n);
      Localizer gpu = device_localizer(o, a_.dry), cpu(o);
      const CloudView pinned = scene.pinned.view(), pageable = scene.cloud.view();
      const auto outcome = [](Localizer& localizer, const CloudView& view) {
        Outcome all;
        localizer.localize(view, all.result);
        all.samples = localizer.samples();
        return all;
      };
      // Memory grows to its size meanwhile.
      const Outcome expected = outcome(cpu, pageable);
      Difference d = difference(expected, outcome(gpu, pageable));
      d.add(difference(expected, outcome(gpu, pinned)));
      all_same_ &= d.none() && expected.result.status == Status::kOk;
      same.add({scene.name, samples, n, expected.result.affordances.size(), expected.result.handles.size(), d.places,
                d.steps, d.affordances, d.handles, d.centre, d.axis});

      const bool on_cpu = samples <= effort_.most_on_cpu;
      std::vector<double> of_pinned, of_pageable, of_cpu, handles;
      Result result, result_of_cpu;
      const auto time = [](Localizer& localizer, const CloudView& view, Result& to) {
        const auto start = Clock::now();
        localizer.localize(view, to);
        return milliseconds_since(start);
      };
      const auto round = [&] {
        of_pageable.push_back(time(gpu, pageable, result));
        handles.push_back(result.times_ms.handles);
        of_pinned.push_back(time(gpu, pinned, result));
        if (on_cpu) of_cpu.push_back(time(cpu, pageable, result_of_cpu));
      };
      const auto start = Clock::now();
      round();
      const double once = milliseconds_since(start);
      // The first round tells how many there can be; where there can be others it does not count.
      const int repeats = std::clamp(static_cast<int>(1e3 * effort_.row_seconds / std::max(1e-3, once)),
                                     effort_.least_repeats, effort_.most_repeats);
      if (repeats > 1) {
        for (auto* list : {&of_pinned, &of_pageable, &of_cpu, &handles}) list->clear();
        for (int i = 0; i < repeats; ++i) round();
      }
      const double p = median(of_pinned), q = median(of_pageable), c = median(of_cpu);
      times.add({scene.name, samples, n, timed ? Json(graph[0].median) : Json(nullptr),
                 timed ? Json(graph[1].median) : Json(nullptr), p, q, median(handles), on_cpu ? Json(c) : Json(nullptr),
                 on_cpu ? ratio(c, p) : Json(nullptr), on_cpu ? ratio(c, q) : Json(nullptr), repeats});
    }
  }

  // ---- Frames a second --------------------------------------------------------------------------------------------

  /// A cloud of those that come in turn, and what the CPU finds in it.
  struct Turn {
    Cloud cloud;
    PinnedCloud pinned;
    RobustBounds bounds;
    std::size_t affordances, handles;
    std::uint64_t mark;
  };
  /// Differs where any place or axis of an affordance does in any bit, nearly surely; the order does not matter.
  static std::uint64_t mark(const double* centre, const double* axis, std::uint32_t sample) {
    std::uint64_t all = sample + std::uint64_t{1};
    for (int k = 0; k < 6; ++k) {
      std::uint64_t bits;
      std::memcpy(&bits, k < 3 ? centre + k : axis + k - 3, sizeof bits);
      all = (all ^ bits) * 0x9e3779b97f4a7c15u;
      all ^= all >> 32;
    }
    return all;
  }
  static std::uint64_t mark(const Result& result) {
    std::uint64_t all = 0;
    for (const Affordance& a : result.affordances) all += mark(a.center.data(), a.axis.data(), a.sample);
    return all;
  }
  static std::uint64_t mark(const DeviceFrame::Found& found) {
    std::uint64_t all = 0;
    for (std::uint32_t i = 0; i < found.shells; ++i) {
      all += mark(found.shell[i].place.center, found.shell[i].place.axis, found.shell[i].sample);
    }
    return all;
  }

  void flights() {
    const Options o = options(effort_.flight_samples, 1);
    Localizer cpu(o);
    std::vector<Turn> turns;
    for (int i = 0; i < effort_.clouds; ++i) {
      Cloud cloud = perturbed(cloud_, static_cast<std::uint32_t>(100 + i));
      PinnedCloud pinned(cloud.view(), !a_.dry);
      const Result r = cpu.localize(cloud.view());
      RobustBounds bounds;
      bounds.find(cloud.view());
      turns.push_back(
          {std::move(cloud), std::move(pinned), std::move(bounds), r.affordances.size(), r.handles.size(), mark(r)});
    }
    Table table("frames a second, " + std::to_string(o.samples) + " samples, " + std::to_string(turns.size()) +
                    " clouds in turn (the upload alone allows " +
                    std::to_string(std::llround(card_.rates.up / (12.0 * static_cast<double>(cloud_.size())))) + ")",
                {{"way", "way", 0},
                 {"in_flight", "in flight", 0},
                 {"frames", "frames", 0},
                 {"frames_per_s", "frames/s", 0},
                 {"over_one", "times one", 2},
                 {"wrong", "wrong", 0}});
    double one = 0;
    const auto add = [&](const char* way, int n, const Flight& f) {
      const double rate = static_cast<double>(f.frames) / f.seconds;
      if (n == effort_.in_flight.front()) one = rate;
      all_same_ &= f.wrong == 0;
      table.add({way, n, f.frames, rate, ratio(rate, one), f.wrong});
    };
    for (const int n : effort_.in_flight) add("one thread, frames in turn (shells, pinned)", n, in_turn(o, turns, n));
    for (const int n : effort_.in_flight)
      add("a localizer a thread (handles, pinned)", n, by_threads(o, turns, n, true));
    for (const int n : effort_.in_flight)
      add("a localizer a thread (handles, pageable)", n, by_threads(o, turns, n, false));
    show("frames_a_second", table);
  }

  struct Flight {
    std::int64_t frames = 0, wrong = 0;
    double seconds = 0;
  };

  /// One thread takes, draws, and waits for the oldest of `n`.
  Flight in_turn(const Options& o, const std::vector<Turn>& turns, int n) const {
    struct Slot {
      std::unique_ptr<DeviceFrame> frame;
      const Turn* of = nullptr;  ///< what is in flight; null: nothing
    };
    std::vector<Slot> slots(static_cast<std::size_t>(n));
    for (Slot& s : slots) s.frame = device_frame(a_.dry);
    Flight flight;
    const auto land = [&](Slot& s) {
      if (!s.of) return;
      const DeviceFrame::Found found = s.frame->wait();
      ++flight.frames, flight.wrong += found.shells != s.of->affordances || mark(found) != s.of->mark;
      s.of = nullptr;
    };
    const auto start_one = [&](Slot& s, const Turn& turn) {
      const CloudView view = turn.pinned.view();
      s.frame->take(view, turn.bounds);
      draw(*s.frame, o, view);
      s.of = &turn;
    };
    std::size_t next = 0;
    const auto fly = [&](double seconds) {
      flight = {};
      const auto start = Clock::now();
      while (1e-3 * milliseconds_since(start) < seconds) {
        Slot& s = slots[next % slots.size()];
        land(s);
        start_one(s, turns[next % turns.size()]);
        ++next;
      }
      for (std::size_t i = 0; i < slots.size(); ++i) land(slots[(next + i) % slots.size()]);
      flight.seconds = 1e-3 * milliseconds_since(start);
    };
    // Memory and graphs are made in the first frames.
    for (Slot& s : slots) {
      for (int i = 0; i < 2; ++i) start_one(s, turns.front()), land(s);
    }
    fly(0.1 * effort_.flight_seconds);
    fly(effort_.flight_seconds);
    return flight;
  }

  /// Each thread has its localizer.
  Flight by_threads(const Options& o, const std::vector<Turn>& turns, int n, bool pinned) const {
    struct Worker {
      Localizer localizer;
      Result result;
      Flight flight;
      std::exception_ptr failure;
    };
    std::vector<std::unique_ptr<Worker>> workers;
    for (int i = 0; i < n; ++i) {
      workers.push_back(std::unique_ptr<Worker>(new Worker{device_localizer(o, a_.dry), {}, {}, {}}));
      for (int k = 0; k < 2; ++k) workers.back()->localizer.localize(turns.front().pinned.view());
    }
    std::atomic<bool> go{false};
    const auto work = [&](Worker& w, std::size_t next) {
      try {
        while (!go.load(std::memory_order_acquire)) std::this_thread::yield();
        const auto start = Clock::now();
        do {
          const Turn& turn = turns[next++ % turns.size()];
          w.localizer.localize(pinned ? turn.pinned.view() : turn.cloud.view(), w.result);
          ++w.flight.frames;
          w.flight.wrong += w.result.affordances.size() != turn.affordances ||
                            w.result.handles.size() != turn.handles || mark(w.result) != turn.mark;
        } while (1e-3 * milliseconds_since(start) < effort_.flight_seconds);
      } catch (...) {
        w.failure = std::current_exception();
      }
    };
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < workers.size(); ++i) {
      threads.emplace_back(work, std::ref(*workers[i]), i * turns.size() / workers.size());
    }
    const auto start = Clock::now();
    go.store(true, std::memory_order_release);
    for (std::thread& t : threads) t.join();
    Flight all;
    all.seconds = 1e-3 * milliseconds_since(start);
    for (const auto& w : workers) {
      if (w->failure) std::rethrow_exception(w->failure);
      all.frames += w->flight.frames, all.wrong += w->flight.wrong;
    }
    return all;
  }

  const Arguments a_;
  const Effort effort_;
  const Clock::time_point start_ = Clock::now();
  Cloud cloud_;
  std::string name_;
  Card card_;
  std::vector<Scene> scenes_;
  Json json_;
  bool all_same_ = true;
};

}  // namespace
}  // namespace handhold::bench

int main(int argc, char** argv) {
  using namespace handhold;
  bench::Arguments a;
  CLI::App app{"Times the CUDA backend beside the CPU, and checks that both find the same"};
  app.add_option("cloud", a.cloud,
                 "PCD or PLY file, or a .raw one of --write-raw; default: data/table_scene.pcd, or a synthetic frame");
  app.add_option("--json", a.json, "Write everything that is printed, too");
  app.add_flag("--quick", a.quick, "A quarter of the time");
  app.add_option("--threads", a.threads, "threads of the CPU, beside one")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--seed", a.seed, "of the samples")->check(CLI::Range(0, 1000000000))->capture_default_str();
  app.add_option("--write-raw", a.write_raw, "Write the cloud to FILE.raw, for a build that reads no PCD, and stop")
      ->check([](const std::string& path) { return bench::is_raw(path) ? "" : path + ": must end in .raw"; });
#ifdef HANDHOLD_WITH_HOST_STAGES
  app.add_flag("--dry", a.dry, "Without a GPU: go through everything, with times that mean nothing");
#endif
  CLI11_PARSE(app, argc, argv);
  try {
    std::string name;
    if (!a.write_raw.empty()) {
      bench::write_raw(a.write_raw, bench::load(a.cloud, name));
      return 0;
    }
    if (a.dry && !kernels::kernels("avx2") && !kernels::kernels("neon")) {
      throw std::runtime_error("--dry needs a CPU with AVX2 or NEON, for the stages that it runs");
    }
    if (!a.dry) {
      const CudaDevice device = cuda_device();
      if (!device.available) throw std::runtime_error(device.reason);
    }
    Cloud cloud = bench::load(a.cloud, name);
    bench::Benchmark benchmark(a, std::move(cloud), name);
    benchmark.run();
    return benchmark.all_same() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handhold_cuda_bench: %s\n", error.what());
    return 1;
  }
}
