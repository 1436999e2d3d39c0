// The table scene of data/, as the simulated camera sees it.
#pragma once

#include "handhold/sensor.h"

namespace handhold::test {

inline const Cloud& demo_cloud() {
  static const Cloud cloud = sensor::DepthCamera(sensor::table_scene_camera_options())
                                 .capture(sensor::table_scene(), sensor::table_scene_camera())
                                 .cloud;
  return cloud;
}

}  // namespace handhold::test
