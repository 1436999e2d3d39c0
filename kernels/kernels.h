// The border of the kernels: plain pointers and sizes in, plain numbers out. No allocation, no threads, no printing.
//
// One table of functions per instruction set; `kernels()` returns the best one that this machine runs, or the one that
// the environment variable HANDHOLD_ISA names. AVX2, AVX-512 and NEON give the same bits (explicit fma, a fixed number
// of partial sums); "scalar" has no fused multiply-add and agrees within rounding.
#pragma once

#include <cstddef>
#include <cstdint>

namespace handhold::kernels {

// ---- Points -------------------------------------------------------------------------------------------------------

inline constexpr int kTilePoints = 16;  ///< points of a tile
inline constexpr int kBlockTiles = 16;  ///< tiles of a block
inline constexpr float kFar = 1e18f;    ///< coordinate of a missing point: outside every ball and every shell

/// Tiles of 16 points in blocks of 16 tiles. Coordinates are metres in the frame of the cloud.
struct Tiles {
  const float* points;  ///< [tile][3][16]: x16 | y16 | z16, 64-byte aligned; missing points have kFar in x, y and z
  const float* boxes;   ///< [block][6][16]: low x, y, z then high x, y, z of the block's tiles; an empty tile has
                        ///< low = kFar, high = -kFar
  const std::uint16_t* full;  ///< [block]: bit t set when tile t has 16 points
  const float* sums;    ///< [block][10][16]: of each tile the number of points, their mean x, y, z, and their centred
                        ///< second moments xx xy xz yy yz zz (sums, m^2)
  std::int32_t blocks;  ///< number of blocks
};

/// The blocks that a group of neighbourhoods may touch, box by box, padded to a multiple of 16 with empty boxes.
struct Candidates {
  const float* boxes[6];       ///< low x, y, z, high x, y, z: `padded` values each, 64-byte aligned
  const std::uint32_t* block;  ///< [padded] index of the block
  std::int32_t padded;         ///< multiple of 16
};

// ---- Neighbourhoods and moments -----------------------------------------------------------------------------------

inline constexpr int kMoments = 35;  ///< monomials x^i y^j z^k with i + j + k <= 4
inline constexpr int kBatch = 16;    ///< fits that one call solves, one per lane

/// Index of the moment of x^i y^j z^k: by degree, within a degree by falling i, then falling j.
/// 0: 1 | 1-3: x y z | 4-9: xx xy xz yy yz zz | 10-19: xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz | 20-34: xxxx ... zzzz
constexpr int moment_index(int i, int j, int k) {
  const int degree = i + j + k;
  const int base = degree == 0 ? 0 : degree == 1 ? 1 : degree == 2 ? 4 : degree == 3 ? 10 : 20;
  const int a = degree - i;
  return base + a * (a + 1) / 2 + k;
}

/// A list of samples of one group (all near each other), and what comes out for each.
struct NeighbourhoodBatch {
  const float* centre;  ///< [n][3] m
  std::int32_t n;       ///< at most kMaxGroup
  float radius;         ///< m
  float
      flat_rms;  ///< m; a neighbourhood whose points lie within this (rms) of a plane is not summed; 0: none is skipped
  std::int32_t min_points;  ///< a neighbourhood with fewer points is not summed
  float flat_slope = 0;  ///< 1/m; narrow neighbourhoods are flat within less: also within flat_slope times the variance
                         ///< (m^2) of their points along the plane's short side; 0: flat_rms alone decides
};
inline constexpr int kMaxGroup = 64;

/// Moments of one neighbourhood: sums of monomials of ((p - centre) / radius) in a frame whose axes are
/// those of the cloud in another (cyclic) order: the third one is nearest the surface normal.
struct Moments {
  double sum[kMoments];     ///< sum[0] is the number of points
  double R_frame_cloud[9];  ///< row-major: rows are the frame's axes in the cloud's frame
  std::int32_t count;       ///< points in the ball; of a flat one that was skipped, about so many
  std::int32_t skipped;     ///< 1: flat, or fewer than min_points: sums and frame are not valid
};

/// Scratch of the neighbourhood and shell kernels, one per thread, sized by `scratch_bytes(blocks)`, 64-byte aligned.
std::size_t scratch_bytes(std::int32_t blocks);

// ---- Fit ----------------------------------------------------------------------------------------------------------

/// Why a fit ended.
enum FitStatus : std::int32_t { kFitOk = 0, kFitFlat = 1 };

/// kBatch neighbourhoods, one per lane, structure of arrays. Everything is in the scaled frame of Moments: lengths in
/// units of the radius, curvatures in 1/radius; directions in the frame of the moments.
struct alignas(64) FitBatch {
  double moments[kMoments][kBatch];  ///< in; of an unused lane any finite numbers
  // Taubin (paper, eq. 1 and 2): f = c . (x^2, y^2, z^2, xy, yz, xz, x, y, z, 1)
  double coefficients[10][kBatch];  ///< out; normalised so that c^T N c = 1 with N the mean of |grad l|^2
  double lambda[kBatch];            ///< out; smallest generalized eigenvalue: mean squared algebraic residual
  std::int32_t status[kBatch];      ///< out; FitStatus
  // Curvature
  double centre_normal[3][kBatch];  ///< out; unit normal at the sample's foot on the surface, sign as the
                                    ///< gradient; zero in a flat lane
  double axis[3][kBatch];           ///< out; unit direction of least absolute curvature there
  double kappa_major[kBatch];   ///< out; principal curvature of larger absolute value there (signed: divergence of the
                                ///< unit gradient)
  double kappa_minor[kBatch];   ///< out; the other one
  double kappa_median[kBatch];  ///< out; median of the larger absolute curvature over nine points spread over the
                                ///< neighbourhood
  // Circle across `axis` (in; may be overwritten between calls)
  double circle_centre[3][kBatch];  ///< out; point of the circle's axis in the plane through the sample
  double circle_radius[kBatch];     ///< out; infinity where the points lie on a line across the axis
  std::int32_t idle;                ///< in; so many lanes, the last ones, need no result
};

// ---- Shell --------------------------------------------------------------------------------------------------------

struct ShellQuery {
  float centre[3];                ///< m; on the axis, at the height of the sample
  float axis[3];                  ///< unit
  float half_width;               ///< m; points with |axial offset| <= half_width count
  float start_radius;             ///< m; smallest inner radius to try (before the m-th point)
  float max_radius;               ///< m; largest inner radius
  float gap;                      ///< m; width of the gap
  std::int32_t max_gap_points;    ///< k: at most so many points in the open interval (r, r + gap)
  std::int32_t min_inner_points;  ///< m: at least so many points with rho <= r
};

enum ShellStatus : std::int32_t { kShellFound = 0, kShellNoGap = 1, kShellEmpty = 2 };

struct ShellResult {
  std::int32_t status;        ///< kShellEmpty: a gap exists at some radius, but never with enough points within
  float radius;               ///< m; smallest inner radius r that satisfies the conditions
  float free_to;              ///< m; outer radius up to which at most k points lie beyond r, at most max_radius + gap
  std::int32_t inner_points;  ///< points with rho <= radius
  std::int32_t gap_points;    ///< points in (radius, radius + gap)
};

// ---- Cylinder -----------------------------------------------------------------------------------------------------

/// A cylinder in the frame and unit of the points; axis, t1 and t2 are unit vectors at right angles.
struct CylinderQuery {
  float point[3];  ///< of the axis
  float axis[3], t1[3], t2[3];
  float radius;
  float sigma;       ///< > 0; distances beyond two of these weigh less
  float arm;         ///< > 0; tilts are displacements at this distance along the axis
  float skip_above;  ///< > 0: of up to 256 points whose cost is larger, A and b are not wanted and may be left as is
};
/// Sums over the points, with weights w, residuals e = (distance from the axis - radius) / sigma and, for each point,
/// a = sigma * de/d(unknowns), negated: (e1, e2, h e1, h e2, 1).
struct CylinderEquations {
  float A[15];   ///< lower triangle, by rows, of the sum of w a a^T
  float b[5];    ///< sum of w e a
  float cost;    ///< sum of Huber's function: e^2 up to 2, then 4 |e| - 4
  float square;  ///< sum of squared distances from the surface
};

/// Sixteen cylinders, one per lane, each to be fitted to as many points of its own. Structure of arrays, metres; of an
/// unused lane any finite numbers.
struct CylinderTrials {
  static constexpr int kPoints = 32;
  /// Radii that a fit may pass through; a step that lowers the cost by less than this part of it is the last one.
  static constexpr double kSmallest = 0.001, kLargest = 0.2, kLeastGain = 0.03;

