// Simulated scenes as the experiments use them: cloud and truth in memory.
#pragma once

#include <string>
#include <vector>

#include "handhold/scene_file.h"
#include "matching.h"
#include "progress.h"

namespace handhold::experiments {

/// A scene as its camera took it.
struct Shot {
  std::string name;
  Cloud cloud;
  std::vector<evaluation::LabelledPart> parts;  ///< in the cloud's frame

  /// Number of parts that a result has to have (evaluation::needed).
  std::size_t needed() const;
};

/// One shot of a scene, with the truth of its frame.
Shot shoot(const sensor::SceneFile& file);
/// Shots of all scenes, in parallel in the caller's TBB arena.
std::vector<Shot> shoot(const std::vector<sensor::SceneFile>& files, Progress& progress);

std::size_t finite_points(const Cloud& cloud);

/// What became of a result: counts to be added up over scenes.
struct Counts {
  std::size_t needed = 0, found = 0;   ///< parts
  std::size_t handles = 0, right = 0;  ///< handles; right: the first one on a listed part

  void operator+=(const Counts& other) {
    needed += other.needed, found += other.found, handles += other.handles, right += other.right;
  }
  double recall() const;     ///< 0 when nothing is needed
  double precision() const;  ///< 0 without handles
};
Counts judge(const Shot& shot, const Result& result);

}  // namespace handhold::experiments
