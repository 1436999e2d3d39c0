// The stages of the baseline, one function each.
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "baseline/baseline.h"

namespace handhold::baseline {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;
using Vector10 = Eigen::Matrix<double, 10, 1>;

/// Radius search by PCL.
class RadiusSearch {
 public:
  /// @throws std::invalid_argument as `localize`
  RadiusSearch(const PclCloud::Ptr& cloud, Search kind);
  ~RadiusSearch();

  /// Indices of the finite points within `radius` of `center` (m), in no particular order, valid until the next call.
  const std::vector<int>& find(const Eigen::Vector3f& center, double radius);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

PclCloud::Ptr to_pcl(const CloudView& cloud);

/// A quadric f = c . (x^2, y^2, z^2, xy, yz, xz, x, y, z, 1) in coordinates y = (p - sample) / radius, with what the
/// fit's sums tell about the points.
struct Quadric {
  bool flat = false;           ///< points on a plane, a line or in one place; nothing else is valid then
  Vector10 c;                  ///< c^T N c = 1
  Eigen::Vector3d mean;        ///< of y
  Eigen::Matrix3d covariance;  ///< of y
};
/// Taubin's fit (paper, eq. 1 and 2): smallest eigenvalue of M c = lambda N c.
Quadric fit_quadric(const PclCloud& cloud, const std::vector<int>& neighbours, const Eigen::Vector3f& sample,
                    double radius);

/// At the sample's foot on the surface, and over the neighbourhood. Curvature in 1 / radius of the ball.
struct Curvature {
  Eigen::Vector3d axis;    ///< unit; tangent direction of least absolute curvature
  Eigen::Vector3d normal;  ///< unit; sign as the gradient
  double median = 0;       ///< of the larger absolute curvature
};
/// Dense 3x3 eigenproblems (paper, section 3.1); the quadric must not be flat.
Curvature estimate_curvature(const Quadric& quadric, const PclCloud& cloud, const std::vector<int>& neighbours,
                             const Eigen::Vector3f& sample, double radius, CurvaturePoints points);

struct Circle {
  Eigen::Vector3d center;  ///< m; point of the circle's axis in the plane through the sample
  double radius = 0;       ///< m; infinity when the points lie on a line across the axis
};
/// Algebraic circle through the points seen along `axis` (paper, section 3.2, eq. 3).
Circle fit_circle(const PclCloud& cloud, const std::vector<int>& neighbours, const Eigen::Vector3f& sample,
                  const Eigen::Vector3d& axis);

/// Limits of the shell search.
struct ShellLimits {
  double half_width;    ///< m; along the axis
  double start_radius;  ///< m
  double max_radius;    ///< m
  double gap;           ///< m
  int max_gap_points;
  int min_inner_points;
  double step = 0.001;  ///< m; from one radius to the next
};
struct Shell {
  Outcome outcome = Outcome::kNoGap;  ///< kNoGap, kShellEmpty or kAffordance
  double radius = 0;                  ///< m
};
/// Steps the radius and counts points again for each one (paper, section 3.2: 1 mm). `rho2` is scratch.
Shell find_shell(const PclCloud& cloud, RadiusSearch& search, const Eigen::Vector3d& center,
                 const Eigen::Vector3d& axis, const ShellLimits& limits, std::vector<float>& rho2);

/// Groups of aligned affordances (paper, section 3.3), every pair looked at.
std::vector<Handle> find_handles(const std::vector<SampleResult>& samples, const Options& options);

}  // namespace handhold::baseline
