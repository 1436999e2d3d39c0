// Where a part ends and the next one on the same axis begins: the neck of a bottle, its cap, the ferrule of a brush.
#pragma once

#include <cstddef>
#include <vector>

namespace handhold {

/// What was measured within one slice across an axis.
struct ProfileSlice {
  double weight = 0;  ///< 1/m^2; how sure `radius` is: points over variance; 0: nothing measured
  double radius = 0;  ///< m; mean distance of the points from the axis
};

/// Slices [first, last) that are of one piece.
struct ProfilePiece {
  std::size_t first, last;
};

/// Five times the log of some thirty slices, for a piece's three unknowns and for the choice among all places where it
/// may begin.
inline constexpr double kPiecePenalty = 16;

/// Cuts a profile of slices of `width` (m) where its radius jumps. Between two cuts it may be any line of a moderate
/// slope, or several that meet: the cheapest explanation by pieces of lines, found by dynamic programming; neighbours
/// that meet to within the noise and `least_jump` (m) stay together, and what is steeper than a cone that a hand could
/// hold belongs to nobody. `penalty`: what another piece must gain, in units of the variance. Appends the pieces in
/// order. `scratch` is reused.
struct ProfileScratch {
  std::vector<double> cost, sums;
  std::vector<std::size_t> from;
  std::vector<ProfilePiece> pieces;
};
void cut_profile(const std::vector<ProfileSlice>& slices, double width, double least_jump, double penalty,
                 ProfileScratch& scratch, std::vector<ProfilePiece>& pieces);

}  // namespace handhold
