// The world as a camera sees it.
#include "world_impl.h"

namespace handhold::physics {
namespace {

constexpr double kFloorReach = 4;  // m

/// Of a geom of the surroundings or of an arm.
sensor::Mesh mesh_of(const Simulation& simulation, int geom) {
  const mjtNum* size = simulation.model->geom_size + 3 * geom;
  const Pose T = simulation.geom_pose(geom);
  switch (simulation.model->geom_type[geom]) {
    case mjGEOM_BOX:
      return sensor::transformed(sensor::box(2 * size[0], 2 * size[1], 2 * size[2]), T);
    case mjGEOM_CYLINDER:
      return sensor::transformed(sensor::cylinder(size[0], 2 * size[1], 48), T * sensor::translation(0, 0, -size[1]));
    case mjGEOM_PLANE:
      return sensor::transformed(sensor::box(2 * kFloorReach, 2 * kFloorReach, 0.1),
                                 T * sensor::translation(0, 0, -0.05));
    default:
      return {};
  }
}

/// All geoms of a body.
sensor::Object object_of(const Simulation& simulation, int body) {
  const mjModel& m = *simulation.model;
  sensor::Object object;
  object.name = simulation.body_name(body);
  for (int i = 0; i < m.body_geomnum[body]; ++i) {
    object.mesh = sensor::merged(object.mesh, mesh_of(simulation, m.body_geomadr[body] + i));
  }
  return object;
}

bool is_below(const mjModel& m, int body, int ancestor) {
  while (body > ancestor) body = m.body_parentid[body];  // parents come first
  return body == ancestor;
}

}  // namespace

sensor::Scene World::scene(const SceneParts& parts) const {
  const Simulation& simulation = impl_->simulation;
  sensor::Scene scene;
  for (std::size_t i = 0; i < impl_->objects.size(); ++i) scene.add(impl_->objects[i], pose(i));
  if (parts.surroundings) {
    for (const char* name : {"table", "bin", "floor"}) scene.add(object_of(simulation, simulation.body(name)));
  }
  if (parts.arms) {
    const mjModel& m = *simulation.model;
    const int right = simulation.body("right_arm_mount"), left = simulation.body("left_arm_mount");
    for (int body = 1; body < m.nbody; ++body) {
      const bool is_link = is_below(m, body, right) || is_below(m, body, left);
      if (is_link && m.body_geomnum[body] > 0) scene.add(object_of(simulation, body));
    }
  }
  return scene;
}

}  // namespace handhold::physics
