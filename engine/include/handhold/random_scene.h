// Scenes that a program makes up: random ones, and the fixed sets of the paper's experiments.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "handhold/scene_file.h"

namespace handhold::sensor {

struct RandomSceneOptions {
  /// Families of the things asked for; empty: none, the scene is all clutter.
  std::vector<std::string> targets;
  std::vector<std::string> clutter;  ///< families of the rest; not empty
  int min_targets = 1;               ///< >= 0
  int max_targets = 4;               ///< min_targets .. 16
  /// Things beyond the targets, 0 .. 16; unset: 0, 3 or 8 for seeds that leave a remainder of 0, 1 or 2 when divided by
  /// three, so that seeds in a row have each equally often.
  std::optional<int> clutter_level;

  /// Targets are the graspable families of a half, clutter all of its families. kBoth: every family.
  /// Tune on kTuning, report on kReport.
  static RandomSceneOptions of_half(FamilyHalf half);
  /// Plain families only: nothing to be found. 1 to 4 things besides the clutter.
  static RandomSceneOptions negatives(FamilyHalf half);

  /// @throws std::invalid_argument naming what is wrong
  void validate() const;
};

/// A scene on a table top (z = 0): targets near its middle, clutter around them; shapes drawn from the families'
/// ranges; things that stand, or lie as they come to rest from a random orientation, some on top of others; no two
/// overlap. Where nothing more fits there is less clutter. A Kinect or Xtion looks at the middle from 0.5 to 1.3 m, 20
/// to 65 degrees down, rolled by up to 6 degrees. Materials are mostly diffuse, some dark, some specular. Some scenes
/// have a wall behind or a floor below the table.
///
/// The same seed and options give the same scene. The scene's name has the seed and the clutter level
/// ("random_17_c3").
/// @throws std::invalid_argument for options that cannot be
SceneFile random_scene(std::uint64_t seed, const RandomSceneOptions& options);

/// Seven scenes of the twelve objects of the paper's Table 1, as in its section 4.4: the first five show five graspable
/// parts each, the others nine and ten.
std::vector<SceneFile> paper_scenes();

/// Each of the twelve objects alone, in four orientations at three positions: 144 scenes.
std::vector<SceneFile> single_object_scenes();

/// Clear-the-table scenes (paper, Table 2): five objects of these families, each at most once, drawn and placed at
/// random, at least 30 mm apart, with what one holds them by on the camera's side. The same arguments give the same
/// scenes. @throws std::invalid_argument for fewer than five families, one named twice or
/// unknown, a negative count, or families of which no five find room
std::vector<SceneFile> clear_table_scenes(const std::vector<std::string>& families, std::uint64_t seed, int count);

}  // namespace handhold::sensor
