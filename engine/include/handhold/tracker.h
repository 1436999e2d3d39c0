// Handles from frame to frame: which is which, where it is on the mean, when it was last seen.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/options.h"
#include "handhold/result.h"

namespace handhold {

/// A handle that is followed.
struct Track {
  std::uint64_t id = 0;  ///< of this handle alone, as long as the tracker lives; 1, 2, ...
  Handle handle;         ///< place, axis, radius, length and confidence smoothed over the frames, in the last frame's
                         ///< coordinates; the rest as when it was last seen (`affordances`: of that frame)
  Vector3 velocity = {0, 0, 0};  ///< m a frame; of its center, beside the motion that `update` is told
  int age = 0;                   ///< frames in which it was seen
  int unseen = 0;                ///< frames since; 0: it is in the last one
};

/// A rigid motion: p -> R p + t.
struct Motion {
  std::array<double, 9> R = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< rotation by rows
  Vector3 t = {0, 0, 0};                                  ///< m
};

struct TrackerOptions {
  double max_offset = 0.04;  ///< m; a handle that is farther from where a track is expected is another one
  double max_angle = 0.6;    ///< rad; between their axes
  double max_radius = 0.4;   ///< share of the larger radius by which they may differ
  /// 0..1, above 0; of a frame's measurement beside what was expected (the alpha of an alpha-beta filter of constant
  /// velocity; its beta is alpha^2 / (2 - alpha)); 1: no smoothing
  double weight = 0.4;
  int keep = 15;  ///< frames that a handle is kept without being seen, >= 0

  /// @throws OptionError naming the first option that is out of range, its value and what would be valid
  void validate() const;
};

/// Carries handles from frame to frame. Handles go to the nearest tracks (one each); what is left begins tracks. The
/// same frames give the same tracks. One tracker serves one call at a time; it prints nothing.
class Tracker {
 public:
  /// @throws OptionError for an option that is out of range
  explicit Tracker(const TrackerOptions& options = {});

  /// Takes the handles of the next frame, in its coordinates. `T_now_last` brings points of the last frame to this
  /// one's coordinates: for a camera that moves. The tracks in the order of their ids.
  const std::vector<Track>& update(const std::vector<Handle>& handles, const Motion& T_now_last = {});

  const std::vector<Track>& tracks() const { return tracks_; }

  /// Places (m) on the tracks, every 15 mm along them, in the coordinates of the next frame: what
  /// Localizer::localize takes as guesses.
  void guesses(std::vector<Vector3>& places, const Motion& T_next_now = {}) const;

 private:
  struct Pair {
    double cost;  ///< m
    std::size_t track, handle;
  };

  double difference(const Handle& track, const Handle& handle) const;

  TrackerOptions options_;
  std::vector<Track> tracks_;
  std::uint64_t next_id_ = 1;
  std::vector<Pair> pairs_;
  std::vector<char> taken_, ended_;
};

}  // namespace handhold
