// From where a page shows its cloud first, and about which direction one turns it.
#pragma once

#include "handhold/cloud.h"

namespace handhold {

struct StartView {
  Vector3 eye = {0, 0, 0};
  Vector3 target = {0, 0, 1};  ///< in the middle of the picture, as far away as the cloud's middle
  Vector3 down = {0, 1, 0};    ///< unit; in the picture
  Vector3 up = {0, -1, 0};     ///< unit; out of what things stand on
  double angle = 1;            ///< rad; vertical field of view of a picture of 4 : 3
};

/// Where the sensor stood, or outside where the cloud does not tell. `up` is the normal of the largest plane that the
/// camera may have under it; without one the opposite of `down`. The same cloud gives the same view.
StartView start_view(const CloudView& cloud);

}  // namespace handhold
