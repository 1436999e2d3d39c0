// Regenerates data/: the demonstration cloud and its truth, from the simulated depth camera.
#include <cstdio>
#include <exception>
#include <string>

#include "atomic_file.h"
#include "handhold/io.h"
#include "handhold/scene_file.h"
#include "handhold/sensor.h"

int main(int argc, char** argv) try {
  if (argc != 2 || argv[1][0] == '-') {
    std::fprintf(stderr, "usage: make_data FOLDER   writes table_scene.pcd and table_scene.truth.json there\n");
    return 2;
  }
  const std::string folder = argv[1];
  using namespace handhold;
  const sensor::Scene scene = sensor::table_scene();
  const sensor::DepthCamera camera(sensor::table_scene_camera_options());
  const sensor::Pose T_world_camera = sensor::table_scene_camera();

  const sensor::Frame frame = camera.capture(scene, T_world_camera);
  write_pcd(folder + "/table_scene.pcd", frame.cloud.view());
  AtomicFile truth(folder + "/table_scene.truth.json");
  truth.write(
      sensor::truth_json({{"table_scene", sensor::captured_truth(scene, T_world_camera, camera.options(), frame)}}));
  truth.commit();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "make_data: %s\n", error.what());
  return 1;
}
