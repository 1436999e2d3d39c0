#include "shots.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>

#include "projection.h"

namespace handhold::experiments {

std::size_t Shot::needed() const {
  return static_cast<std::size_t>(std::count_if(parts.begin(), parts.end(), [](const auto& part) {
    return evaluation::needed(part, evaluation::MatchOptions());
  }));
}

Shot shoot(const sensor::SceneFile& file) {
  const sensor::Scene scene = sensor::build(file);
  sensor::Frame frame = sensor::DepthCamera(file.camera).capture(scene, file.T_world_camera);
  Shot shot;
  shot.name = file.name;
  for (const sensor::Part& part : sensor::captured_truth(file, scene, frame))
    shot.parts.push_back(evaluation::labelled(part));
  shot.cloud = std::move(frame.cloud);
  return shot;
}

std::vector<Shot> shoot(const std::vector<sensor::SceneFile>& files, Progress& progress) {
  std::vector<Shot> shots(files.size());
  std::mutex mutex;
  std::size_t done = 0;
  tbb::parallel_for(std::size_t{0}, files.size(), [&](std::size_t i) {
    shots[i] = shoot(files[i]);
    const std::lock_guard<std::mutex> lock(mutex);
    progress.show("taking scene " + std::to_string(++done) + " of " + std::to_string(files.size()));
  });
  return shots;
}

std::size_t finite_points(const Cloud& cloud) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) count += finite_point(&cloud.xyz[3 * i]);
  return count;
}

double Counts::recall() const {
  return needed ? static_cast<double>(found) / static_cast<double>(needed) : 0;
}
double Counts::precision() const {
  return handles ? static_cast<double>(right) / static_cast<double>(handles) : 0;
}

Counts judge(const Shot& shot, const Result& result) {
  const evaluation::SceneScore score = evaluation::score_scene(shot.name, shot.parts, result.handles);
  Counts counts;
  for (const evaluation::PartCase& part : score.parts) {
    counts.needed += part.needed;
    counts.found += part.needed && part.handle >= 0;
  }
  counts.handles = score.handles.size();
  for (const evaluation::HandleCase& handle : score.handles) {
    counts.right += handle.verdict == evaluation::Verdict::kRight;
  }
  return counts;
}

}  // namespace handhold::experiments
