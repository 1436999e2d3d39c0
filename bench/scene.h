// A cloud to measure on, and samples of it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "handhold/cloud.h"

namespace handhold::bench {

/// What a depth camera (fx = fy = 525 px at a width of 640) sees of a table with bottles, bars, a ball and a box, with
/// its noise along the rays; metres, optical frame, NaN where nothing was hit. Always the same bytes.
Cloud make_scene(std::uint32_t width = 640, std::uint32_t height = 480);

/// The cloud in the file `path`; with an empty path that of HANDHOLD_BENCH_CLOUD, of data/table_scene.pcd, or, where
/// there is neither, make_scene(). `name` (may be null) gets a short name for reports.
/// @throws std::runtime_error when `path` cannot be read
Cloud load_scene(const std::string& path, std::string* name = nullptr);

/// `count` of the cloud's finite points, uniformly with repetition; the same for the same seed. Empty when there is no
/// finite point.
std::vector<std::array<float, 3>> draw_samples(const CloudView& cloud, int count, std::uint64_t seed = 1);

/// The middle one, or the mean of the two middle ones; 0 for none.
double median(std::vector<double> values);

}  // namespace handhold::bench
