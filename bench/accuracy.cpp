// How accurate the fit is on a real cloud: handhold_accuracy CLOUD... [--samples N] [--radius M]
//
// Three questions, each over neighbourhoods whose axis is well defined (second eigenvalue at least 1.05 times the
// first, and the smaller curvature at most half the larger):
//   vector  from the same double-precision moments, the kernel's ten coefficients against a solution in long double
//   solve   from the same double-precision moments, the kernel's axis against a solution in long double
//   points  from the points, the float sums' axis against that of double sums
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "handhold/localizer.h"
#include "index.h"
#include "kernels.h"
#include "reference/reference.h"
#include "scene.h"
#include "tiles.h"

namespace {

using handhold::CandidateList;
using handhold::TileStore;
namespace kernels = handhold::kernels;
namespace reference = handhold::reference;

double degrees_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 57.29577951308232;
}

struct Errors {
  std::vector<double> values;
  void print(const char* what, std::size_t of) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return values.empty() ? 0.0
                            : values[std::min(values.size() - 1,
                                              static_cast<std::size_t>(share * static_cast<double>(values.size())))];
    };
    std::printf("  %-7s %7zu of %zu (%.1f %%)   median %.1e   p99 %.1e   p99.9 %.1e   worst %.1e degrees\n", what,
                values.size(), of,
                100.0 * static_cast<double>(values.size()) / static_cast<double>(std::max<std::size_t>(of, 1)), at(0.5),
                at(0.99), at(0.999), at(1));
  }
};

Eigen::Vector3d lane_axis(const kernels::FitBatch& batch, std::size_t lane) {
  return {batch.axis[0][lane], batch.axis[1][lane], batch.axis[2][lane]};
}

void measure(const std::string& path, int samples, float radius) {
  std::string name;
  const handhold::Cloud cloud = handhold::bench::load_scene(path, &name);
  const auto centres = handhold::bench::draw_samples(cloud.view(), samples);
  TileStore tiles;
  tiles.build(cloud.view());
  const auto index = handhold::make_embree_index();
  index->build(tiles);
  const kernels::Kernels& k = kernels::kernels();
  std::vector<float> scratch_memory(kernels::scratch_bytes(static_cast<std::int32_t>(tiles.blocks())) / sizeof(float) +
                                    32);
  void* scratch = scratch_memory.data();
  std::size_t space = scratch_memory.size() * sizeof(float);
  scratch = std::align(64, space - 64, scratch, space);
  std::vector<float> x(static_cast<std::size_t>(tiles.blocks()) * 256 + 16), y(x.size()), z(x.size());

  Errors solve, points, coefficients;
  std::size_t fitted = 0;
  CandidateList near;
  auto from_double = std::make_unique<kernels::FitBatch>(), from_float = std::make_unique<kernels::FitBatch>();
  for (const auto& c : centres) {
    near.fill(tiles, *index, c.data(), c.data(), radius);
    kernels::Moments m;
    k.moments(tiles.view(), near.view(), {c.data(), 1, radius, 0.0f, 10}, scratch, &m);
    if (m.skipped) continue;
    // The same points in double, in the frame of the moments.
    const int n = k.collect(tiles.view(), near.view(), c.data(), radius, scratch, x.data(), y.data(), z.data());
    const Eigen::Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R_frame_cloud);
    reference::MomentSums<double> sums = reference::MomentSums<double>::Zero();
    const auto& monomials = reference::monomials();
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Eigen::Vector3d p = R * Eigen::Vector3d(x[at], y[at], z[at]) / static_cast<double>(radius);
      double power[3][5];
      for (int a = 0; a < 3; ++a) {
        power[a][0] = 1;
        for (int e = 1; e < 5; ++e) power[a][e] = power[a][e - 1] * p[a];
      }
      for (int j = 0; j < kernels::kMoments; ++j) {
        const auto& e = monomials[static_cast<std::size_t>(j)];
        sums[j] += power[0][e[0]] * power[1][e[1]] * power[2][e[2]];
      }
    }
    const reference::MomentSums<long double> exact = sums.cast<long double>();
    const auto truth = reference::fit_quadric(exact);
    if (truth.flat) continue;
    ++fitted;
    const auto at_foot = reference::principal_curvatures(
        truth.coefficients,
        reference::foot(truth.coefficients, reference::Vector3<long double>(reference::Vector3<long double>::Zero())));
    if (!(truth.next_lambda >= 1.05L * truth.lambda) || !(std::abs(at_foot.minor) <= std::abs(at_foot.major) / 2) ||
        !(std::abs(at_foot.major) >= 1e-3L))
      continue;
    for (std::size_t lane = 0; lane < kernels::kBatch; ++lane) {
      for (int j = 0; j < kernels::kMoments; ++j) {
        from_double->moments[j][lane] = sums[j];
        from_float->moments[j][lane] = m.sum[j];
      }
    }
    for (kernels::FitBatch* batch : {from_double.get(), from_float.get()}) k.taubin(*batch), k.curvature(*batch);
    Eigen::Matrix<double, 10, 1> ours;
    for (int j = 0; j < 10; ++j) ours[j] = from_double->coefficients[j][0];
    const Eigen::Matrix<double, 10, 1> true_c = truth.coefficients.cast<double>();
    const Eigen::Matrix<double, 10, 1> across =
        ours.normalized() - ours.normalized().dot(true_c.normalized()) * true_c.normalized();
    coefficients.values.push_back(std::asin(std::min(1.0, across.norm())) * 57.29577951308232);
    const Eigen::Vector3d axis = at_foot.minor_direction.cast<double>();
    if (degrees_between(lane_axis(*from_double, 0), axis) > 1e-4) {
      std::printf(
          "  outlier: lambda ratio %.4f, coefficients off by %.1e degrees, gradient at the sample %.1e, at its foot "
          "%.1e\n",
          static_cast<double>(truth.next_lambda / truth.lambda), coefficients.values.back(),
          static_cast<double>(truth.coefficients.segment<3>(6).norm()),
          static_cast<double>(
              reference::quadric_gradient(
                  truth.coefficients, reference::foot(truth.coefficients, reference::Vector3<long double>(
                                                                              reference::Vector3<long double>::Zero())))
                  .norm()));
    }
    solve.values.push_back(degrees_between(lane_axis(*from_double, 0), axis));
    points.values.push_back(degrees_between(lane_axis(*from_float, 0), axis));
  }
  std::printf("%s (%s)\n", name.c_str(), k.name);
  coefficients.print("vector", fitted);
  solve.print("solve", fitted);
  points.print("points", fitted);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Accuracy of the quadric's axis on real neighbourhoods"};
  std::vector<std::string> clouds;
  int samples = 20000;
  double radius = 0.025;
  app.add_option("clouds", clouds, "PCD or PLY files")->required();
  app.add_option("--samples", samples, "neighbourhoods to look at")->check(CLI::Range(1, 10000000));
  app.add_option("--radius", radius, "radius of the neighbourhoods (m)")->check(CLI::Range(1e-6, 1.0));
  CLI11_PARSE(app, argc, argv);
  try {
    for (const std::string& path : clouds) measure(path, samples, static_cast<float>(radius));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handhold_accuracy: %s\n", error.what());
    return 1;
  }
  return 0;
}