  alignas(64) float points[kPoints][3][16];  ///< in; near the origin for the sake of single precision
  float sigma[16];                           ///< in; > 0; distances beyond two of these weigh less
  float towards[3][16];                      ///< in; the direction that turns are measured from, of any length
  float point[3][16], axis[3][16];           ///< in: first guess; out: beside the points' mean, and unit
  float radius[16];                          ///< in and out
  float rms[16];                             ///< out; root mean square distance of the points from the surface
  float least_turn[16], most_turn[16];       ///< out; of the points, as outer_turns defines them; a = `towards`
  float arm;                                 ///< in; > 0; tilts are displacements at this distance along the axis
  std::int32_t steps;                        ///< in; at most so many steps; 0: nothing is changed
};

// ---- Fingers ------------------------------------------------------------------------------------------------------

/// A box of places beside a part, in the homogeneous coordinates of a depth image: column * depth, row * depth, depth
/// (px m, px m, m). Column c, row r and layer l stand at corner + c * out + r * up + l * along.
struct FreeQuery {
  const float* depth;          ///< [height][width] m; infinity: nothing there; 0: unknown
  std::int32_t width, height;  ///< px; at most 2^31 pixels, at least one
  float corner[3], out[3], up[3], along[3];
  std::int32_t columns, rows, layers;
  std::int32_t first;  ///< column to begin with, a multiple of 16
  float tolerance;     ///< m; what was seen counts as behind a place beyond this
};

/// A place of a depth image, sixteen directions, and what counts as a step there.
struct RayQuery {
  const float* depth;                 ///< [height][width] m; infinity: nothing there; 0: unknown
  std::int32_t width, height;         ///< px; at most 2^31 pixels, at least one
  float column, row;                  ///< px; of pixel (i, j) are [i, i + 1) and [j, j + 1)
  float out_column[16], out_row[16];  ///< px; one step in each direction
  float jump;                         ///< m; neighbouring depths of one surface differ by up to this
  std::int32_t most;                  ///< steps
};

/// Sixteen places of a depth image.
struct PlaceQuery {
  const float* depth;          ///< as in RayQuery
  std::int32_t width, height;  ///< px
  float column[16], row[16];   ///< px; of pixel (i, j) are [i, i + 1) and [j, j + 1)
};

/// About an axis: directions across it, at right angles, and how many of the outermost points are wanted.
struct TurnQuery {
  float point[3];  ///< of the axis
  float ahead[3], side[3];
};
inline constexpr int kTurns = 4;

/// A row of pixels of an organized cloud, coordinate by coordinate (m). One row up or down is `stride` floats away, and
/// what is read beyond the picture is NaN: one pixel on each side; up to 16 more behind a row may be anything.
struct PixelRow {
  const float *x, *y, *z;  ///< of the row's first pixel
  std::int32_t width, stride;
  float limit2;  ///< m^2; squared distance up to which two pixels are near each other
};

// ---- Bodies -------------------------------------------------------------------------------------------------------

/// The tiles of a cloud under a tree of boxes: sixteen tiles a block, sixteen blocks a group, sixteen groups a region.
/// Sixteen boxes stand together: low x, y, z, then high x, y, z (m), each sixteen times, 64-byte aligned; an empty one
/// has low = kFar, high = -kFar.
struct TileTree {
  const float* points;        ///< as in Tiles
  const float* tile_boxes;    ///< [block][6][16]; as Tiles::boxes
  const float* block_boxes;   ///< [group][6][16]
  const float* group_boxes;   ///< [region][6][16]
  const float* region_boxes;  ///< [regions / 16][6][16]
  std::int32_t regions;       ///< a multiple of 16, padded with empty ones, below which there need not be anything
};

/// A box in the frame of the cloud. One without width and height is a segment, one without size a point; about those a
/// capsule and a sphere are all that is within a limit larger by their radius.
struct BodyQuery {
  float centre[3];        ///< m; within 1e7
  float R_body_cloud[9];  ///< row-major: rows are the directions of the box's edges
  float half[3];          ///< m; half of the edges' lengths, 0 .. 1e7
  float limit;            ///< m; at most kMostDistance; points at this distance or farther do not count
};
inline constexpr float kMostDistance = 1e15f;

// ---- Alignment ----------------------------------------------------------------------------------------------------

/// Affordances as structure of arrays, `padded` entries each (a multiple of 16; padding has x = NaN).
struct AffordanceArrays {
  const float *x, *y, *z;     ///< m; centres
  const float *ax, *ay, *az;  ///< unit axes
  const float* radius;        ///< m
  std::int32_t padded;
};
struct AlignLimits {
  float max_sin;     ///< d_o: sine of the angle between the axes
  float max_offset;  ///< d_c: m; the larger of the two ways
  float max_radius;  ///< d_r: m
};

// ---- Table --------------------------------------------------------------------------------------------------------

struct Kernels {
  const char* name;  ///< "scalar", "avx2", "avx512", "neon"

