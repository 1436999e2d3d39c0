#include "sights.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "vec.h"

namespace handhold::sensor {
namespace {

/// Depth at which a sight's tangent plane meets another ray; negative or infinite when it does not.
double plane_depth(const Sight& sight, const Vector3& direction) {
  return sight.z * dot(sight.normal, sight.direction) / dot(sight.normal, direction);
}

class Looker {
 public:
  Looker(const DepthCamera& camera, const RayCaster& caster, const Pose& T_world_camera)
      : camera_(camera),
        noise_(camera.options().noise),
        caster_(caster),
        T_world_camera_(T_world_camera),
        projector_(T_world_camera.point({noise_.baseline, 0, 0})) {}

  /// At (u, v), anywhere in the image.
  Sight at(double u, double v) const {
    Sight sight;
    sight.direction = T_world_camera_.direction(camera_.ray(u, v));
    const std::optional<RayHit> hit = caster_.cast(T_world_camera_.t, sight.direction);
    // Seen from behind: the camera is inside a solid.
    if (!hit || !(hit->cos_incidence > 0)) return sight;
    sight.z = hit->t;
    sight.normal = hit->normal;
    sight.incidence = std::acos(std::min(1.0, hit->cos_incidence));
    sight.object = hit->object;
    return sight;
  }

  /// What the pixel with sight `own` gets when its line of sight is displaced by (du, dv) px: another surface, or the
  /// light of another place of the same surface.
  Sight displaced(const Sight& own, double u, double v, double du, double dv) const {
    Sight other = at(u + du, v + dv);
    if (other.exists()) light(other);
    if (edge_between(own, other, noise_.edge_step)) {
      // The pixel reports the other surface on its own ray.
      const double z = plane_depth(other, own.direction);
      if (std::abs(z - other.z) <= noise_.edge_step) other.z = z;
      other.direction = own.direction;
      return other;
    }
    Sight same = own;
    same.lit = other.lit;
    same.glare_angle = other.glare_angle;
    return same;
  }

  /// Fills in what depends on the projector.
  void light(Sight& sight) const {
    const Vector3 p = T_world_camera_.t + sight.z * sight.direction;
    const Vector3 to_projector = projector_ - p;
    const double toward = dot(sight.normal, to_projector);
    // Off the surface by more than what single precision loses.
    if (noise_.shadows) sight.lit = toward > 0 && !caster_.blocked(p + 1e-5 * sight.normal, projector_);
    if (noise_.glare_width > 0) {
      const Vector3 bisector = unit(to_projector) - unit(sight.direction);
      const double cosine = dot(sight.normal, bisector) / norm(bisector);
      sight.glare_angle = std::acos(std::clamp(cosine, -1.0, 1.0));
    }
  }

 private:
  const DepthCamera& camera_;
  const NoiseOptions& noise_;
  const RayCaster& caster_;
  const Pose& T_world_camera_;
  const Vector3 projector_;
};

}  // namespace

bool edge_between(const Sight& a, const Sight& b, double step) {
  if (!a.exists() || !b.exists()) return a.exists() != b.exists();
  const bool a_explains_b = std::abs(plane_depth(a, b.direction) - b.z) <= step;
  const bool b_explains_a = std::abs(plane_depth(b, a.direction) - a.z) <= step;
  return !a_explains_b && !b_explains_a;
}

std::vector<Sight> look(const DepthCamera& camera, const RayCaster& caster, const Pose& T_world_camera,
                        const NoiseField& field) {
  const CameraOptions& options = camera.options();
  const Looker looker(camera, caster, T_world_camera);
  const bool lateral = options.noise.lateral_sigma > 0 || options.noise.lateral_slant > 0;
  std::vector<Sight> sights(static_cast<std::size_t>(options.width) * options.height);
  tbb::parallel_for(std::uint32_t{0}, options.height, [&](std::uint32_t v) {
    for (std::uint32_t u = 0; u < options.width; ++u) {
      Sight sight = looker.at(u, v);
      if (lateral) {
        const double sigma = options.noise.lateral(sight.incidence);
        const std::array<double, 2> draw = field.at(u, v).lateral;
        sight = looker.displaced(sight, u, v, sigma * draw[0], sigma * draw[1]);
      } else if (sight.exists()) {
        looker.light(sight);
      }
      sights[static_cast<std::size_t>(v) * options.width + u] = sight;
    }
  });
  return sights;
}

}  // namespace handhold::sensor
