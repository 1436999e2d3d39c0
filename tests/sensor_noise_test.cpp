// What the sensor does to depth within a surface, against the formulas: statistics with confidence bounds.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "handhold/sensor.h"
#include "sensor_test_helpers.h"

namespace handhold::sensor {
namespace {

constexpr double kPi = 3.141592653589793;

/// A view so narrow that a slanted board has one angle of incidence over the whole image, to 0.01 rad.
CameraOptions narrow_camera() {
  CameraOptions options = small_camera();
  options.fx = options.fy = 20000;
  return options;
}

/// A board through the optical axis at depth z, turned about the image's y.
Scene slanted_board(double z, double incidence, const Material& material = {}) {
  Scene scene;
  scene.add({"board", box(2, 2, 0.001), {}, material}, translation(0, 0, z) * rotation({0, 1, 0}, incidence));
  return scene;
}

double lost_share(const Frame& frame) {
  return 1 - static_cast<double>(measured_points(frame.cloud)) / static_cast<double>(frame.cloud.size());
}

TEST(Noise, MeanAndSpreadAreThoseOfTheModel) {
  for (const double z : {0.35, 0.8, 1.6, 3.0}) {
    CameraOptions options = table_scene_camera_options();
    options.noise.disparity_step = 0;
    const Frame frame = DepthCamera(options).capture(wall(z), Pose{});
    const double sigma = 0.0008 + 0.0019 * std::pow(std::max(0.0, z - 0.4), 2);
    double sum = 0, sum2 = 0, beyond = 0;
    const auto n = static_cast<double>(frame.cloud.size());
    ASSERT_EQ(measured_points(frame.cloud), frame.cloud.size());
    for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
      const double e = frame.cloud.xyz[3 * i + 2] - z;
      sum += e;
      sum2 += e * e;
      beyond += std::abs(e) > 1.959964 * sigma;
    }
    // Five standard errors of each estimate.
    EXPECT_NEAR(sum / n, 0, 5 * sigma / std::sqrt(n)) << "z = " << z;
    EXPECT_NEAR(std::sqrt(sum2 / n), sigma, 5 * sigma / std::sqrt(2 * n)) << "z = " << z;
    EXPECT_NEAR(beyond / n, 0.05, 5 * std::sqrt(0.05 * 0.95 / n)) << "z = " << z;
  }
}

TEST(Noise, PixelsDoNotDependOnEachOther) {
  CameraOptions options = table_scene_camera_options();
  options.noise.disparity_step = 0;
  const Frame frame = DepthCamera(options).capture(wall(1), Pose{});
  double right = 0, down = 0, variance = 0;
  for (std::size_t v = 0; v + 1 < 480; ++v) {
    for (std::size_t u = 0; u + 1 < 640; ++u) {
      const std::size_t i = v * 640 + u;
      const double e = frame.cloud.xyz[3 * i + 2] - 1;
      variance += e * e;
      right += e * (frame.cloud.xyz[3 * (i + 1) + 2] - 1);
      down += e * (frame.cloud.xyz[3 * (i + 640) + 2] - 1);
    }
  }
  const double bound = 5 / std::sqrt(639.0 * 479.0);
  EXPECT_LT(std::abs(right / variance), bound);
  EXPECT_LT(std::abs(down / variance), bound);
}

TEST(Noise, QuantizedDepthIsAWholeNumberOfDisparitySteps) {
  NoiseOptions noise;
  noise.disparity_step = 0.125;
  for (double z = 0.4; z < 4; z += 0.0137) {
    const double steps = 575 * 0.075 / (noise.quantized(z) * 0.125);
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
    // Half a step of disparity in depth: z^2 / (f b) * step / 2, and a little for the curvature of 1/d.
    EXPECT_LE(std::abs(noise.quantized(z) - z), 1.05 * z * z / (575 * 0.075) * 0.0625);
  }
  CameraOptions options = small_camera();
  options.noise = noise;
  // Slanted, so that many steps are met.
  Scene scene;
  scene.add({"wall", box(4, 4, 0.1), {}}, translation(0, 0, 1.2) * rotation({0, 1, 0}, 0.6));
  const Frame frame = DepthCamera(options).capture(scene, Pose{});
  std::map<long, int> levels;
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
    if (!measured(frame.cloud, i)) continue;
    const double steps = 575 * 0.075 / (frame.cloud.xyz[3 * i + 2] * 0.125);
    ASSERT_NEAR(steps, std::round(steps), 1e-3);
    ++levels[std::lround(steps)];
  }
  EXPECT_GT(levels.size(), 50u);
}

