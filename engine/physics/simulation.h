// MuJoCo's model and state, owned, quiet, and with exceptions for errors.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>

#include "handhold/sensor.h"

namespace handhold::physics {

struct Simulation {
  struct Deleter {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  std::unique_ptr<mjModel, Deleter> model;
  std::unique_ptr<mjData, Deleter> data;

  /// @throws std::invalid_argument for text that MuJoCo does not take
  explicit Simulation(const std::string& mjcf);

  /// @throws std::logic_error when there is none of that name, here and below
  int body(const std::string& name) const { return id(mjOBJ_BODY, name); }
  int joint(const std::string& name) const { return id(mjOBJ_JOINT, name); }
  int motor(const std::string& name) const { return id(mjOBJ_ACTUATOR, name); }
  std::string body_name(int body) const { return mj_id2name(model.get(), mjOBJ_BODY, body); }

  sensor::Pose body_pose(int body) const;  ///< T_world_body
  sensor::Pose geom_pose(int geom) const;  ///< T_world_geom

  /// @throws std::runtime_error when MuJoCo has warned of numbers that are not finite, or of too many contacts
  void check() const;

 private:
  int id(mjtObj type, const std::string& name) const;
};

}  // namespace handhold::physics