  /// Boxes, full mask and sums of one block from its points; points with a coordinate that is not finite, or beyond 1e6
  /// m, are replaced by kFar. points: [16][3][16]; box: [6][16]; sums: [10][16]. Returns the number of points.
  std::int32_t (*finish_block)(float* points, float* box, std::uint16_t* full, float* sums);

  /// Moments of each neighbourhood of a group. `out` holds batch.n entries.
  void (*moments)(const Tiles& tiles, const Candidates& candidates, const NeighbourhoodBatch& batch, void* scratch,
                  Moments* out);

  /// Points of one neighbourhood, for tests and for code that is not in a hurry: writes x, y, z relative to the centre
  /// (unscaled, m), returns their number; capacity: 3 arrays of candidates.padded * 256 + 16 floats.
  std::int32_t (*collect)(const Tiles& tiles, const Candidates& candidates, const float* centre, float radius,
                          void* scratch, float* x, float* y, float* z);

  /// Over the points of one neighbourhood, relative to the centre (m): their number; the sums of x y z; of xx xy xz yy
  /// yz zz.
  void (*second_moments)(const Tiles& tiles, const Candidates& candidates, const float* centre, float radius,
                         float* sums);
  /// Offset (m) of the point nearest to the centre, of those within the radius; false: there is none.
  bool (*nearest)(const Tiles& tiles, const Candidates& candidates, const float* centre, float radius, float* offset);
  /// Whether one of n places (unaligned arrays; 15 floats behind the last one are read and ignored) has a squared
  /// distance below limit2 from `place`.
  bool (*any_nearer)(const float* x, const float* y, const float* z, std::int32_t n, const float* place, float limit2);