TEST(Noise, DropOutsFollowTheAngleOfIncidence) {
  CameraOptions options = small_camera();
  options.noise.dropout_from = 0.6;
  options.noise.dropout_to = 1.4;
  EXPECT_EQ(options.noise.dropout(0.59), 0);
  EXPECT_NEAR(options.noise.dropout(1.0), 0.5, 1e-12);
  EXPECT_EQ(options.noise.dropout(1.41), 1);
  // A narrow view of a slanted board: one angle of incidence over the whole image, to 0.01 rad.
  options.fx = options.fy = 20000;
  for (const double incidence : {0.5, 0.8, 1.0, 1.2, 1.45}) {
    Scene scene;
    scene.add({"board", box(2, 2, 0.001), {}}, translation(0, 0, 1) * rotation({0, 1, 0}, incidence));
    const Frame frame = DepthCamera(options).capture(scene, Pose{});
    const auto n = static_cast<double>(frame.cloud.size());
    const double expected = std::min(1.0, std::max(0.0, (incidence - 0.6) / 0.8));
    const double error = 5 * std::sqrt(expected * (1 - expected) / n) + (expected > 0 && expected < 1 ? 0.005 : 0);
    EXPECT_NEAR(1 - static_cast<double>(measured_points(frame.cloud)) / n, expected, error + 1e-12)
        << "incidence " << incidence;
  }
}

TEST(Noise, DefaultChangesNothing) {
  const NoiseOptions noise;
  for (const double z : {0.3, 1.0, 4.9}) {
    EXPECT_EQ(noise.sigma(z), 0);
    EXPECT_EQ(noise.quantized(z), z);
  }
  for (const double incidence : {0.0, 1.0, 1.57}) {
    EXPECT_EQ(noise.sigma(1, incidence), 0);
    EXPECT_EQ(noise.lateral(incidence), 0);
    EXPECT_EQ(noise.dropout(incidence), 0);
    EXPECT_EQ(noise.glare(1, incidence), 0);
    EXPECT_EQ(noise.darkness(incidence), 0);
  }
}

TEST(Noise, GrowsWithIncidenceAsPublished) {
  CameraOptions options = narrow_camera();
  options.noise.axial_sigma = 0.0012;
  options.noise.axial_growth = 0.0019;
  options.noise.axial_slant = 0.0001;
  for (const double z : {0.6, 1.5}) {
    for (const double theta : {0.0, 0.5, 1.0, 1.3, 1.45}) {
      const Scene scene = slanted_board(z, theta);
      const Cloud exact = DepthCamera(narrow_camera()).capture(scene, Pose{}).cloud;
      const Cloud noisy = DepthCamera(options).capture(scene, Pose{}).cloud;
      double sum2 = 0;
      const auto n = static_cast<double>(exact.size());
      for (std::size_t i = 0; i < exact.size(); ++i) {
        const double e = noisy.xyz[3 * i + 2] - exact.xyz[3 * i + 2];
        sum2 += e * e;
      }
      const double slant = theta / (kPi / 2 - theta);
      const double sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4) + 0.0001 / std::sqrt(z) * slant * slant;
      // Five standard errors, and what the angle changes over the image.
      EXPECT_NEAR(std::sqrt(sum2 / n), sigma, 5 * sigma / std::sqrt(2 * n) + 0.003 * sigma * theta)
          << z << " " << theta;
      EXPECT_NEAR(options.noise.sigma(z, theta), sigma, 1e-12);
    }
  }
  EXPECT_EQ(options.noise.sigma(1, kPi / 2), options.noise.sigma(1, 1.5)) << "finite at grazing incidence";
}

