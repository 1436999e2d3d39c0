// As many threads as the user asks for.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <memory>

namespace handhold {

/// Lets TBB start as many threads as were asked for: more than there are cores it refuses, with a warning on standard
/// error. Holds while the returned object lives.
inline std::unique_ptr<tbb::global_control> allow_threads(int threads) {
  constexpr auto kLimit = tbb::global_control::max_allowed_parallelism;
  const auto wanted = static_cast<std::size_t>(threads);
  if (wanted <= tbb::global_control::active_value(kLimit)) return nullptr;
  return std::make_unique<tbb::global_control>(kLimit, wanted);
}

/// Does `work` in an arena of that many threads; 0: of all.
template <class F>
void with_threads(int threads, F&& work) {
  const auto more_threads = allow_threads(threads);
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute(work);
}

}  // namespace handhold
