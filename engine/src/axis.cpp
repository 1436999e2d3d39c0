#include "axis.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

namespace handhold {
namespace {

Eigen::Vector3d eigenvector(const Eigen::Matrix3d& m, int which) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>().compute(m).eigenvectors().col(which);
}

}  // namespace

Vector3 axis_from_spread(const kernels::Moments& moments) {
  const double* m = moments.sum;
  const Eigen::Vector3d mean = Eigen::Vector3d(m[1], m[2], m[3]) / m[0];
  Eigen::Matrix3d c;
  c << m[4], m[5], m[6], m[5], m[7], m[8], m[6], m[8], m[9];
  const Eigen::Vector3d v = eigenvector(c / m[0] - mean * mean.transpose(), 2);
  return {v[0], v[1], v[2]};
}

void estimate_normals(const TileStore& tiles, const NeighbourIndex& index, float radius, AlignedArray<float>& normals) {
  struct Scratch {
    CandidateList near;
    AlignedArray<float> x, y, z;
  };
  normals.require(static_cast<std::size_t>(tiles.blocks()) * 768);
  const kernels::Tiles view = tiles.view();
  tbb::enumerable_thread_specific<Scratch> scratch;
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, tiles.blocks(), 4), [&](const auto& range) {
    Scratch& s = scratch.local();
    for (std::uint32_t b = range.begin(); b < range.end(); ++b) {
      if (tiles.block_empty(b)) continue;
      s.near.fill(tiles, index, tiles.block_box(b), tiles.block_box(b) + 4, radius);
      const std::size_t capacity = static_cast<std::size_t>(s.near.view().padded) * 256 + 16;
      s.x.require(capacity), s.y.require(capacity), s.z.require(capacity);
      for (std::size_t at = 0; at < 256; ++at) {
        const std::size_t i = static_cast<std::size_t>(b) * 768 + at / 16 * 48 + at % 16;
        const float p[3] = {view.points[i], view.points[i + 16], view.points[i + 32]};
        Eigen::Vector3d n = Eigen::Vector3d::Zero();
        if (p[0] < kernels::kFar) {
          const int count =
              kernels::kernels().collect(view, s.near.view(), p, radius, nullptr, s.x.data(), s.y.data(), s.z.data());
          Eigen::Vector3d mean = Eigen::Vector3d::Zero();
          Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
          for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
            const Eigen::Vector3d d(s.x[k], s.y[k], s.z[k]);
            mean += d;
            c += d * d.transpose();
          }
          if (count >= 3) n = eigenvector(c - mean * mean.transpose() / count, 0);
        }
        for (std::size_t k = 0; k < 3; ++k) normals[i + 16 * k] = static_cast<float>(n[static_cast<Eigen::Index>(k)]);
      }
    }
  });
}

Vector3 axis_from_normals(const TileStore& tiles, const kernels::Candidates& near, const float* normals,
                          const float* centre, float radius) {
  const kernels::Tiles view = tiles.view();
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::int32_t c = 0; c < near.padded; ++c) {
    if (near.boxes[0][c] >= kernels::kFar) continue;
    for (std::size_t at = 0; at < 256; ++at) {
      const std::size_t i = static_cast<std::size_t>(near.block[c]) * 768 + at / 16 * 48 + at % 16;
      double d2 = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double d = static_cast<double>(view.points[i + 16 * k]) - static_cast<double>(centre[k]);
        d2 += d * d;
      }
      if (!(d2 <= static_cast<double>(radius) * static_cast<double>(radius))) continue;
      const Eigen::Vector3d n(normals[i], normals[i + 16], normals[i + 32]);
      sum += n * n.transpose();
    }
  }
  const Eigen::Vector3d v = eigenvector(sum, 0);
  return {v[0], v[1], v[2]};
}

}  // namespace handhold
