#include "simulation.h"

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <vector>

namespace handhold::physics {
namespace {

[[noreturn]] void on_error(const char* text) {
  throw std::runtime_error(std::string("MuJoCo: ") + text);
}
void on_warning(const char*) {}

/// MuJoCo has one handler for the whole process. Without, it ends the process on an error and writes a log file on a
/// warning; handlers that the program has set stay.
void quieten() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (!mju_user_error) mju_user_error = on_error;
    if (!mju_user_warning) mju_user_warning = on_warning;
  });
}

sensor::Pose pose_of(const mjtNum* position, const mjtNum* rotation) {
  sensor::Pose pose;
  std::copy(position, position + 3, pose.t.begin());
  std::copy(rotation, rotation + 9, pose.R.begin());
  return pose;
}

}  // namespace

Simulation::Simulation(const std::string& mjcf) {
  quieten();
  static std::mutex one_at_a_time;  // MuJoCo keeps the text that it read last
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  constexpr const char* kFile = "world.xml";
  const auto files = std::make_unique<mjVFS>();  // of 2 MB
  mj_defaultVFS(files.get());
  char error[500] = "";
  if (mj_makeEmptyFileVFS(files.get(), kFile, static_cast<int>(mjcf.size())) == 0) {
    std::copy(mjcf.begin(), mjcf.end(), static_cast<char*>(files->filedata[mj_findFileVFS(files.get(), kFile)]));
    model.reset(mj_loadXML(kFile, files.get(), error, sizeof error));
  }
  mj_deleteVFS(files.get());
  if (!model) {
    std::string reason = error;
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw std::invalid_argument("MuJoCo does not take the world: " + reason);
  }
  data.reset(mj_makeData(model.get()));
}

int Simulation::id(mjtObj type, const std::string& name) const {
  const int found = mj_name2id(model.get(), type, name.c_str());
  if (found < 0) throw std::logic_error("the physics model has no '" + name + "'");
  return found;
}

sensor::Pose Simulation::body_pose(int body) const {
  return pose_of(data->xpos + 3 * body, data->xmat + 9 * body);
}

sensor::Pose Simulation::geom_pose(int geom) const {
  return pose_of(data->geom_xpos + 3 * geom, data->geom_xmat + 9 * geom);
}

void Simulation::check() const {
  for (int warning = 0; warning < mjNWARNING; ++warning) {
    const mjWarningStat& stat = data->warning[warning];
    if (stat.number == 0) continue;
    throw std::runtime_error(std::string("the physics broke down: ") + mju_warningText(warning, stat.lastinfo));
  }
}

}  // namespace handhold::physics
