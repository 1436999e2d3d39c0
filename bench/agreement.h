// Whether two ways found the same affordances for the same samples.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "baseline/baseline.h"

namespace handhold::bench {

/// What still counts as the same affordance.
struct Tolerance {
  double axis = 0.0175;    ///< rad; 1 degree
  double center = 0.001;   ///< m
  double radius = 0.001;   ///< m; of the circle
  double shell = 0.00105;  ///< m; the baseline's shell radius may be later by one step of 1 mm, and rounding
};

struct Agreement {
  std::size_t samples = 0;
  std::size_t same_outcome = 0;                ///< samples that ended at the same step
  std::size_t either = 0;                      ///< samples with an affordance by at least one of the two
  std::size_t same = 0;                        ///< of these: the same affordance by both, within the tolerance
  std::size_t same_shell = 0;                  ///< of these: the same shell radius, up to the baseline's step
  std::map<std::string, std::size_t> reasons;  ///< why the others differ, and how many
  /// Samples by outcome: [baseline][engine].
  std::array<std::array<std::size_t, baseline::kOutcomes>, baseline::kOutcomes> outcomes{};

  /// Share of `same` in `either`; 1 when nobody found anything.
  double share() const { return either ? static_cast<double>(same) / static_cast<double>(either) : 1.0; }
};

/// Both lists hold one entry a sample, in the same order.
Agreement compare(const std::vector<baseline::SampleResult>& engine, const std::vector<baseline::SampleResult>& classic,
                  const Tolerance& tolerance = {});

}  // namespace handhold::bench
