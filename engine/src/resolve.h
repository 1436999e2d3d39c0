// Which of several explanations of one place stays.
#pragma once

#include <vector>

#include "part_check.h"
#include "recycled.h"

namespace handhold {

/// Of parts on the same place the likeliest one stays, of sure ones the longest; pieces of one part become one.
class Resolver {
 public:
  /// `all`: the candidates, in any order, which is lost. `continue_parts`: also pieces on one line that clutter or
  /// noise parts. `kept`: what stays, best first.
  void run(std::vector<const PartCandidate*>& all, bool continue_parts, Recycled<PartCandidate>& kept);

 private:
  void add_members(const Handle& from, Handle& to);
  void extend(PartCandidate& first, const PartCandidate& second);
  bool takes(PartCandidate& g, const PartCandidate& h);

  bool continue_parts_ = true;
  std::vector<const PartCandidate*> likely_;  ///< parts that may lie between pieces, and that none grows over
  std::vector<std::uint32_t> members_;
};

}  // namespace handhold
