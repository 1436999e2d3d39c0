#include "ribbon.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "kernels.h"

namespace handhold {
namespace {

constexpr double kWidest = 0.030;       ///< m
constexpr double kNarrowest = 2.5;      ///< px
constexpr std::size_t kDirections = 8;  ///< over half a turn
constexpr double kStation = 0.005;      ///< m; from one look across to the next one along the strip
constexpr int kStations = 4;            ///< either way
constexpr std::size_t kLeastStations = 5;
/// Widths along a strip differ by less (share, and px).
constexpr double kSameWidth = 0.3, kSamePixels = 1.5;
/// Shorter than so many widths it is a blob.
constexpr double kAspect = 1.2;

/// Unit vectors over half a turn, and their opposites.
struct Fan {
  std::array<float, 2 * kDirections> column{}, row{};
  Fan() {
    for (std::size_t k = 0; k < kDirections; ++k) {
      const double angle = static_cast<double>(k) * (3.14159265358979324 / kDirections);
      column[k] = static_cast<float>(std::cos(angle)), row[k] = static_cast<float>(std::sin(angle));
      column[kDirections + k] = -column[k], row[kDirections + k] = -row[k];
    }
  }
};
const Fan kFan;

class Strip {
 public:
  Strip(const DepthImage& image, double jump) : image_(image), jump_(jump) {}

  double depth(double u, double v) const { return image_.depth_in(u, v); }

  /// Pixels from (u, v) to the step that ends the surface in a direction; negative: none within `most`.
  double end(double u, double v, double du, double dv, int most) const {
    double last = depth(u, v), before = last;
    if (!(last > 0)) return -1;
    for (int k = 1; k <= most; ++k) {
      const double z = depth(u + k * du, v + k * dv);
      if (!(z > 0) || z < last - jump_) return -1;
      if (z > last + jump_) return k - 0.5;
      if (z > before + jump_) return k - 1;
      before = last, last = z;
    }
    return -1;
  }

  /// Whether what is seen at that distance on two opposite sides may lie behind the surface at the place. On planes it
  /// does not, however they are tilted; a strip has something farther, or unknown, beyond it on both sides.
  bool may_end(double u, double v, double distance) const {
    const double z = depth(u, v);
    for (std::size_t k = 0; k < kDirections; ++k) {
      const double du = distance * static_cast<double>(kFan.column[k]),
                   dv = distance * static_cast<double>(kFan.row[k]);
      const double a = depth(u + du, v + dv), b = depth(u - du, v - dv);
      if (!(a > 0 && b > 0 && a + b - 2 * z <= jump_)) return true;
    }
    return false;
  }

  struct Chord {
    double left = -1, right = -1;
    double width() const { return left + right; }
    bool valid() const { return left >= 0 && right >= 0; }
  };
  Chord across(double u, double v, double du, double dv, int most) const {
    Chord c;
    c.right = end(u, v, du, dv, most);
    if (c.right >= 0) c.left = end(u, v, -du, -dv, most);
    return c;
  }

