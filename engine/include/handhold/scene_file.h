// Scenes as files: which objects of which families stand where, and which camera looks at them.
//
//   sensor::SceneFile file = sensor::read_scene("scene.toml");
//   sensor::Scene scene = sensor::build(file);
//   sensor::Frame frame = sensor::DepthCamera(file.camera).capture(scene, file.T_world_camera);
//   std::vector<sensor::Part> truth = sensor::captured_truth(file, scene, frame);
//
// Metres and radians.
#pragma once

#include <string>
#include <vector>

#include "handhold/families.h"
#include "handhold/sensor.h"

namespace handhold::sensor {

/// One thing of a scene.
struct SceneObject {
  std::string name;    ///< unique in the scene
  std::string family;  ///< "mug", "bottle", ...; see families()
  Sizes sizes;         ///< m, by name; those that are missing have the family's defaults
  Material material;
  Pose T_world_object;
};

struct SceneFile {
  std::string name;  ///< of the files made from it: letters, digits, '_', '-' and '.'
  std::vector<SceneObject> objects;
  Pose T_world_camera;  ///< of the optical frame: x right, y down, z forward
  CameraOptions camera;
};

/// Object i of the scene is object i of the file, with its name and material.
/// @throws std::invalid_argument as make_object, naming the object
Scene build(const SceneFile& file);

/// Reads a scene, see README ("Simulated scenes").
/// @throws std::runtime_error with one line: what is wrong, in which file and line, what would be right
SceneFile read_scene(const std::string& path);
/// The same from text.
/// @param text  TOML
/// @param source  name of the text in messages
SceneFile parse_scene(const std::string& text, const std::string& source);
/// TOML that parse_scene reads back to the same scene, bit for bit. Every camera option is written, so that the file
/// stays what it is when defaults change.
std::string to_toml(const SceneFile& file);

/// The parts of a scene in the camera's frame, as the frame shows them: Part::visible as DepthCamera::truth has it,
/// Part::measured from the frame's points, Part::raised from the scene, Part::graspable from GraspCheck with an 0.08 m
/// hand and 0.01 m fingers: whether they fit somewhere along the centre line (every 10 mm and in its middle).
/// @param scene  what was looked at
/// @param T_world_camera  of the optical frame
/// @param options  of the camera
/// @param frame  what DepthCamera(options).capture(scene, T_world_camera) gave
/// @throws std::invalid_argument when the frame's size is not the camera's
std::vector<Part> captured_truth(const Scene& scene, const Pose& T_world_camera, const CameraOptions& options,
                                 const Frame& frame);
std::vector<Part> captured_truth(const SceneFile& file, const Scene& scene, const Frame& frame);

}  // namespace handhold::sensor