  /// Taubin fit: reads moments, writes coefficients, lambda, status (paper, section 3.1).
  void (*taubin)(FitBatch& batch);
  /// Curvature: reads moments, coefficients, status; writes centre_normal, axis and kappa_*.
  void (*curvature)(FitBatch& batch);
  /// Circle across the axis: reads moments and axis; writes circle_* (paper, section 3.2, eq. 3).
  void (*circle)(FitBatch& batch);

  /// Cylindrical shell (paper, section 3.2; closed form instead of the brute-force search).
  void (*shell)(const Tiles& tiles, const Candidates& candidates, const ShellQuery& query, void* scratch,
                ShellResult& result);
  /// The same on radii alone: rho2[n] are squared distances to the axis of the points within the width (m^2), padded to
  /// a multiple of 16 with kFar.
  void (*shell_gap)(const float* rho2, std::int32_t n, const ShellQuery& query, ShellResult& result);

  /// Normal equations of the geometric fit of a cylinder to n points (unaligned arrays; 15 floats behind the last one
  /// are read and ignored).
  void (*cylinder)(const float* x, const float* y, const float* z, std::int32_t n, const CylinderQuery& query,
                   CylinderEquations& equations);

  /// Levenberg and Marquardt's iteration on these equations in each lane; a lane ends by itself.
  void (*try_cylinders)(CylinderTrials& trials);

