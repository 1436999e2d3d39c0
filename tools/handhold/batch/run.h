// Works through the clouds of a batch.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "handhold/options.h"
#include "work_list.h"

namespace handhold::batch {

/// What became of a cloud.
struct Outcome {
  enum Kind {
    kNotReached,  ///< the batch was interrupted before
    kDone,
    kKept,  ///< its result was there
    kFailed,
  };
  Kind kind = kNotReached;
  std::string problem;  ///< of a cloud that failed: one line
  std::size_t points = 0, handles = 0, affordances = 0;
  double read_ms = 0, localize_ms = 0;
};

/// Reads, searches and writes several clouds at a time, each on one thread: `threads` in all, 0: all of them. At most a
/// few more clouds than threads are in memory. `draw()` gives the number of the next cloud, or one beyond the last; it
/// is called by one thread at a time. `skip(i)`: the result is there. `ended(i, outcome)` is called in the order in
/// which the numbers were drawn, one at a time, of all that were reached. Ends early when `*stop` becomes true; what
/// was begun is finished.
/// @throws std::runtime_error when a result cannot be written; what was begun by then is finished
void run(const std::vector<Work>& work, const Options& options, int threads, const std::atomic<bool>& stop,
         const std::function<std::size_t()>& draw, const std::function<bool(std::size_t)>& skip,
         const std::function<void(std::size_t, const Outcome&)>& ended);

}  // namespace handhold::batch
