// How long frames take over thousands of them, beside an empty loop that spins for as long: what the machine adds to
// the loop is none of ours.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "frame_arguments.h"
#include "handhold/localizer.h"
#include "plot.h"
#include "png_file.h"
#include "progress.h"
#include "scene.h"
#include "statistics.h"

namespace handhold::bench {
namespace {

using Clock = std::chrono::steady_clock;
double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Work that depends on nothing but its count.
std::uint64_t spin(std::uint64_t steps) {
  std::uint64_t x = 1;
  for (std::uint64_t i = 0; i < steps; ++i) {
    x = x * 6364136223846793005u + 1442695040888963407u;
    asm volatile("" : "+r"(x));
  }
  return x;
}

/// Resident memory (MiB); 0 where the system does not tell.
double resident_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmRSS:", 0) == 0) return std::stod(line.substr(6)) / 1024;
  }
  return 0;
}

struct Percentiles {
  double p50, p90, p99, p999, most;
};
Percentiles percentiles(std::vector<double> ms) {
  return {quantile(ms, 0.5), quantile(ms, 0.9), quantile(ms, 0.99), quantile(ms, 0.999),
          *std::max_element(ms.begin(), ms.end())};
}
void print(const char* what, const Percentiles& p) {
  std::printf("%-16s %9.3f %9.3f %9.3f %9.3f %9.3f\n", what, p.p50, p.p90, p.p99, p.p999, p.most);
}

/// Share of the frames (%) in classes of a tenth of the median, of both in one figure; the last one has all above.
void write_histogram(const std::string& path, const std::vector<double>& frames, const std::vector<double>& loops,
                     double median) {
  constexpr std::size_t kFirst = 8, kClasses = 12;  // from 0.8 times the median on
  const auto shares = [&](const std::vector<double>& ms) {
    std::vector<double> y(kClasses, 0);
    for (const double t : ms) {
      const double k = std::floor(10 * t / median) - kFirst;
      y[static_cast<std::size_t>(std::clamp(k, 0.0, kClasses - 1.0))] += 100 / static_cast<double>(ms.size());
    }
    return y;
  };
  PlotPanel panel;
  panel.title = "Times of frames, and of a loop that spins as long";
  panel.x_label = "from (ms); the first class has all below, the last one all above";
  panel.y_label = "% of all";
  panel.series = {{"frames", {0.20f, 0.45f, 0.85f}, {}, shares(frames), {}},
                  {"empty loop", {0.90f, 0.45f, 0.15f}, {}, shares(loops), {}}};
  for (std::size_t k = 0; k < kClasses; ++k) {
    char text[16];
    std::snprintf(text, sizeof text, "%.1f", 0.1 * static_cast<double>(kFirst + k) * median);
    panel.groups.push_back(text);
  }
  write_png(path, draw_plot({panel}, 1));
}

void run(const std::string& path, const Options& options, int frames, const std::string& csv, const std::string& plot) {
  std::string name;
  const Cloud cloud = load_scene(path, &name);
  Localizer localizer(options);
  Result result;
  std::vector<double> warm;
  for (int i = 0; i < 50; ++i) {
    const auto start = Clock::now();
    localizer.localize(cloud.view(), result);
    warm.push_back(milliseconds_since(start));
  }
  if (result.status != Status::kOk && result.status != Status::kDeadline) {
    throw std::runtime_error(name + ": " + std::string(to_string(result.status)));
  }
  // As many steps as take the median frame's time.
  const double wanted = quantile(warm, 0.5);
  std::uint64_t steps = 1 << 20;
  for (int i = 0; i < 5; ++i) {
    std::vector<double> tries;
    for (int k = 0; k < 9; ++k) {
      const auto start = Clock::now();
      spin(steps);
      tries.push_back(milliseconds_since(start));
    }
    steps = std::max<std::uint64_t>(
        1, static_cast<std::uint64_t>(static_cast<double>(steps) * wanted / std::max(1e-6, quantile(tries, 0.5))));
  }
  std::vector<double> ms, loops;
  ms.reserve(static_cast<std::size_t>(frames)), loops.reserve(static_cast<std::size_t>(frames));
  const double before = resident_mib();
  {
    Progress progress;
    for (int i = 0; i < frames; ++i) {
      if (i % 16 == 0) progress.show("frame " + std::to_string(i) + " of " + std::to_string(frames));
      auto start = Clock::now();
      localizer.localize(cloud.view(), result);
      ms.push_back(milliseconds_since(start));
      start = Clock::now();
      spin(steps);
      loops.push_back(milliseconds_since(start));
    }
  }
  const double after = resident_mib();
  const Percentiles frame = percentiles(ms), loop = percentiles(loops);
  std::printf("%s: %zu points, %d samples, method %s, %d threads, %s; %d frames and as many loops in turn (%s)\n",
              name.c_str(), cloud.size(), options.samples, std::string(to_string(options.method)).c_str(),
              options.threads, std::string(to_string(localizer.backend())).c_str(), frames, Localizer::isa());
  std::printf("ms                     p50       p90       p99     p99.9       max\n");
  print("frame", frame);
  print("empty loop", loop);
  std::printf("p99 of the frame minus the loop's: %.3f ms, %.2f of the frame's median\n", frame.p99 - loop.p99,
              (frame.p99 - loop.p99) / frame.p50);
  if (before > 0) std::printf("resident memory: %.1f MiB before, %.1f MiB after\n", before, after);
  if (!csv.empty()) {
    AtomicFile file(csv);
    file.write("frame_ms,loop_ms\n");
    for (std::size_t i = 0; i < ms.size(); ++i) {
      file.write(std::to_string(ms[i]) + ',' + std::to_string(loops[i]) + '\n');
    }
    file.commit();
  }
  if (!plot.empty()) write_histogram(plot, ms, loops, frame.p50);
}

}  // namespace
}  // namespace handhold::bench

int main(int argc, char** argv) {
  CLI::App app{"Times frame after frame of a cloud, in turn with an empty loop of the same length"};
  handhold::bench::FrameArguments a;
  a.frames = 10000;
  app.add_option("--deadline-ms", a.options.deadline_ms, "the frame ends after so long (ms)");
  return handhold::bench::main_of(app, argc, argv, "--frames", a,
                                  [&] { handhold::bench::run(a.cloud, a.options, a.frames, a.csv, a.plot); });
}
