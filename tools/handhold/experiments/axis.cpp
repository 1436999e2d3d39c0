// The informal claim of the paper's section 3.1: the axis of the fitted quadric is more accurate and less noisy than
// the one from surface normals, and faster. Here with numbers, and with the direction of largest spread as a third.
#include "axis.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>

#include "common.h"
#include "experiments.h"
#include "handhold/random_scene.h"
#include "index.h"
#include "kernels.h"
#include "localizer_detail.h"
#include "progress.h"
#include "shots.h"
#include "statistics.h"
#include "text.h"
#include "threads.h"
#include "tiles.h"
#include "usage_error.h"

namespace handhold::experiments {
namespace {

using evaluation::format;
using Place = std::array<float, 3>;

constexpr double kDegree = 180 / 3.14159265358979323846;
constexpr AxisEstimator kEstimators[] = {AxisEstimator::kTaubin, AxisEstimator::kNormals, AxisEstimator::kPca};

struct Arguments {
  std::string noise, samples, radius, scenes;
  CommonArguments common;
};

// ---- Estimators -----------------------------------------------------------------------------------------------------

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Axes {
  std::vector<std::optional<Vector3>> axis;  ///< one for each place; none: too few points, or no quadric
  double cloud_s = 0;                        ///< what was done once for the cloud: normals
  double places_s = 0;                       ///< what was done for the places
};

/// The axes of neighbourhoods of one cloud, each way as the localizer does it. One thread.
class Estimation {
 public:
  Estimation(const CloudView& cloud, double radius) : radius_(static_cast<float>(radius)), index_(make_index({})) {
    tiles_.build(cloud);
    index_->build(tiles_);
    scratch_.require(kernels::scratch_bytes(static_cast<std::int32_t>(tiles_.blocks())));
  }

  Axes run(AxisEstimator estimator, const std::vector<Place>& places) {
    Axes axes;
    axes.axis.resize(places.size());
    auto start = std::chrono::steady_clock::now();
    if (estimator == AxisEstimator::kNormals) {
      estimate_normals(tiles_, *index_, radius_ / 2, normals_);
      axes.cloud_s = seconds_since(start);
      start = std::chrono::steady_clock::now();
    }
    if (estimator == AxisEstimator::kTaubin) {
      from_quadrics(places, axes.axis);
    } else {
      for (std::size_t i = 0; i < places.size(); ++i) {
        axes.axis[i] = estimator == AxisEstimator::kPca ? from_spread(places[i]) : from_normals(places[i]);
      }
    }
    axes.places_s = seconds_since(start);
    return axes;
  }

 private:
  static constexpr int kLeastPoints = 10;

  void find_near(const Place& place) { near_.fill(tiles_, *index_, place.data(), place.data(), radius_); }

  void sum(const Place& place, kernels::Moments& moments) {
    find_near(place);
    kernels::kernels().moments(tiles_.view(), near_.view(), {place.data(), 1, radius_, 0, kLeastPoints},
                               scratch_.data(), &moments);
  }

  static Vector3 to_cloud(const kernels::Moments& m, const Vector3& v) {
    Vector3 out{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) out[j] += m.R_frame_cloud[3 * i + j] * v[i];
    }
    return out;
  }

  void from_quadrics(const std::vector<Place>& places, std::vector<std::optional<Vector3>>& axis) {
    const kernels::Kernels& k = kernels::kernels();
    std::vector<kernels::Moments> moments(places.size());
    std::vector<std::size_t> whole;
    for (std::size_t i = 0; i < places.size(); ++i) {
      sum(places[i], moments[i]);
      if (!moments[i].skipped) whole.push_back(i);
    }
    kernels::FitBatch fit{};
    for (std::size_t first = 0; first < whole.size(); first += kernels::kBatch) {
      const std::size_t n = std::min<std::size_t>(kernels::kBatch, whole.size() - first);
      for (std::size_t lane = 0; lane < kernels::kBatch; ++lane) {
        const kernels::Moments& m = moments[whole[first + (lane < n ? lane : 0)]];
        for (std::size_t j = 0; j < kernels::kMoments; ++j) fit.moments[j][lane] = m.sum[j];
      }
      k.taubin(fit);
      k.curvature(fit);
      for (std::size_t lane = 0; lane < n; ++lane) {
        const std::size_t i = whole[first + lane];
        if (fit.status[lane] != kernels::kFitOk) continue;
        axis[i] = to_cloud(moments[i], {fit.axis[0][lane], fit.axis[1][lane], fit.axis[2][lane]});
      }
    }
  }

