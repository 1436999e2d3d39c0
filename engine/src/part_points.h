// The points of the cloud about a line, and which of them lie on a cylinder.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "aligned.h"
#include "cylinder.h"
#include "depth_image.h"
#include "index.h"
#include "tiles.h"

namespace handhold {

/// A cylinder's own directions: `ahead` across the axis towards the sensor, `side` across both.
struct CylinderFrame {
  Vector3 ahead, side;
};

/// Points belong to a cylinder within this of its surface (m).
inline double cylinder_band(double radius, double sigma) {
  return 0.25 * radius + 2 * sigma;
}

/// Reused from line to line. All lengths in metres.
class PartPoints {
 public:
  void begin(const TileStore& tiles, const NeighbourIndex& index, const DepthImage& image, bool filter_normals = true) {
    tiles_ = &tiles, index_ = &index, image_ = &image, filter_normals_ = filter_normals;
    normals_.clear();
    normals_of_.assign(tiles.blocks(), kNone);
  }

  CylinderFrame frame(const Cylinder& c) const;

  /// Takes the points between `low` and `high` along the axis, on and around the cylinder's side that the sensor sees;
  /// of too many every n-th. `sigma`: standard deviation of depth there.
  void gather(const Cylinder& c, double low, double high, double sigma);

  /// Marks the points between `low` and `high` that lie on the cylinder, and takes some of them for a fit. Returns how
  /// many are marked.
  std::size_t select(const Cylinder& c, double low, double high);
  /// Keeps the marks between `low` and `high` only, and takes all of these.
  std::size_t narrow(double low, double high);

  std::size_t size() const { return id_.size(); }
  // Relative to the cylinder of the last `select`.
  double height(std::size_t i) const { return static_cast<double>(height_[i]); }
  double distance(std::size_t i) const { return static_cast<double>(distance_[i]); }
  double side(std::size_t i) const { return static_cast<double>(side_[i]); }
  double ahead(std::size_t i) const { return static_cast<double>(ahead_[i]); }
  /// Component of the point's normal away from the axis, times its distance from it; false: no normal is known.
  bool outward(std::size_t i, const CylinderFrame& f, double& component);

  /// Positions of all that are marked.
  const std::vector<std::uint32_t>& selected() const { return selected_; }
  /// Those that were taken, for refine_cylinder and arc_of.
  PointArrays taken() const { return {fit_x_.data(), fit_y_.data(), fit_z_.data(), fitted_}; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Normal {
    Vector3 direction{};  ///< unit; zero when it has too few points around
    bool known = false;
  };
  const Vector3& normal_of(std::size_t i) {
    if (!known_[i]) normal_[i] = shared_normal(i), known_[i] = 1;
    return normal_[i];
  }
  Vector3 shared_normal(std::size_t i);
  Vector3 find_normal(std::uint32_t id);
  void locate(const Cylinder& c);
  void mark(const Cylinder& c, double low, double high);
  void take(std::size_t most);

  const TileStore* tiles_ = nullptr;
  const NeighbourIndex* index_ = nullptr;
  const DepthImage* image_ = nullptr;
  bool filter_normals_ = true;  ///< points whose normal is another surface's do not lie on the cylinder
  double sigma_ = 0;
  CandidateList near_, around_;
  std::vector<float> x_, y_, z_;
  std::vector<std::uint32_t> id_;  ///< position in the tiles
  std::vector<float> height_, distance_, side_, ahead_;
  std::vector<std::uint32_t> ids_, selected_;
  std::vector<Vector3> normal_;                   ///< of each point that was asked for one
  std::vector<char> known_;                       ///< which were
  std::vector<std::array<Normal, 256>> normals_;  ///< of the blocks that were asked for, in all lines of the frame
  std::vector<std::uint32_t> normals_of_;         ///< block -> position in normals_
  std::vector<float> fit_x_, fit_y_, fit_z_;      ///< with 15 more
  std::size_t fitted_ = 0;
};

/// Thinner parts have no reliable normals (m).
inline constexpr double kNormalFrom = 0.010;

}  // namespace handhold
