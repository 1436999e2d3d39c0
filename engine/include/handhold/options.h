// Everything that can be set, with units, ranges and names. One name everywhere: the C++ field, the TOML key, the JSON
// key and, with dashes, the command-line flag.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace handhold {

enum class Method {
  kDefault,  ///< several radii, geometric cylinder fits, two fingers in space that was seen empty
  kPaper,    ///< the paper's conditions, one radius, full shell
};
/// How samples are placed (paper, section 3.4).
enum class Strategy {
  kUniform,  ///< uniformly over the finite points
  kSum,      ///< sequential importance sampling with g_sum
  kMax,      ///< sequential importance sampling with g_max (Algorithm 2)
};
/// Where the axis of a neighbourhood comes from.
enum class AxisEstimator {
  kTaubin,   ///< least curvature of the fitted quadric (paper, section 3.1)
  kNormals,  ///< least eigenvector of the sum of n n^T over the points' normals (the alternative of section 3.1)
  kPca,      ///< direction of largest spread of the points (as the published code does)
};
enum class IndexKind {
  kEmbree,  ///< Embree BVH over blocks of 256 points
  kGrid,    ///< uniform grid over the same blocks
};
/// What frames run on. Localizer::backend() tells which one it became.
enum class Backend {
  kCpu,   ///< the CPU's kernels
  kCuda,  ///< the first NVIDIA GPU; an error where there is none, or where it cannot do what the options ask for
  kAuto,  ///< the GPU where there is one that can do what the options ask for, otherwise the CPU
};

/// Thrown for an option that is out of range; what() names the option, the value and what would be valid.
class OptionError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

struct Options {
  Method method = Method::kDefault;
  // Samples
  int samples = 5000;  ///< neighbourhoods to look at, 1 .. 10,000,000
  Strategy strategy = Strategy::kMax;
  std::uint64_t seed = 1;  ///< same seed, same result
  std::optional<double>
      proposal_sigma;  ///< m; standard deviation of a proposal about an affordance; default: radius / 2
  std::optional<std::array<double, 6>> workspace;  ///< m; xmin xmax ymin ymax zmin zmax: samples come from inside only
  // Neighbourhoods
  std::vector<double> radius;  ///< m; radii of the ball-shaped neighbourhoods; empty: 0.025 for the paper's method,
                               ///< 0.010, 0.015, 0.025 and 0.035 for the default one
  int min_neighbours = 10;     ///< points that a fit needs at least, >= 10
  AxisEstimator axis = AxisEstimator::kTaubin;
  IndexKind index = IndexKind::kEmbree;
  // Hand
  double hand_aperture = 0.08;     ///< m; largest inner distance between the fingers
  double hand_minimum = 0.0;       ///< m; smallest inner distance; 0: the hand closes
  double finger_thickness = 0.01;  ///< m; radial: the gap a shell must have
  double finger_width = 0.02;      ///< m; along the handle: the length of a shell
  double finger_depth = 0.04;   ///< m; along the approach: how far the fingers reach out of the palm (default method)
  double min_free = 0.5;        ///< 0..1; share of each finger's volume that must have been seen empty (default method)
  std::optional<double> reach;  ///< m; largest radius of curvature worth a look; default: 1.25 * hand_aperture / 2
  // Shell (paper's method). Counts of points would depend on distance and resolution, so thresholds are areas times
  // local point density.
  double shell_gap_area_mm2 = 12;     ///< mm^2 of surface that may lie in the gap (sensor noise); 0: not one point
  double shell_inner_area_mm2 = 100;  ///< mm^2 of surface that must lie within the inner cylinder
  // Handles (paper, section 3.3). The default method groups relative to the part's radius: of these it takes the
  // smallest number of affordances and the smallest length.
  double align_angle = 0.35;        ///< rad; axes of aligned affordances differ at most by this (d_o = sin)
  double align_offset = 0.01;       ///< m; their offset across the axis at most (d_c)
  double align_radius = 0.005;      ///< m; their radii differ at most by this (d_r)
  double handle_gap = 0.015;        ///< m; a longer stretch without affordances along the axis ends a handle
  int handle_min_affordances = 3;   ///< aligned affordances that a handle needs, >= 1
  double handle_min_length = 0.02;  ///< m; extent along the axis that a handle needs
  /// 0..1; handles below it are left out; default: 0.8, with the paper's method 0. A hand that closes on nothing is
  /// worse than a part that is passed over.
  std::optional<double> min_confidence;
  // Running
  /// ms, from the call on; then the frame ends with what was found (Status::kDeadline). How much that is depends on the
  /// machine: such a result is not the same again. Default: none
  std::optional<double> deadline_ms;
  Backend backend = Backend::kCpu;  ///< what frames run on; whether a GPU is there turns out when the localizer is made
  int threads = 0;                  ///< 0: the caller's TBB arena as it is; otherwise an arena of that many, or
                                    ///< of as many as tbb::global_control allows when the localizer is made

  /// 0..1; confidence that a handle needs
  double effective_min_confidence() const { return min_confidence.value_or(method == Method::kDefault ? 0.8 : 0); }
  double effective_reach() const { return reach ? *reach : 1.25 * hand_aperture / 2; }  ///< as `reach` (m)
  /// radii of the neighbourhoods (m)
  std::vector<double> effective_radius() const {
    if (!radius.empty()) return radius;
    return method == Method::kPaper ? std::vector<double>{0.025} : std::vector<double>{0.010, 0.015, 0.025, 0.035};
  }
  /// standard deviation of a proposal (m)
  double effective_proposal_sigma() const {
    return proposal_sigma ? *proposal_sigma : radius.empty() ? 0.0125 : radius.front() / 2;
  }

