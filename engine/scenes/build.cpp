#include <stdexcept>

#include "handhold/scene_file.h"

namespace handhold::sensor {

Scene build(const SceneFile& file) {
  Scene scene;
  for (const SceneObject& o : file.objects) {
    Object object;
    try {
      object = make_object(o.family, o.sizes);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("object '" + o.name + "': " + error.what());
    }
    object.name = o.name;
    object.material = o.material;
    scene.add(object, o.T_world_object);
  }
  return scene;
}

}  // namespace handhold::sensor
