// The pinhole camera, and what the sensor makes of the surfaces it looks at.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "handhold/sensor.h"
#include "noise_field.h"
#include "ray_caster.h"
#include "sights.h"
#include "vec.h"

namespace handhold::sensor {
namespace {

void validate(const Object& object) {
  const auto require_share = [&](const char* name, double value) {
    // Phrased so that NaN fails.
    if (value >= 0 && value <= 1) return;
    throw std::invalid_argument("scene: object '" + object.name + "' has material." + name + " = " +
                                std::to_string(value) + "; must be 0 to 1");
  };
  require_share("reflectance", object.material.reflectance);
  require_share("specular", object.material.specular);
}

struct Measurement {
  double z = std::numeric_limits<double>::quiet_NaN();  ///< m; NaN: nothing came back
  std::int32_t object = -1;
};

/// Turns sights to measurements, pixel by pixel.
class Sensor {
 public:
  Sensor(const CameraOptions& options, const Scene& scene, const std::vector<Sight>& sights, const NoiseField& field)
      : options_(options), noise_(options.noise), scene_(scene), sights_(sights), field_(field) {}

  Measurement at(std::uint32_t u, std::uint32_t v) const {
    const Sight& own = sight(u, v);
    if (!own.exists() || !own.lit) return {};
    const Draw draw = field_.at(u, v);
    if (draw.dropout < lost(own)) return {};
    Measurement result = {own.z, own.object};
    if (draw.edge < noise_.edge_dropout + noise_.mixed) {
      const Edge edge = edge_at(u, v, own);
      if (edge.exists && draw.edge < noise_.edge_dropout) return {};
      if (edge.across && draw.edge >= noise_.edge_dropout) {
        result.z += draw.mixture * (edge.across->z - own.z);
        if (draw.mixture > 0.5) result.object = edge.across->object;
      }
    }
    result.z = noise_.quantized(result.z + noise_.sigma(result.z, own.incidence) * draw.axial);
    if (!(result.z >= options_.min_range && result.z <= options_.max_range)) return {};
    return result;
  }

 private:
  struct Edge {
    bool exists = false;
    const Sight* across = nullptr;  ///< the measurable surface with the largest step in depth, if any
  };

  const Sight& sight(std::uint32_t u, std::uint32_t v) const {
    return sights_[static_cast<std::size_t>(v) * options_.width + u];
  }

  /// Probability that grazing incidence, a highlight or darkness takes the measurement; they are independent.
  double lost(const Sight& own) const {
    const Material& material = scene_.objects[own.object].material;
    const double distance = own.z * norm(own.direction);
    const double signal =
        material.reflectance * (1 - material.specular) * std::cos(own.incidence) / (distance * distance);
    const double kept = (1 - noise_.dropout(own.incidence)) * (1 - noise_.glare(material.specular, own.glare_angle)) *
                        (1 - noise_.darkness(signal));
    return 1 - kept;
  }

  Edge edge_at(std::uint32_t u, std::uint32_t v, const Sight& own) const {
    Edge edge;
    const auto visit = [&](const Sight& other) {
      if (!edge_between(own, other, noise_.edge_step)) return;
      edge.exists = true;
      if (!other.exists() || !other.lit) return;
      if (!edge.across || std::abs(other.z - own.z) > std::abs(edge.across->z - own.z)) edge.across = &other;
    };
    if (u > 0) visit(sight(u - 1, v));
    if (u + 1 < options_.width) visit(sight(u + 1, v));
    if (v > 0) visit(sight(u, v - 1));
    if (v + 1 < options_.height) visit(sight(u, v + 1));
    return edge;
  }

  const CameraOptions& options_;
  const NoiseOptions& noise_;
  const Scene& scene_;
  const std::vector<Sight>& sights_;
  const NoiseField& field_;
};

}  // namespace

DepthCamera::DepthCamera(const CameraOptions& options) : options_(options) {
  options_.validate();
}

Vector3 DepthCamera::ray(double u, double v) const {
  return {(u - options_.cx) / options_.fx, (v - options_.cy) / options_.fy, 1};
}

std::optional<Point2> DepthCamera::project(const Vector3& p) const {
  if (!(p[2] > 0)) return std::nullopt;
  return Point2{options_.fx * p[0] / p[2] + options_.cx, options_.fy * p[1] / p[2] + options_.cy};
}

Frame DepthCamera::capture(const Scene& scene, const Pose& T_world_camera) const {
  for (const Object& object : scene.objects) validate(object);
  const RayCaster caster(scene);
  const NoiseField field(options_);
  const std::vector<Sight> sights = look(*this, caster, T_world_camera, field);
  const Sensor sensor(options_, scene, sights, field);

  Frame frame;
  frame.cloud.width = options_.width;
  frame.cloud.height = options_.height;
  frame.cloud.viewpoint = Vector3{0, 0, 0};
  frame.cloud.xyz.assign(3 * sights.size(), std::numeric_limits<float>::quiet_NaN());
  frame.object.assign(sights.size(), -1);
  tbb::parallel_for(std::uint32_t{0}, options_.height, [&](std::uint32_t v) {
    for (std::uint32_t u = 0; u < options_.width; ++u) {
      const Measurement measurement = sensor.at(u, v);
      if (std::isnan(measurement.z)) continue;
      const std::size_t pixel = static_cast<std::size_t>(v) * options_.width + u;
      const Vector3 p = measurement.z * ray(u, v);
      for (int k = 0; k < 3; ++k) frame.cloud.xyz[3 * pixel + k] = static_cast<float>(p[k]);
      frame.object[pixel] = measurement.object;
    }
  });
  return frame;
}

}  // namespace handhold::sensor
