// How a frame's time grows: with samples, points, the radius of the neighbourhoods, and threads.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>
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

/// Every step-th row and column of an image, every (step * step)-th point of another cloud.
Cloud thinned(const Cloud& cloud, std::uint32_t step) {
  Cloud thin;
  thin.viewpoint = cloud.viewpoint;
  const CloudView view = cloud.view();
  const auto add = [&](std::size_t i) { thin.xyz.insert(thin.xyz.end(), view.point(i), view.point(i) + 3); };
  if (view.height > 1) {
    for (std::uint32_t v = 0; v < view.height; v += step)
      for (std::uint32_t u = 0; u < view.width; u += step) add(static_cast<std::size_t>(v) * view.width + u);
    thin.width = (view.width + step - 1) / step, thin.height = (view.height + step - 1) / step;
  } else {
    for (std::size_t i = 0; i < view.size(); i += std::size_t{step} * step) add(i);
    thin.width = static_cast<std::uint32_t>(thin.xyz.size() / 3), thin.height = 1;
  }
  return thin;
}

/// What is measured: a setting, and its time.
struct Case {
  double x;  ///< in the curve's unit
  Cloud const* cloud;
  Options options;
  double ms = 0;  ///< median
};
struct Curve {
  std::string what, unit;
  std::vector<Case> cases;
};

/// The medians of `repeat` frames each. All cases of a curve in turn, so that the machine's moods meet them alike.
void measure(Curve& curve, int repeat, Progress& progress) {
  std::vector<Localizer> localizers;
  for (const Case& c : curve.cases) localizers.emplace_back(c.options);
  std::vector<std::vector<double>> ms(curve.cases.size());
  Result result;
  for (int i = -2; i < repeat; ++i) {  // two to warm up
    progress.show(curve.what + ": frame " + std::to_string(std::max(0, i)) + " of " + std::to_string(repeat));
    for (std::size_t k = 0; k < curve.cases.size(); ++k) {
      const auto start = Clock::now();
      localizers[k].localize(curve.cases[k].cloud->view(), result);
      if (result.status != Status::kOk) throw std::runtime_error(std::string(to_string(result.status)));
      if (i >= 0) ms[k].push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    }
  }
  for (std::size_t k = 0; k < curve.cases.size(); ++k) curve.cases[k].ms = quantile(ms[k], 0.5);
}

/// Slope of log(ms) over log(x) by least squares: 1 is proportional.
double exponent(const Curve& curve) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Case& c : curve.cases) {
    const double x = std::log(c.x), y = std::log(c.ms);
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

void run(const std::string& path, Options options, int repeat, const std::string& csv, const std::string& plot) {
  std::string name;
  const Cloud cloud = load_scene(path, &name);
  std::vector<Cloud> clouds;
  for (const std::uint32_t step : {4u, 2u, 1u}) clouds.push_back(thinned(cloud, step));

  std::vector<Curve> curves(4);
  curves[0] = {"samples", "thousand", {}};
  for (const int samples : {1250, 2500, 5000, 10000, 20000}) {
    Options o = options;
    o.samples = samples;
    curves[0].cases.push_back({1e-3 * samples, &cloud, o});
  }
  curves[1] = {"points", "thousand", {}};
  for (const Cloud& thin : clouds) {
    const CloudView view = thin.view();
    double finite = 0;
    for (std::size_t i = 0; i < view.size(); ++i) finite += std::isfinite(view.point(i)[2]);
    curves[1].cases.push_back({1e-3 * finite, &thin, options});
  }
  curves[2] = {"one radius", "mm", {}};
  for (const double radius : {10.0, 15.0, 20.0, 30.0, 40.0, 60.0}) {
    Options o = options;
    o.radius = {1e-3 * radius};
    curves[2].cases.push_back({radius, &cloud, o});
  }
  curves[3] = {"threads", "", {}};
  const int most = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  for (int threads = 1;; threads = std::min(2 * threads, most)) {
    Options o = options;
    o.threads = threads;
    curves[3].cases.push_back({static_cast<double>(threads), &cloud, o});
    if (threads == most) break;
  }

  {
    Progress progress;
    for (Curve& curve : curves) measure(curve, repeat, progress);
  }
  std::printf("%s, method %s, %d samples, %d threads and %s where nothing else is said; medians of %d frames (%s)\n",
              name.c_str(), std::string(to_string(options.method)).c_str(), options.samples, options.threads,
              std::string(to_string(Localizer(options).backend())).c_str(), repeat, Localizer::isa());
  std::string rows = "what,unit,value,median_ms\n";
  std::vector<PlotPanel> panels;
  for (const Curve& curve : curves) {
    const std::string label = curve.what + (curve.unit.empty() ? "" : " (" + curve.unit + ")");
    std::printf("%-20s %10s %12s\n", label.c_str(), "median ms", "frames/s");
    PlotPanel panel;
    panel.title = "Time of a frame", panel.x_label = label, panel.y_label = "ms";
    panel.series = {{"median", {0.20f, 0.45f, 0.85f}, {}, {}, {}}};
    for (const Case& c : curve.cases) {
      std::printf("%20.4g %10.2f %12.1f\n", c.x, c.ms, 1e3 / c.ms);
      char row[96];
      std::snprintf(row, sizeof row, "%s,%s,%g,%.4f\n", curve.what.c_str(), curve.unit.c_str(), c.x, c.ms);
      rows += row;
      panel.series[0].x.push_back(c.x), panel.series[0].y.push_back(c.ms);
    }
    if (curve.cases.size() > 1) std::printf("  grows as the power %.2f\n", exponent(curve));
    panels.push_back(std::move(panel));
  }
  if (!csv.empty()) {
    AtomicFile file(csv);
    file.write(rows);
    file.commit();
  }
  if (!plot.empty()) write_png(plot, draw_plot(panels, 2));
}

}  // namespace
}  // namespace handhold::bench

int main(int argc, char** argv) {
  CLI::App app{"Times frames of a cloud against samples, points, radius and threads"};
  handhold::bench::FrameArguments a;
  a.frames = 30;
  return handhold::bench::main_of(app, argc, argv, "--repeat", a,
                                  [&] { handhold::bench::run(a.cloud, a.options, a.frames, a.csv, a.plot); });
}
