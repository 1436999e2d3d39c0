// The least time that a frame's search can take on a device: what has to be moved and computed, over what the device
// moves and computes in a second.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "kernels.h"

namespace handhold::bench {

/// Arithmetic of one lane. One of `simple` is an addition, a product, a fused one or a comparison.
struct Operations {
  double simple = 0;
  double slow = 0;  ///< divisions and square roots
  /// A division or root is a first guess and its Newton steps: about so many simple ones.
  static constexpr double kSlow = 8;
  double all() const { return simple + kSlow * slow; }
};

/// What is done to a point that is summed (single precision): offset, height over the rough plane, 34 sums. Counted by
/// running kernels/moment_sums.h on numbers that count.
Operations operations_of_point();
/// What is done to a block that a ball touches (single precision), all its sixteen tiles: add_block_sums, by hand.
Operations operations_of_block();
/// A neighbourhood's fit (double precision), in the mean over these: counted by running kernels/taubin.h, and
/// kernels/curvature.h with kernels/circle.h, on numbers that count.
struct FitOperations {
  Operations quadric, circle;
};
FitOperations operations_of_fit(const std::vector<std::array<double, kernels::kMoments>>& moments);

/// What a search of samples has to look at.
struct Looked {
  std::uint64_t summed = 0;                                    ///< neighbourhoods that are not flat
  std::uint64_t points = 0;                                    ///< in their balls
  std::uint64_t touched = 0;                                   ///< blocks whose box a ball touches, over all samples
  std::uint64_t blocks = 0;                                    ///< of the cloud, and
  std::uint64_t finite = 0;                                    ///< its points
  std::vector<std::array<double, kernels::kMoments>> moments;  ///< of some of the summed ones
};
/// By the CPU's kernels.
Looked look(const Options& options, const CloudView& cloud, const std::vector<Sample>& samples);

/// Bytes up to the device, back from it, and to and from its memory; operations by precision.
struct Work {
  double up = 0, down = 0, memory = 0, fp32 = 0, fp64 = 0;
};
/// Bytes a second, and operations a second, of a device.
struct Rates {
  double up = 0, down = 0, memory = 0, fp32 = 0, fp64 = 0;
};
struct Floor {
  double seconds = 0;
  std::string by;  ///< which of the rates it is
};
/// All of them at once: the slowest counts.
Floor floor_of(const Work& work, const Rates& rates);

struct FrameSizes {
  double points = 0;  ///< of the cloud, whatever they are
  bool organized = true;
  double key_bytes = 4;  ///< of an unorganized cloud's keys
  double samples = 0, candidates = 0, found = 0;
};
/// Of each stage, in the order of CudaFrame::Stage.
inline constexpr std::size_t kStages = 10;
std::array<Work, kStages> work_of_stages(const FrameSizes& sizes, const Looked& looked);
/// Of a whole frame, in which nothing is read twice.
Work work_of_frame(const FrameSizes& sizes, const Looked& looked, bool upload);
/// The formulas of both, a line each.
const std::vector<std::string>& formulas();

}  // namespace handhold::bench