TEST(Noise, CorrelatesOverTheGivenLengthAndKeepsItsSpread) {
  CameraOptions options;
  options.noise.axial_sigma = 0.002;
  options.noise.correlation_u = 4;
  options.noise.correlation_v = 2;
  double variance = 0, border = 0;
  std::vector<double> along_u(8), along_v(8);
  std::size_t n = 0;
  for (options.seed = 1; options.seed <= 4; ++options.seed) {
    const Frame frame = DepthCamera(options).capture(wall(1), Pose{});
    const auto error = [&](std::size_t u, std::size_t v) { return frame.cloud.xyz[3 * (v * 640 + u) + 2] - 1.0; };
    for (std::size_t v = 0; v < 480; ++v) {
      border += (error(0, v) * error(0, v) + error(639, v) * error(639, v)) / (2 * 4 * 480);
    }
    for (std::size_t v = 0; v + 8 < 480; ++v) {
      for (std::size_t u = 0; u + 8 < 640; ++u) {
        variance += error(u, v) * error(u, v);
        for (std::size_t d = 1; d < 8; ++d) {
          along_u[d] += error(u, v) * error(u + d, v);
          along_v[d] += error(u, v) * error(u, v + d);
        }
        ++n;
      }
    }
  }
  // So many pixels stand for one independent one: the sum of the squared correlations.
  const double independent = static_cast<double>(n) / (kPi / 2 * 4 * 2);
  const double spread = std::sqrt(variance / static_cast<double>(n));
  EXPECT_NEAR(spread, 0.002, 0.002 * 5 / std::sqrt(2 * independent));
  EXPECT_NEAR(std::sqrt(border), 0.002, 0.002 * 5 / std::sqrt(2 * 2 * 4 * 480 / (std::sqrt(kPi / 2) * 2)));
  for (int d = 1; d < 8; ++d) {
    EXPECT_NEAR(along_u[d] / variance, std::exp(-d * d / 16.0), 5 / std::sqrt(independent)) << "columns " << d;
    EXPECT_NEAR(along_v[d] / variance, std::exp(-d * d / 4.0), 5 / std::sqrt(independent)) << "rows " << d;
  }
}

TEST(Noise, CorrelatedDropOutsComeInPatchesButNotMoreOften) {
  CameraOptions options = narrow_camera();
  options.noise.dropout_from = 0.6;
  options.noise.dropout_to = 1.4;
  options.noise.correlation_u = options.noise.correlation_v = 3;
  double lost = 0, pairs = 0, pixels = 0;
  for (options.seed = 1; options.seed <= 8; ++options.seed) {
    const Frame frame = DepthCamera(options).capture(slanted_board(1, 0.76), Pose{});
    for (std::size_t i = 0; i + 1 < frame.cloud.size(); ++i) {
      lost += !measured(frame.cloud, i);
      pairs += !measured(frame.cloud, i) && !measured(frame.cloud, i + 1);
      ++pixels;
    }
  }
  const double independent = pixels / (kPi / 2 * 9);
  EXPECT_NEAR(lost / pixels, 0.2, 5 * std::sqrt(0.2 * 0.8 / independent) + 0.005);
  EXPECT_GT(pairs / lost, 0.6) << "a lost pixel's neighbour would be lost in a fifth of the cases if by itself";
}

TEST(Noise, GlareTakesTheMirrorImageOfTheProjector) {
  CameraOptions options = small_camera();
  options.noise.glare_width = 0.1;
  Scene scene = wall(1);
  EXPECT_EQ(lost_share(DepthCamera(options).capture(scene, Pose{})), 0) << "a surface without shine";
  scene.objects[0].material.specular = 0.7;
  const DepthCamera camera(options);
  std::vector<double> lost(6), expected(6), variance(6);
  double sum_x = 0, all = 0;
  for (int shot = 0; shot < 20; ++shot) {
    CameraOptions seeded = options;
    seeded.seed = 100 + shot;
    const Frame frame = DepthCamera(seeded).capture(scene, Pose{});
    for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
      const Vector3 p = camera.ray(static_cast<double>(i % 160), static_cast<double>(i / 160));  // the wall is at z = 1
      const Eigen::Vector3d to_camera = -eigen(p), to_projector = Eigen::Vector3d(0.075, 0, 0) - eigen(p);
      const double angle = std::acos(-(to_camera.normalized() + to_projector.normalized()).normalized().z());
      const auto bin = static_cast<std::size_t>(std::min(5.0, angle / 0.04));
      const double probability = 0.7 * std::exp(-std::pow(angle / 0.1, 2));
      expected[bin] += probability;
      variance[bin] += probability * (1 - probability);
      if (measured(frame.cloud, i)) continue;
      ++lost[bin];
      ++all;
      sum_x += p[0];
    }
  }
  for (std::size_t bin = 0; bin < 6; ++bin) {
    EXPECT_NEAR(lost[bin], expected[bin], 5 * std::sqrt(variance[bin])) << "bin " << bin;
  }
  EXPECT_NEAR(sum_x / all, 0.0375, 0.002) << "half way to the projector";
}