  /// Does not look for a GPU.
  /// @throws OptionError naming the first option that is out of range, its value and what would be valid.
  void validate() const;

  /// Baxter's electric gripper with standard narrow fingers in slot 3 and hard tips: opening 35 .. 76.7 mm; finger and
  /// tip together 14.5 mm thick, tips 16 mm wide, 66 mm from the base's housing to their ends.
  static Options baxter();
};

/// A field of Options for programs that read or print all of them.
struct OptionInfo {
  const char* name;  ///< C++ field, TOML and JSON key; the flag has dashes
  const char* unit;  ///< "m", "rad", "mm^2", "" (a count or a name)
  const char* help;  ///< one line, with the meaning of the extreme value
};

/// Calls visit(field, info) for every field, in the order above. `O` is Options or const Options; `field` has the
/// field's own type (int, double, std::uint64_t, std::optional<double>, std::vector<double>, enum, ...).
template <class O, class Visitor>
void visit_options(O& o, Visitor&& visit) {
  visit(o.method,
        OptionInfo{"method", "", "'paper': the paper's conditions; 'default': several radii, two fingers, visibility"});
  visit(o.samples, OptionInfo{"samples", "", "neighbourhoods to look at (1 to 10000000)"});
  visit(o.strategy, OptionInfo{"strategy", "", "sampling: 'uniform', 'sum' or 'max'"});
  visit(o.seed, OptionInfo{"seed", "", "seed of the random numbers: same seed, same result"});
  visit(o.proposal_sigma,
        OptionInfo{"proposal_sigma", "m",
                   "standard deviation of a new sample about an affordance; default half the first radius"});
  visit(o.workspace,
        OptionInfo{"workspace", "m", "XMIN XMAX YMIN YMAX ZMIN ZMAX: samples come from inside this box only"});
  visit(o.radius, OptionInfo{"radius", "m", "radii of the ball-shaped neighbourhoods; default by method"});
  visit(o.min_neighbours, OptionInfo{"min_neighbours", "", "points that a fit needs at least (10 or more)"});
  visit(o.axis, OptionInfo{"axis", "", "axis from 'taubin', 'normals' or 'pca'"});
  visit(o.index, OptionInfo{"index", "", "neighbour index: 'embree' or 'grid'"});
  visit(o.hand_aperture, OptionInfo{"hand_aperture", "m", "largest inner distance between the fingers"});
  visit(o.hand_minimum,
        OptionInfo{"hand_minimum", "m", "smallest inner distance between the fingers; 0: the hand closes"});
  visit(o.finger_thickness,
        OptionInfo{"finger_thickness", "m", "thickness of a finger: the gap that a shell must have"});
  visit(o.finger_width, OptionInfo{"finger_width", "m", "width of a finger along the handle: the length of a shell"});
  visit(o.finger_depth, OptionInfo{"finger_depth", "m", "how far the fingers reach out of the palm (default method)"});
  visit(o.min_free, OptionInfo{"min_free", "", "0 to 1: share of a finger's volume that must have been seen empty"});
  visit(o.reach,
        OptionInfo{"reach", "m", "largest radius of curvature worth a look; default 1.25 * hand_aperture / 2"});
  visit(o.shell_gap_area_mm2,
        OptionInfo{"shell_gap_area_mm2", "mm^2", "surface that may lie in the gap; 0: not one point"});
  visit(o.shell_inner_area_mm2,
        OptionInfo{"shell_inner_area_mm2", "mm^2", "surface that must lie within the inner cylinder"});
  visit(o.align_angle, OptionInfo{"align_angle", "rad", "axes of aligned affordances differ at most by this"});
  visit(o.align_offset, OptionInfo{"align_offset", "m", "offset of aligned affordances across the axis at most"});
  visit(o.align_radius, OptionInfo{"align_radius", "m", "radii of aligned affordances differ at most by this"});
  visit(o.handle_gap, OptionInfo{"handle_gap", "m", "a longer stretch without affordances ends a handle"});
  visit(o.handle_min_affordances,
        OptionInfo{"handle_min_affordances", "", "aligned affordances that a handle needs (1 or more)"});
  visit(o.handle_min_length, OptionInfo{"handle_min_length", "m", "extent along the axis that a handle needs"});
  visit(o.min_confidence, OptionInfo{"min_confidence", "",
                                     "0 to 1: handles below it are left out; default 0.8, 0 with the paper's method"});
  visit(o.deadline_ms,
        OptionInfo{"deadline_ms", "ms", "the frame ends after so long, with what was found; default: when it is done"});
  visit(o.backend,
        OptionInfo{"backend", "", "what searches: 'cpu', 'cuda' (an NVIDIA GPU), or 'auto': a GPU where there is one"});
  visit(o.threads, OptionInfo{"threads", "", "threads to use; 0: all"});
}

/// Names of enum values, as used in TOML, JSON and flags ("default", "paper", "uniform", ...).
std::string_view to_string(Method);
std::string_view to_string(Strategy);
std::string_view to_string(AxisEstimator);
std::string_view to_string(IndexKind);
std::string_view to_string(Backend);
/// The reverse. @throws OptionError listing the valid names.
void from_string(std::string_view, Method&);
void from_string(std::string_view, Strategy&);
void from_string(std::string_view, AxisEstimator&);
void from_string(std::string_view, IndexKind&);
void from_string(std::string_view, Backend&);

}  // namespace handhold
