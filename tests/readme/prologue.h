
// What the README's example takes for granted: a cloud, and a robot that grasps.
#include <handhold/localizer.h>

#include <cmath>
#include <cstdio>
#include <vector>

/// A rod of 50 mm across and 300 mm long, 0.7 m before the sensor, on its near side a point every 2 mm.
inline handhold::Cloud make_rod() {
  handhold::Cloud rod;
  constexpr double kRadius = 0.025, kDistance = 0.7, kStep = 0.002;
  for (double x = -0.15; x <= 0.15; x += kStep) {
    for (double angle = -1.4; angle <= 1.4; angle += kStep / kRadius) {
      rod.xyz.push_back(static_cast<float>(x));
      rod.xyz.push_back(static_cast<float>(kRadius * std::sin(angle)));
      rod.xyz.push_back(static_cast<float>(kDistance - kRadius * std::cos(angle)));
    }
  }
  rod.width = static_cast<std::uint32_t>(rod.xyz.size() / 3);
  return rod;
}
inline const handhold::Cloud cloud = make_rod();
inline const handhold::CloudView cloud_view = cloud.view();

inline int grasped = 0, failed = 0;
inline void grasp(const handhold::Vector3& center, const handhold::Vector3& axis, double radius) {
  ++grasped;
  const bool right = std::abs(radius - 0.025) < 0.005 && std::abs(axis[0]) > 0.98 && std::abs(center[1]) < 0.005 &&
                     std::abs(center[2] - 0.7) < 0.005;
  if (!right) {
    ++failed;
    std::printf(
        "wrong handle: centre %g %g %g, axis %g %g %g, radius %g; the rod: centre . 0 0.7, axis 1 0 0, radius 0.025\n",
        center[0], center[1], center[2], axis[0], axis[1], axis[2], radius);
  }
}
