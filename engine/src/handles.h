// Handles from affordances (paper, section 3.3).
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "aligned.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "kernels.h"
#include "recycled.h"

namespace handhold {

/// When affordances are aligned.
kernels::AlignLimits align_limits(const Options& options);

/// Groups aligned affordances into handles: one part, one handle.
class HandleSearch {
 public:
  explicit HandleSearch(const Options& options) : options_(&options) {}

  /// Fills `handles`, best confidence first, and the part of the funnel that concerns affordances.
  /// `spares`: what they are made from; what `handles` held before goes there.
  /// `aligned`: with how many each affordance is aligned, when that is known: as kernels::FoundShell::aligned.
  void run(const std::vector<Affordance>& affordances, Spares<Handle>& spares, std::vector<Handle>& handles,
           Funnel& funnel, const std::vector<std::uint32_t>* aligned = nullptr);

 private:
  struct Line {
    Vector3 point, axis;
    double radius;
  };
  void find_copies(const std::vector<Affordance>& affordances);
  void load(const std::vector<Affordance>& affordances);
  void count_aligned(std::size_t n);
  std::uint32_t row(std::size_t i, std::uint32_t* bits) const;
  Line fit_line();
  void find_far(const Line& line);
  bool grow(std::size_t seed, Line& line);

  const Options* options_;
  AlignedArray<float> arrays_[7];
  std::vector<double> columns_[7];      ///< of all affordances: center x y z (m), axis x y z, radius (m)
  std::vector<double> far_;             ///< not above 0: of the part of the line in question
  std::vector<std::uint32_t> aligned_;  ///< number of affordances aligned with each
  std::vector<std::uint64_t> order_;  ///< affordances, and before them the complement of how many each is aligned with
  std::vector<std::uint32_t> first_same_;  ///< the first affordance of the same place and axis
  std::vector<std::uint32_t> bits_;
  std::vector<std::uint32_t> members_;
  std::vector<std::uint8_t> taken_;  ///< in a handle, or on its part
  std::vector<std::uint8_t> spent_;  ///< in a run that was too short: no seed any more
  std::vector<std::uint8_t> fate_;   ///< of each affordance
  std::vector<double> radii_;
  std::vector<std::pair<double, std::uint32_t>> run_;  ///< place along a line, affordance
  tbb::enumerable_thread_specific<std::vector<std::uint32_t>> row_bits_;
  std::int32_t padded_ = 0;
};

}  // namespace handhold