 private:
  const DepthImage& image_;
  double jump_;
};

}  // namespace

bool find_ribbon(const DepthImage& image, const Vector3& sample, Cylinder& ribbon) {
  const DepthImage::Projected p = image.project(sample);
  if (!(p.depth > 0.05)) return false;
  const double z0 = p.depth, per_metre = image.focal() / z0;
  const int most = static_cast<int>(kWidest * per_metre);
  if (most < 3) return false;
  const Strip strip(image, depth_step(depth_noise(z0)));
  double u = p.a / z0 + 0.5, v = p.b / z0 + 0.5;
  double least = most + 1.0, du = 0, dv = 0;
  if (!strip.may_end(u, v, most)) return false;
  kernels::RayQuery rays{};
  rays.depth = image.pixels(), rays.width = image.width(), rays.height = image.height();
  rays.column = static_cast<float>(u), rays.row = static_cast<float>(v);
  std::copy(kFan.column.begin(), kFan.column.end(), rays.out_column);
  std::copy(kFan.row.begin(), kFan.row.end(), rays.out_row);
  rays.jump = static_cast<float>(depth_step(depth_noise(z0))), rays.most = most;
  float ends[2 * kDirections];
  kernels::kernels().ray_ends(rays, ends);
  for (std::size_t k = 0; k < kDirections; ++k) {
    const float right = ends[k], left = ends[kDirections + k];
    if (right < 0 || left < 0 || static_cast<double>(left + right) >= least) continue;
    least = static_cast<double>(left + right);
    du = static_cast<double>(kFan.column[k]), dv = static_cast<double>(kFan.row[k]);
  }
  if (least > most || least < kNarrowest) return false;

  // Along the strip, each time from the middle of the last look across.
  struct Station {
    double u, v, z, width;
  };
  std::array<Station, 2 * kStations + 1> stations;
  std::size_t found = 0;
  const auto look = [&](double& at_u, double& at_v) {
    const Strip::Chord chord = strip.across(at_u, at_v, du, dv, most);
    if (!chord.valid() || std::fabs(chord.width() - least) > kSameWidth * least + kSamePixels) return false;
    const double shift = 0.5 * (chord.right - chord.left);
    at_u += shift * du, at_v += shift * dv;
    // The middle's depth: of three pixels the median.
    const double a = strip.depth(at_u - du, at_v - dv), b = strip.depth(at_u, at_v),
                 c = strip.depth(at_u + du, at_v + dv);
    const double z = std::max(std::min(a, b), std::min(std::max(a, b), c));
    if (!(z > 0) || !std::isfinite(z)) return false;
    stations[found++] = {at_u, at_v, z, chord.width()};
    return true;
  };
  if (!look(u, v)) return false;
  const double step = kStation * per_metre;
  for (const double way : {1.0, -1.0}) {
    double at_u = stations[0].u, at_v = stations[0].v, last_z = stations[0].z;
    for (int k = 0; k < kStations; ++k) {
      at_u -= way * step * dv, at_v += way * step * du;
      const double from_u = at_u, from_v = at_v;
      if (!look(at_u, at_v)) break;
      // Another surface, or another strip that crosses this one.
      if (std::fabs(stations[found - 1].z - last_z) > 2 * kStation + 3 * depth_noise(z0) ||
          std::hypot(at_u - from_u, at_v - from_v) > step) {
        --found;
        break;
      }
      last_z = stations[found - 1].z;
    }
  }
  if (found < kLeastStations) return false;

  // In space: the line through the middles.
  Vector3 sum{};
  std::array<Vector3, 2 * kStations + 1> middle;
  std::array<double, 2 * kStations + 1> width;
  for (std::size_t i = 0; i < found; ++i) {
    middle[i] = image.unproject(stations[i].u - 0.5, stations[i].v - 0.5, stations[i].z);
    width[i] = stations[i].width * stations[i].z / image.focal();
    sum = sum + middle[i];
  }
  const Vector3 mean = (1.0 / static_cast<double>(found)) * sum;
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < found; ++i) {
    const Vector3 d = middle[i] - mean;
    const Eigen::Vector3d e(d[0], d[1], d[2]);
    C += e * e.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(C * 1e4);
  const Eigen::Vector3d a = solver.eigenvectors().col(2);
  const auto mid = width.begin() + static_cast<std::ptrdiff_t>(found / 2);
  std::nth_element(width.begin(), mid, width.begin() + static_cast<std::ptrdiff_t>(found));
  ribbon.axis = normalized(Vector3{a[0], a[1], a[2]});
  ribbon.radius = 0.5 * *mid;
  double low = 0, high = 0;
  for (std::size_t i = 0; i < found; ++i) {
    const double h = dot(middle[i] - mean, ribbon.axis);
    low = std::min(low, h), high = std::max(high, h);
  }
  if (high - low < std::max(0.018, kAspect * 2 * ribbon.radius - 0.005)) return false;
  // Beside the sample, a radius behind the surface.
  const Vector3 back = mean - image.viewpoint();
  const Vector3 away = normalized(back - dot(back, ribbon.axis) * ribbon.axis);
  ribbon.point = mean + dot(sample - mean, ribbon.axis) * ribbon.axis + ribbon.radius * away;
  return true;
}

}  // namespace handhold