  std::optional<Vector3> from_spread(const Place& place) {
    kernels::Moments m;
    sum(place, m);
    if (m.skipped) return std::nullopt;
    return to_cloud(m, axis_from_spread(m));
  }

  std::optional<Vector3> from_normals(const Place& place) {
    find_near(place);
    return axis_from_normals(tiles_, near_.view(), normals_.data(), place.data(), radius_);
  }

  float radius_;
  TileStore tiles_;
  std::unique_ptr<NeighbourIndex> index_;
  CandidateList near_;
  AlignedArray<std::byte> scratch_;
  AlignedArray<float> normals_;
};

// ---- Scenes and places ----------------------------------------------------------------------------------------------

/// A scene whose truth is known, and the camera that looks at it.
struct Setup {
  std::string name;
  sensor::Scene scene;
  sensor::Pose T_world_camera;
  sensor::CameraOptions camera;
  std::vector<evaluation::LabelledPart> parts;  ///< whose axes are asked for; in the camera's frame
};

/// Free cylinders of 150 mm in front of a Kinect, of four radii, square to the line of sight and tilted.
std::vector<Setup> cylinders() {
  constexpr double kLength = 0.15, kDistance = 0.7, kRoll = 25 / kDegree;  // m, rad; off the rows of the image
  std::vector<Setup> setups;
  for (const double radius : {0.008, 0.012, 0.020, 0.030}) {
    for (const double tilt : {0.0, 25.0, 50.0}) {
      const sensor::Pose T_world_part = sensor::translation(0, 0, kDistance) * sensor::rotation({0, 0, 1}, kRoll) *
                                        sensor::rotation({1, 0, 0}, tilt / kDegree - 1.5707963267948966) *
                                        sensor::translation(0, 0, -kLength / 2);
      sensor::Part part;
      part.what = format("cylinder of %g mm, tilted by %g degrees", 1000 * radius, tilt);
      part.center = {0, 0, kLength / 2};
      part.axis = {0, 0, 1};
      part.radius = radius;
      part.length = kLength;
      part.centre_line = {{0, 0, 0}, {0, 0, kLength}};
      Setup setup;
      setup.name = part.what;
      setup.parts = {evaluation::labelled(sensor::transformed(part, T_world_part))};
      setup.scene.objects.push_back(
          {"cylinder", sensor::transformed(sensor::cylinder(radius, kLength), T_world_part), {part}});
      setup.camera = sensor::CameraOptions::kinect();
      setup.camera.seed = setups.size() + 1;
      setups.push_back(std::move(setup));
    }
  }
  return setups;
}

/// The needed parts of the paper's scenes.
std::vector<Setup> paper_parts(Progress& progress) {
  const std::vector<sensor::SceneFile> files = sensor::paper_scenes();
  std::vector<Shot> shots = shoot(files, progress);
  std::vector<Setup> setups;
  for (std::size_t i = 0; i < files.size(); ++i) {
    Setup setup;
    setup.name = files[i].name;
    setup.scene = sensor::build(files[i]);
    setup.T_world_camera = files[i].T_world_camera;
    setup.camera = files[i].camera;
    for (const evaluation::LabelledPart& part : shots[i].parts) {
      if (evaluation::needed(part, evaluation::MatchOptions())) setup.parts.push_back(part);
    }
    setups.push_back(std::move(setup));
  }
  return setups;
}

/// Everything that makes a depth wrong, times `scale`. What keeps a pixel from being measured at all stays: at every
/// scale nearly the same pixels have a depth.
sensor::NoiseOptions scaled(sensor::NoiseOptions noise, double scale) {
  noise.axial_sigma *= scale;
  noise.axial_growth *= scale;
  noise.axial_slant *= scale;
  noise.lateral_sigma *= scale;
  noise.lateral_slant *= scale;
  noise.disparity_step *= scale;
  noise.mixed = std::min(noise.mixed * scale, 1 - noise.edge_dropout);
  return noise;
}

Cloud take(const Setup& setup, double scale, std::uint64_t run) {
  sensor::CameraOptions camera = setup.camera;
  camera.noise = scaled(camera.noise, scale);
  camera.seed += 1000 * run;
  return sensor::DepthCamera(camera).capture(setup.scene, setup.T_world_camera).cloud;
}

Vector3 point(const Cloud& cloud, std::size_t pixel) {
  const float* p = &cloud.xyz[3 * pixel];
  return {p[0], p[1], p[2]};
}

/// A pixel that shows a part.
struct Probe {
  std::size_t pixel;
  std::size_t part;
};

/// Up to `most` pixels of every part, evenly over those that show it in a frame without noise.
std::vector<Probe> probes_of(const Setup& setup, const Cloud& exact, std::size_t most) {
  constexpr double kSurface = 0.002;  // m; beyond the truth's radius, for sections that are not round
  std::vector<Probe> probes;
  for (std::size_t k = 0; k < setup.parts.size(); ++k) {
    std::vector<std::size_t> pixels;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      if (!std::isfinite(exact.xyz[3 * i])) continue;
      const evaluation::Offset o = evaluation::offset(point(exact, i), {0, 0, 1}, 0, setup.parts[k]);
      if (o.along == 0 && o.across <= setup.parts[k].radius + kSurface) pixels.push_back(i);
    }
    const std::size_t count = std::min(most, pixels.size());
    for (std::size_t i = 0; i < count; ++i) probes.push_back({pixels[i * pixels.size() / count], k});
  }
  return probes;
}

