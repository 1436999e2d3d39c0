// Switches for the default method's conditions, to measure what each is worth. Not public: there is no reason to turn
// one off but to see what happens.
#pragma once

#include <optional>

namespace handhold {

/// As it stands: the method as it is delivered.
struct Conditions {
  bool fill_shadows = true;    ///< missing pixels that a projector's shadow explains get the farther depth
  bool pass_flat = true;       ///< no samples where the depth image shows at once that the surface is flat or hollow
  bool fill_void = true;       ///< large regions without measurements at the image's border are empty
  bool seen_empty = true;      ///< places that were not seen count against a finger
  bool other_angles = true;    ///< approach angles beside the sensor's
  bool refine = true;          ///< a neighbourhood's cylinder is fitted to the distances of its points
  bool least_arc = true;       ///< points over at least 70 degrees
  bool convex = true;          ///< the sensor sees the outside
  bool ends = true;            ///< no affordance where the surface that is seen goes on beside it on one side
  bool straps = true;          ///< thin parts are also found by their outline
  bool bows = true;            ///< thin parts are followed around their bends
  bool outline = true;         ///< evidence from where a part ends beside its axis; off: what right ones usually show
  bool refit = true;           ///< a group is fitted again to all points there
  bool filter_normals = true;  ///< points whose normal is another surface's are left out of that fit
  bool cut_profile = true;     ///< a line is cut where its radius jumps
  bool continue_parts = true;  ///< pieces of one part on one line become one
  bool join_curved = true;     ///< pieces that meet at an angle become one
  /// Evidence for the confidence that replaces what was measured; a fixed normal error (rad) also meets its limit.
  std::optional<double> normal_error, corner_gain;
};

}  // namespace handhold
