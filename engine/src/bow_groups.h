// Curved thin parts among the affordances.
#pragma once

#include <vector>

#include "bow.h"
#include "budget.h"
#include "depth_image.h"
#include "handhold/result.h"
#include "part_check.h"
#include "recycled.h"

namespace handhold {

/// A group about the middle of each part that bends all along, traced from the best affordances on; `bows` holds what
/// the groups point to. When the budget is spent the rest is left out.
class BowSearch {
 public:
  void run(const std::vector<Affordance>& affordances, const DepthImage& image, Recycled<PartGroup>& groups,
           Recycled<Bow>& bows, const Budget& budget = {});

 private:
  std::vector<std::uint32_t> thin_;
  std::vector<char> taken_;
  std::vector<double> widths_;
  BowScratch scratch_;
  Bow bow_;
};

/// Whether a straight piece is of a curved handle: near its path and along it, and about as thick.
bool of_bow(const Handle& bow, const Handle& piece);

}  // namespace handhold