// ---- Measurement ----------------------------------------------------------------------------------------------------

struct Outcome {
  std::string set;
  double noise = 0;
  AxisEstimator estimator = AxisEstimator::kTaubin;
  std::vector<double> errors;  ///< deg; of the places that have an axis
  std::size_t places = 0;
  std::size_t affordances = 0;  ///< places at which the paper's method finds a shell with this axis
  double places_s = 0, cloud_s = 0;
  std::size_t clouds = 0;

  double share(std::size_t count) const {
    return places ? static_cast<double>(count) / static_cast<double>(places) : 0;
  }
  double error(double at) const {
    std::vector<double> values = errors;
    return values.empty() ? std::nan("") : quantile(values, at);
  }
  double place_us() const { return places ? 1e6 * places_s / static_cast<double>(places) : 0; }
  double cloud_ms() const { return clouds ? 1e3 * cloud_s / static_cast<double>(clouds) : 0; }
};

/// One frame: every estimator at the same places.
void measure(const Setup& setup, const std::vector<Probe>& probes, const Cloud& exact, const Cloud& cloud,
             double radius, Outcome* outcomes) {
  constexpr double kSamePlace = 0.02;  // m; what noise moved farther is on another thing now
  std::vector<Place> places;
  std::vector<std::size_t> part;
  for (const Probe& probe : probes) {
    const Vector3 p = point(cloud, probe.pixel), q = point(exact, probe.pixel);
    if (!(std::abs(p[2] - q[2]) < kSamePlace)) continue;
    places.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    part.push_back(probe.part);
  }
  Estimation estimation(cloud.view(), radius);
  for (std::size_t e = 0; e < std::size(kEstimators); ++e) {
    Outcome& outcome = outcomes[e];
    const Axes axes = estimation.run(kEstimators[e], places);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!axes.axis[i]) continue;
      const Vector3 p = {places[i][0], places[i][1], places[i][2]};
      outcome.errors.push_back(kDegree * evaluation::offset(p, *axes.axis[i], 0, setup.parts[part[i]]).angle);
    }
    outcome.places += places.size();
    outcome.places_s += axes.places_s;
    outcome.cloud_s += axes.cloud_s;
    ++outcome.clouds;

    Options options;
    options.method = Method::kPaper;
    options.radius = {radius};
    options.axis = kEstimators[e];
    Result result;
    std::vector<Step> steps;
    localize_samples(options, cloud.view(), places, result, steps);
    outcome.affordances += result.affordances.size();
  }
}