TEST(Noise, DarkAndDistantSurfacesAreLost) {
  CameraOptions options = narrow_camera();
  options.noise.signal_full = 0.10;
  options.noise.signal_none = 0.02;
  struct Case {
    double z, incidence;
    Material material;
  };
  for (const Case& c : {Case{1, 0, {0.06, 0}}, Case{1, 0, {0.12, 0}}, Case{1, 0, {0.01, 0}}, Case{2, 0, {0.24, 0}},
                        Case{1, 1.0, {0.12, 0}}, Case{1, 0, {0.2, 0.7}}}) {
    const Frame frame = DepthCamera(options).capture(slanted_board(c.z, c.incidence, c.material), Pose{});
    const double signal = c.material.reflectance * (1 - c.material.specular) * std::cos(c.incidence) / (c.z * c.z);
    const double expected = std::min(1.0, std::max(0.0, (0.10 - signal) / 0.08));
    const bool certain = expected == 0 || expected == 1;
    const double error = 5 * std::sqrt(expected * (1 - expected) / static_cast<double>(frame.cloud.size()));
    EXPECT_NEAR(lost_share(frame), expected, certain ? 1e-12 : error + 0.01) << c.z << " " << c.material.reflectance;
  }
}

// ---- Switches and seeds ---------------------------------------------------------------------------------------------

/// Something of everything: edges, shadows, steep, shiny and dark places.
Scene varied_scene() {
  Scene scene = table_scene();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    scene.objects[i].material = {i % 2 ? 0.03 : 0.6, i % 3 ? 0.0 : 0.8};
  }
  return scene;
}

TEST(Noise, WhatIsOffChangesNothing) {
  const Cloud bare = DepthCamera(small_camera()).capture(varied_scene(), table_scene_camera()).cloud;
  // Everything that says how, nothing that says that.
  CameraOptions options = small_camera();
  options.seed = 99;
  options.noise.axial_from = 0.1;
  options.noise.correlation_u = 5;
  options.noise.disparity_focal = 300;
  options.noise.baseline = 0.2;
  options.noise.edge_step = 0.001;
  EXPECT_TRUE(same_bytes(bare, DepthCamera(options).capture(varied_scene(), table_scene_camera()).cloud));
}

TEST(Noise, EachEffectWorksAlone) {
  const std::vector<std::pair<const char*, std::function<void(NoiseOptions&)>>> effects = {
      {"axial", [](NoiseOptions& n) { n.axial_sigma = 0.001; }},
      {"axial growth", [](NoiseOptions& n) { n.axial_growth = 0.002; }},
      {"axial slant", [](NoiseOptions& n) { n.axial_slant = 0.0001; }},
      {"lateral", [](NoiseOptions& n) { n.lateral_sigma = 0.8; }},
      {"lateral slant", [](NoiseOptions& n) { n.lateral_slant = 0.5; }},
      {"quantization", [](NoiseOptions& n) { n.disparity_step = 0.125; }},
      {"shadows", [](NoiseOptions& n) { n.shadows = true; }},
      {"grazing", [](NoiseOptions& n) { n.dropout_from = 1; }},
      {"glare", [](NoiseOptions& n) { n.glare_width = 0.2; }},
      {"darkness", [](NoiseOptions& n) { n.signal_full = 0.1; }},
      {"edge drop-outs", [](NoiseOptions& n) { n.edge_dropout = 0.2; }},
      {"mixed pixels", [](NoiseOptions& n) { n.mixed = 0.2; }},
  };
  const Cloud bare = DepthCamera(small_camera()).capture(varied_scene(), table_scene_camera()).cloud;
  for (const auto& [name, turn_on] : effects) {
    CameraOptions options = small_camera();
    turn_on(options.noise);
    EXPECT_FALSE(same_bytes(bare, DepthCamera(options).capture(varied_scene(), table_scene_camera()).cloud)) << name;
  }
}

TEST(Noise, TheSeedDecidesTheBytesAndThreadsDoNot) {
  for (const CameraOptions& preset : {CameraOptions::kinect(), CameraOptions::xtion(), table_scene_camera_options()}) {
    CameraOptions options = preset;
    const auto shot = [&](std::uint64_t seed) {
      options.seed = seed;
      return DepthCamera(options).capture(varied_scene(), table_scene_camera()).cloud;
    };
    const Cloud first = shot(7);
    EXPECT_TRUE(same_bytes(first, shot(7)));
    EXPECT_FALSE(same_bytes(first, shot(8)));
    EXPECT_FALSE(same_bytes(first, shot(7 + (1ull << 32)))) << "the seed's upper half counts";
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_TRUE(same_bytes(first, shot(7)));
  }
}

}  // namespace
}  // namespace handhold::sensor
