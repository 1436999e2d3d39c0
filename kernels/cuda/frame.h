// What the search of one frame on a GPU works on. Plain pointers: into the device's memory, or, where a test goes
// through the same stages on the CPU, into the host's.
#pragma once

#include <cstddef>
#include <cstdint>

#include "candidate.h"
#include "kernels.h"
#include "morton.h"

namespace handhold::kernels {

/// What is asked of the samples, the same from frame to frame but for the sensor's place and the seed.
struct FrameQuery {
  FitLimits fit;
  ShellLimits shell;
  float radius;                ///< m; of the balls
  float flat_rms, flat_slope;  ///< as in NeighbourhoodBatch
  std::int32_t min_points;
  AlignLimits align;
  std::uint32_t first, samples;  ///< of the round: the number of the first, and how many
  std::uint64_t seed, stream;    ///< of uniform draws
  // Of proposals, in all rounds but the first:
  std::uint64_t proposals;    ///< CounterRandom::stream_state
  double sigma;               ///< m
  float snap_radius;          ///< m; a proposal goes to the nearest point within this
  std::int32_t only_nearest;  ///< 1: g_max, 0: g_sum
};

/// A neighbourhood that may be one of a shell.
struct FrameCandidate {
  Place place;
  double position[3];  ///< m; of the sample
  double radius;       ///< m; of the circle
  double curvature;    ///< 1/m; the median
  double density;      ///< points per m^2
  std::uint32_t sample;
};

/// One that is.
struct FoundShell {
  Place place;
  double radius, curvature;     ///< as above
  float shell_radius, free_to;  ///< m; as in ShellResult
  std::uint32_t sample;
  std::uint32_t
      aligned;  ///< with how many it is aligned, itself among them; of the same place and axis the first counts
};

/// Counts of one frame, and of one round of samples.
struct FrameCounts {
  std::uint32_t finite;   ///< points of the cloud
  std::uint32_t found;    ///< shells
  std::uint32_t ordered;  ///< shells whose centres are in place
  std::uint32_t lost;     ///< candidates whose shell found too little scratch memory,
  std::uint32_t wanted;   ///< and what the largest of them wanted (words)
  // Of a round:
  std::uint32_t summed;                ///< neighbourhoods that are not flat
  std::uint32_t candidates;            ///< of these, those with a fit that the hand could hold
  std::uint32_t next_sum, next_shell;  ///< the first that nobody has taken on yet
};

/// Memory of one frame. Structures of arrays have `capacity` entries a row.
struct FrameView {
  // The cloud as it came. An organized one has `order`, an unorganized one `sorted`.
  const float* source;        ///< x of the first point
  std::uint32_t source_step;  ///< floats from one point to the next
  std::uint32_t width, height;
  const std::uint32_t* order;   ///< [blocks] row-major position of the block's 16x16 pixels
  const std::uint32_t* sorted;  ///< [counts->finite ...] points along the Morton curve

  // Its tiles, under a tree of boxes
  float *points, *boxes, *sums;                     ///< as in Tiles
  std::uint16_t* full;                              ///< as in Tiles
  float *block_boxes, *group_boxes, *region_boxes;  ///< as in TileTree
  std::uint16_t* before;                            ///< [block][16] finite points in the block's tiles before
  std::uint32_t* block_points;                      ///< [block] finite points
  std::uint32_t* first_rank;                        ///< [block + 1] finite points in the blocks before
  std::uint32_t blocks, regions;                    ///< regions: a multiple of 16

  // The samples
  std::uint32_t capacity;
  float* position;        ///< [sample][3] m
  std::uint8_t* end;      ///< [sample] End
  std::uint32_t* summed;  ///< [slot] sample; slots are given out as neighbourhoods pass, in no order
  std::uint32_t* listed;  ///< [slot][17] its blocks, up to sixteen, and how many there are
  float* plane;           ///< [3][slot] up, a, b of RoughPlane
  double* total;          ///< [kMoments][slot] number of points, sums over heights (m)
  double* quadric;        ///< [10][slot] coefficients
  FrameCandidate* candidates;
  FoundShell* found;
  double* centres;         ///< [shell][3] m; in the order of their samples: what the next round draws about
  float* shells;           ///< [8][capacity rounded up to 16]: x y z, axis, radius as in AffordanceArrays; x of those
                           ///< that count, NaN of the others
  std::uint32_t* scratch;  ///< [thread block][scratch_words], 64-byte aligned: for shells
  std::uint32_t scratch_words;  ///< a multiple of 16
  FrameCounts* counts;

  HANDHOLD_SHARED float* shell_row(int k) const {
    return shells + static_cast<std::size_t>(k) * ((capacity + 15) / 16 * 16);
  }
  /// The first n shells, for their alignment.
  HANDHOLD_SHARED AffordanceArrays shell_arrays(std::uint32_t n) const {
    return {shell_row(7), shell_row(1), shell_row(2), shell_row(3),
            shell_row(4), shell_row(5), shell_row(6), static_cast<std::int32_t>((n + 15) / 16 * 16)};
  }

  HANDHOLD_SHARED Tiles tiles() const { return {points, boxes, full, sums, static_cast<std::int32_t>(blocks)}; }
};

}  // namespace handhold::kernels