std::vector<Outcome> measure_set(const std::string& set, const std::vector<Setup>& setups,
                                 const std::vector<double>& noise, std::size_t per_part, double radius, int runs,
                                 std::uint64_t seed, Progress& progress) {
  std::vector<Outcome> outcomes;
  for (const double scale : noise) {
    for (const AxisEstimator estimator : kEstimators) {
      Outcome outcome;
      outcome.set = set;
      outcome.noise = scale;
      outcome.estimator = estimator;
      outcomes.push_back(outcome);
    }
  }
  for (const Setup& setup : setups) {
    progress.show(set + ": " + setup.name);
    const Cloud exact = take(setup, 0, seed);
    const std::vector<Probe> probes = probes_of(setup, exact, per_part);
    for (std::size_t n = 0; n < noise.size(); ++n) {
      for (int run = 0; run < runs; ++run) {
        const Cloud cloud = take(setup, noise[n], seed + static_cast<std::uint64_t>(run));
        // On one thread: times are compared.
        tbb::task_arena(1).execute(
            [&] { measure(setup, probes, exact, cloud, radius, &outcomes[n * std::size(kEstimators)]); });
      }
    }
  }
  return outcomes;
}

// ---- Report ---------------------------------------------------------------------------------------------------------

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

PlotPanel panel_of(const std::string& set, double share, const char* what, const std::vector<Outcome>& outcomes) {
  PlotPanel panel;
  panel.title = set + ": " + what;
  panel.x_label = "sensor noise (1: as the sensor's)";
  panel.y_label = "degrees";
  constexpr Color kColors[] = {{0.00f, 0.62f, 0.45f}, {0.90f, 0.60f, 0.00f}, {0.00f, 0.45f, 0.70f}};
  for (std::size_t e = 0; e < std::size(kEstimators); ++e) {
    PlotSeries series;
    series.name = std::string(to_string(kEstimators[e]));
    series.color = kColors[e];
    for (const Outcome& o : outcomes) {
      if (o.set != set || o.estimator != kEstimators[e]) continue;
      series.x.push_back(o.noise);
      series.y.push_back(o.error(share));
    }
    panel.series.push_back(series);
  }
  return panel;
}

