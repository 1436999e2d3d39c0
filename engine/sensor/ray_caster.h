// Rays against the meshes of a scene: the only file that knows Embree here.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "handhold/sensor.h"

namespace handhold::sensor {

struct RayHit {
  double t;              ///< multiple of the ray's direction
  double cos_incidence;  ///< between the outward normal and the way back; negative: the surface was hit from inside
  Vector3 normal;        ///< unit, out of the solid
  std::int32_t object;   ///< index into Scene::objects
};

struct Crossing {
  double t;             ///< multiple of the ray's direction
  bool entering;        ///< from outside of a solid into it
  std::int32_t object;  ///< index into Scene::objects
};

/// A scene built for ray casting, in the scene's frame. Calls may overlap.
class RayCaster {
 public:
  /// @throws std::invalid_argument for a mesh that cannot be, std::runtime_error when Embree fails
  explicit RayCaster(const Scene& scene);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  /// First surface along origin + t * direction, 0 <= t; the direction need not be a unit vector.
  std::optional<RayHit> cast(const Vector3& origin, const Vector3& direction) const;
  /// Whether anything lies between two points (both ends included).
  bool blocked(const Vector3& from, const Vector3& to) const;
  /// Every surface along origin + t * direction, 0 <= t, in no particular order. An edge or corner that the ray meets
  /// may count more than once.
  std::vector<Crossing> crossings(const Vector3& origin, const Vector3& direction) const;
  /// Calls visit(object, triangle) for every triangle whose bounding box is nearer to p than `distance` (m), and for a
  /// few more.
  void near(const Vector3& p, double distance,
            const std::function<void(std::int32_t object, std::uint32_t triangle)>& visit) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handhold::sensor
