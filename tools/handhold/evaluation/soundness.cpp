#include "soundness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

namespace handhold::evaluation {

void check_soundness(Scene& scene, const sensor::Scene& geometry, const sensor::Pose& T_world_camera,
                     const sensor::Hand& hand) {
  hand.validate();
  const sensor::GraspCheck check(geometry);
  for (std::size_t i = 0; i < scene.score.handles.size(); ++i) {
    HandleCase& handle = scene.score.handles[i];
    if (handle.verdict == Verdict::kLeftOut) continue;
    const Handle& h = scene.result.handles[i];
    const sensor::GraspVerdict found =
        check.check(T_world_camera.point(h.center), T_world_camera.direction(h.axis), h.radius, hand);
    handle.sound = found.fits;
    handle.unsound = found.reason;
    if (found.blocked_by >= 0) {
      handle.unsound += " (" + geometry.objects[static_cast<std::size_t>(found.blocked_by)].name + ")";
    }
  }
  const std::vector<Affordance>& affordances = scene.result.affordances;
  std::vector<char> sound(affordances.size(), 0);
  tbb::parallel_for(std::size_t{0}, sound.size(), [&](std::size_t i) {
    const Affordance& a = affordances[i];
    sound[i] = check.fits(T_world_camera.point(a.center), T_world_camera.direction(a.axis), a.radius, hand);
  });
  scene.score.affordances = affordances.size();
  scene.score.sound_affordances = static_cast<std::size_t>(std::count(sound.begin(), sound.end(), 1));
}

}  // namespace handhold::evaluation