  /// How many of each column's places (rows * layers) were seen to be empty: in the image, at least 20 mm before the
  /// camera, with a measured depth behind them. free: `columns` numbers, padded to a multiple of
  /// 16; those before `first` stay.
  void (*free_places)(const FreeQuery& query, float* free);

  /// Steps from the place to where its surface ends at a farther one, half of one before the first pixel beyond, in
  /// each of the sixteen directions; -1: it does not, or something nearer or unknown comes first.
  void (*ray_ends)(const RayQuery& query, float* ends);

  /// Mean inverse depth (1/m) of the pixel at each of sixteen places and of its four neighbours; 0: one of them is
  /// unknown or out of the image. Where there is nothing the inverse is 0.
  void (*inverse_depths)(const PlaceQuery& query, float* means);

  /// Of n points (unaligned arrays; 15 floats behind the last one are read and ignored) the kTurns least and largest
  /// turns about the axis, from the outermost on; 3 and -3 where there are not so many. A turn rises with the angle
  /// from `ahead` towards `side`, from -2 to 2: with c = a / (|a| + |b|) it is 1 - c, with the sign of b.
  void (*outer_turns)(const float* x, const float* y, const float* z, std::int32_t n, const TurnQuery& query,
                      float* least, float* most);

  /// How many of its eight neighbours are near to each pixel of a row; 0 for a pixel with NaN. counts: `width` numbers,
  /// padded to a multiple of 16.
  void (*near_pixels)(const PixelRow& row, float* counts);

  /// Whether a point is nearer to a body than its limit; distances are negative inside it.
  bool (*any_point_within)(const TileTree& tree, const BodyQuery& query);
  /// The point nearest to a body, or deepest inside it, as 16 * tile + place in the tile; -1: none is within the limit.
  std::int64_t (*nearest_to_body)(const TileTree& tree, const BodyQuery& query);

  /// Row i of the alignment relation (paper, section 3.3): bit j of `row` ((padded + 31) / 32 words) is set when i and
  /// j are aligned both ways. Bit i itself is set. Returns the number of bits.
  std::int32_t (*align)(const AffordanceArrays& arrays, std::int32_t i, const AlignLimits& limits, std::uint32_t* row);
};

/// The table in use. The first call decides; later changes of HANDHOLD_ISA have no effect.
/// Returns the best table also when HANDHOLD_ISA names one that is unknown or not supported here: see `isa_error`.
const Kernels& kernels();
/// The table of that name when it is compiled in and this machine runs it, otherwise null.
const Kernels* kernels(const char* name);
/// Names of all tables that this machine runs, best first; `count` gets their number.
const char* const* available(int* count);
/// Null, or one line that says why HANDHOLD_ISA could not be honoured.
const char* isa_error();

}  // namespace handhold::kernels
