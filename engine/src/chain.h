// Curved handles - of a mug, a jug, a pot - come out as straight pieces: end to end, one thick, each turned a little
// from the last. Here they become one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "handhold/result.h"
#include "recycled.h"
#include "vec3.h"

namespace handhold {

class ChainSearch {
 public:
  /// Joins handles (best confidence first) whose ends meet at an angle. What is joined has a `path`: the middle of it
  /// is the handle's center, its tangent there the axis. Order and all others stay. `spares` get what is left over.
  void join_curved(std::vector<Handle>& handles, Spares<Handle>& spares);

  /// Pieces in a row: their handles' numbers, and the line through them.
  struct Chain {
    std::vector<std::size_t> pieces;
    std::vector<Vector3> path;
    double radius = 0;
    bool taken = false;

    Vector3 end(int k) const { return k == 0 ? path.front() : path.back(); }
    /// Unit, along the path and out of that end.
    Vector3 out(int k) const {
      const std::size_t n = path.size();
      return k == 0 ? normalized(path[0] - path[1]) : normalized(path[n - 1] - path[n - 2]);
    }
  };

 private:
  void make_one(const Chain& chain, std::vector<Handle>& handles);

  Recycled<Chain> chains_;
  std::vector<std::uint32_t> members_, more_;
  std::vector<char> gone_;
};

}  // namespace handhold
