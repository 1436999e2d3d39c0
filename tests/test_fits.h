// Fit problems for the kernels that work on a batch of neighbourhoods, one per lane.
#pragma once

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "kernels.h"
#include "reference/reference.h"
#include "test_clouds.h"

namespace handhold::test {

/// A neighbourhood in its scaled frame, and its exact moments.
struct FitProblem {
  std::string name;
  reference::Points points;
  reference::MomentSums<double> sums;
};

inline FitProblem fit_problem(const std::string& name, const reference::Points& scaled) {
  return {name, scaled, reference::moment_sums<double>(scaled)};
}

/// Neighbourhoods of random points of the ordinary clouds: `per_cloud` of each, with at least 30 points.
inline std::vector<FitProblem> ordinary_problems(std::uint64_t seed, int per_cloud, double radius = 0.025) {
  Random random(seed);
  std::vector<FitProblem> problems;
  for (const NamedCloud& cloud : ordinary_clouds(seed, 3000)) {
    const std::vector<Vector3d> points = to_double(cloud.points);
    for (int i = 0, tries = 0; i < per_cloud && tries < 100 * per_cloud; ++tries) {
      const Vector3d sample = points[random.index(points.size())];
      if (!reference::is_measured(sample)) continue;
      const FitProblem problem = fit_problem(cloud.name, reference::scaled_neighbourhood(points, sample, radius));
      if (problem.points.size() < 30) continue;
      problems.push_back(problem);
      ++i;
    }
  }
  return problems;
}

/// Neighbourhoods that are no quadric, of one point at least: the fits do not take an empty one. Made in double, so
/// that a tilted plane is as flat as a double can say.
inline std::vector<FitProblem> flat_problems(std::uint64_t seed) {
  Random random(seed);
  const Matrix3d R = random.rotation();
  const Vector3d t(0.1, -0.05, 0.2);
  reference::Points plane, tilted_plane, line, tilted_line, place, two_places;
  for (int i = 0; i < 200; ++i) {
    const Vector3d p(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 0);
    plane.push_back(p);
    tilted_plane.push_back(R * p + t);
    line.push_back({p.x(), 0, 0});
    tilted_line.push_back(R * line.back() + t);
    place.push_back(t);
    two_places.push_back(i % 3 == 0 ? t : Vector3d(0, 0, 0));
  }
  return {fit_problem("plane", plane),
          fit_problem("tilted plane", tilted_plane),
          fit_problem("line", line),
          fit_problem("tilted line", tilted_line),
          fit_problem("one place off the centre", place),
          fit_problem("one place at the centre", reference::Points(50, Vector3d::Zero())),
          fit_problem("two places", two_places),
          fit_problem("one point", {t})};
}

/// A batch with the problems [first, first + kBatch) in its lanes; lanes that are left over repeat the last one.
inline kernels::FitBatch batch_of(const std::vector<FitProblem>& problems, std::size_t first = 0) {
  kernels::FitBatch batch;
  std::memset(&batch, 0, sizeof(batch));  // so that batches can be compared as bytes
  for (int lane = 0; lane < kernels::kBatch; ++lane) {
    const FitProblem& problem = problems[std::min(first + lane, problems.size() - 1)];
    for (int n = 0; n < kernels::kMoments; ++n) batch.moments[n][lane] = problem.sums[n];
  }
  return batch;
}

/// Calls visit(problem, batch, lane) for every problem, each in its lane of a batch that `prepare(batch)` was called
/// on.
template <class Prepare, class Visit>
void for_each_fit(const std::vector<FitProblem>& problems, Prepare&& prepare, Visit&& visit) {
  for (std::size_t first = 0; first < problems.size(); first += kernels::kBatch) {
    kernels::FitBatch batch = batch_of(problems, first);
    prepare(batch);
    for (std::size_t i = first; i < std::min(problems.size(), first + kernels::kBatch); ++i)
      visit(problems[i], batch, static_cast<int>(i - first));
  }
}

inline reference::QuadricVector<double> coefficients(const kernels::FitBatch& batch, int lane) {
  reference::QuadricVector<double> c;
  for (int a = 0; a < 10; ++a) c[a] = batch.coefficients[a][lane];
  return c;
}
inline void set_coefficients(kernels::FitBatch& batch, int lane, const reference::QuadricVector<double>& c) {
  for (int a = 0; a < 10; ++a) batch.coefficients[a][lane] = c[a];
}
inline Vector3d vector(const double (&v)[3][kernels::kBatch], int lane) {
  return {v[0][lane], v[1][lane], v[2][lane]};
}
inline void set_vector(double (&v)[3][kernels::kBatch], int lane, const Vector3d& value) {
  for (int a = 0; a < 3; ++a) v[a][lane] = value[a];
}

/// Angle between two directions whose sign means nothing (rad).
inline double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

}  // namespace handhold::test
