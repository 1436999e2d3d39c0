// The outermost of some points about an axis.
#pragma once

#include "kernels.h"
#include "lane.h"

namespace handhold::HANDHOLD_LANE {

/// Puts t into kTurns ascending numbers, the largest of which falls out; in each lane.
LANE_FN void insert_turn(Sum t, Sum* sorted) {
  LANE_UNROLL(8)
  for (int k = 0; k < kernels::kTurns; ++k) {
    const Sum low = min(sorted[k], t);
    t = max(sorted[k], t);
    sorted[k] = low;
  }
}

/// The least of all lanes' numbers, ascending.
LANE_FN void merge_turns(const Sum* sorted, float* least) {
  alignas(64) float lanes[kSumLanes];
  for (int k = 0; k < kernels::kTurns; ++k) least[k] = 3.0f;
  for (int k = 0; k < kernels::kTurns; ++k) {
    sorted[k].store(lanes);
    for (int lane = 0; lane < kSumLanes; ++lane) {
      float t = lanes[lane];
      if (!(t < least[kernels::kTurns - 1])) continue;
      for (int i = 0; i < kernels::kTurns; ++i) {
        const float low = t < least[i] ? t : least[i];
        t = t < least[i] ? least[i] : t;
        least[i] = low;
      }
    }
  }
}

/// kernels::Kernels::outer_turns
LANE_FN void find_outer_turns(const float* px, const float* py, const float* pz, std::int32_t n,
                              const kernels::TurnQuery& q, float* least, float* most) {
  const Sum one(1.0f), zero(0.0f), out(3.0f), small(1e-30f);
  Sum first[kernels::kTurns], last[kernels::kTurns];  // ascending; the last ones negated
  LANE_UNROLL(8)
  for (int k = 0; k < kernels::kTurns; ++k) first[k] = last[k] = out;
  LANE_ROLLED
  for (std::int32_t i = 0; i < n; i += kSumLanes) {
    const auto in = Sum::load(kLaneNumbers) < Sum(static_cast<float>(n - i));
    const Sum x = Sum::loadu(px + i) - Sum(q.point[0]), y = Sum::loadu(py + i) - Sum(q.point[1]);
    const Sum z = Sum::loadu(pz + i) - Sum(q.point[2]);
    const Sum a = Sum(q.ahead[0]) * x + Sum(q.ahead[1]) * y + Sum(q.ahead[2]) * z;
    const Sum b = Sum(q.side[0]) * x + Sum(q.side[1]) * y + Sum(q.side[2]) * z;
    const Sum size = one - a / max(abs(a) + abs(b), small);
    const Sum turn = select(b < zero, -size, size);
    insert_turn(select(in, turn, out), first);
    insert_turn(select(in, -turn, out), last);
  }
  merge_turns(first, least);
  merge_turns(last, most);
  for (int k = 0; k < kernels::kTurns; ++k) most[k] = -most[k];
}

}  // namespace handhold::HANDHOLD_LANE