Report report(const std::vector<Outcome>& outcomes, const std::vector<std::string>& sets, double radius, int runs) {
  Report r;
  r.text = format("error of the axis in neighbourhoods of %g mm; runs of each scene: %d\n", 1000 * radius, runs);
  r.csv = "set,noise,axis,neighbourhoods,with_axis,median_deg,p90_deg,affordances,us_per_neighbourhood,ms_per_cloud\n";
  r.json = {{"experiment", "axis"}, {"radius", radius}, {"runs", runs}, {"results", Json::array()}};
  std::string last;
  for (const Outcome& o : outcomes) {
    const std::string name(to_string(o.estimator));
    if (o.set != last) {
      r.text += format("%-10s noise  axis     places   median      90 %%  with axis  affordance  us/place  ms/cloud\n",
                       o.set.c_str());
    }
    last = o.set;
    r.text += format("%-10s %5g  %-8s %6zu  %7.2f  %8.2f  %9.3f  %10.3f  %8.2f  %8.1f\n", "", o.noise, name.c_str(),
                     o.places, o.error(0.5), o.error(0.9), o.share(o.errors.size()), o.share(o.affordances),
                     o.place_us(), o.cloud_ms());
    r.csv += format("%s,%g,%s,%zu,%.4f,%.4f,%.4f,%.4f,%.3f,%.3f\n", o.set.c_str(), o.noise, name.c_str(), o.places,
                    o.share(o.errors.size()), o.error(0.5), o.error(0.9), o.share(o.affordances), o.place_us(),
                    o.cloud_ms());
    r.json["results"].push_back({{"set", o.set},
                                 {"noise", o.noise},
                                 {"axis", name},
                                 {"neighbourhoods", o.places},
                                 {"with_axis", o.share(o.errors.size())},
                                 {"median_deg", number(o.error(0.5))},
                                 {"p90_deg", number(o.error(0.9))},
                                 {"affordances", o.share(o.affordances)},
                                 {"us_per_neighbourhood", o.place_us()},
                                 {"ms_per_cloud", o.cloud_ms()}});
  }
  for (const std::string& set : sets) {
    r.panels.push_back(panel_of(set, 0.5, "median error of the axis", outcomes));
    r.panels.push_back(panel_of(set, 0.9, "90th percentile", outcomes));
  }
  r.columns = 2;
  return r;
}

int run(const Arguments& a) {
  const auto noise = a.noise.empty() ? std::vector<double>{0, 0.5, 1, 2} : numbers("--noise", a.noise, 0, 20, "");
  const std::size_t per_part = a.samples.empty() ? 200 : whole_number("--samples", a.samples, 1, 100'000);
  double radius = 0.025;
  if (!a.radius.empty()) {
    const std::vector<double> values = numbers("--radius", a.radius, 0.002, 0.2, "m");
    if (values.size() != 1) throw UsageError("--radius = '" + a.radius + "': must be one number (m)");
    radius = values.front();
  }
  std::vector<std::string> sets = {"cylinders", "parts"};
  if (!a.scenes.empty()) {
    if (std::find(sets.begin(), sets.end(), a.scenes) == sets.end()) {
      throw UsageError("--scenes = '" + a.scenes + "': must be cylinders or parts");
    }
    sets = {a.scenes};
  }
  const std::uint64_t seed = seed_of(a.common);
  const int runs = runs_of(a.common, 1), threads = threads_of(a.common);
  const Outputs outputs(a.common, "axis");

  std::vector<Outcome> outcomes;
  {
    Progress progress;
    with_threads(threads, [&] {
      for (const std::string& set : sets) {
        const std::vector<Setup> setups = set == "parts" ? paper_parts(progress) : cylinders();
        const std::vector<Outcome> of_set = measure_set(set, setups, noise, per_part, radius, runs, seed, progress);
        outcomes.insert(outcomes.end(), of_set.begin(), of_set.end());
      }
    });
  }
  outputs.write(report(outcomes, sets, radius, runs));
  return 0;
}

}  // namespace

Subcommand add_axis(CLI::App& parent) {
  CLI::App* app =
      parent.add_subcommand("axis", "Axis of the quadric, from normals and from spread, by noise (section 3.1)");
  app->allow_extras();
  auto a = std::make_shared<Arguments>();
  const char* what = "What is measured";
  add_text_flag(*app, "--noise", a->noise, "LIST", "Sensor noise, times that of the sensor [0,0.5,1,2]", what);
  add_text_flag(*app, "--scenes", a->scenes, "NAME", "cylinders (free ones) or parts (of the paper's scenes) [both]",
                what);
  add_text_flag(*app, "--samples", a->samples, "N", "Neighbourhoods of each part, at most [200]", what);
  add_text_flag(*app, "--radius", a->radius, "M", "Of the neighbourhoods (m) [0.025]", what);
  add_common_flags(*app, a->common, "Frames of each scene, each with its own noise [1]");
  return {app, [a] { return run(*a); }};
}

}  // namespace handhold::experiments
