// What each pixel of the camera looks at, before anything is measured: a ray a pixel, outlines moved by the lateral
// noise, the reach of the projector, and where two surfaces meet in the image.
#pragma once

#include <cstdint>
#include <vector>

#include "handhold/sensor.h"
#include "noise_field.h"
#include "ray_caster.h"

namespace handhold::sensor {

/// The surface that a pixel looks at; the scene's frame.
struct Sight {
  double z = 0;              ///< m; depth, the multiple of `direction`; 0: nothing there
  Vector3 direction = {};    ///< of the ray, its component along the optical axis is 1
  Vector3 normal = {};       ///< unit, towards the camera
  double incidence = 0;      ///< rad
  double glare_angle = 0;    ///< rad; between the normal and the bisector of the ways to camera and projector
  std::int32_t object = -1;  ///< index into Scene::objects
  bool lit = true;           ///< reached by the projector; true when shadows are off
  bool exists() const { return z > 0; }
};

/// One sight a pixel, row by row.
std::vector<Sight> look(const DepthCamera& camera, const RayCaster& caster, const Pose& T_world_camera,
                        const NoiseField& field);

/// Whether no plane explains both: one looks at something and the other at nothing, or the plane of neither goes
/// through the other's point to within `step` (m) of depth. Steep surfaces and creases are no edges.
bool edge_between(const Sight& a, const Sight& b, double step);

}  // namespace handhold::sensor
