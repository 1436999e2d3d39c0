// Algorithm 1 of the paper: from a cloud to handles.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "handhold/cloud.h"
#include "handhold/options.h"
#include "handhold/result.h"

namespace handhold {

/// Finds the graspable parts of a cloud. Holds the options and scratch memory that is reused from frame to frame.
///
/// One localizer serves one frame at a time (calls must not overlap); several localizers may run at once. Work runs in
/// the TBB arena of the caller, or in an arena of Options::threads. The same cloud, options and seed give the same
/// result for any number of threads (times excepted). Nothing is printed.
class Localizer {
 public:
  /// @throws OptionError for an option that is out of range, and for Backend::kCuda where frames cannot run on a GPU:
  /// what() says why. With Backend::kAuto they run on the CPU then. DeviceError where a GPU has too little memory.
  explicit Localizer(const Options& options = {});
  ~Localizer();
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;

  /// Searches a cloud. A cloud in which nothing can be found is no error: Result::status says why.
  /// @throws std::invalid_argument for a view that contradicts itself (null data, bad point_step); DeviceError where a
  ///         GPU fails
  Result localize(const CloudView& cloud);
  /// The same into a result that is reused.
  void localize(const CloudView& cloud, Result& result);
  /// The same where handles are expected at `guesses` (m, in the cloud's frame; Tracker::guesses): half of the first
  /// round's samples are drawn about them. The other half is drawn as ever, so that new handles are found. Without
  /// guesses it is what the others do.
  void localize(const CloudView& cloud, Result& result, const std::vector<Vector3>& guesses);

  /// Seed of the frames from the next one on, instead of Options::seed: in a stream each frame may draw other samples.
  void set_seed(std::uint64_t seed);

  /// Ends the frame in progress, from another thread: it returns soon, with Status::kCancelled and nothing found. Does
  /// nothing when none is in progress.
  void cancel() noexcept;

  /// The samples of the last frame and where each ended, in the order in which they were drawn; Affordance::sample is
  /// an index into them. Empty before the first frame and for one that was not searched. Made on demand.
  std::vector<Sample> samples() const;

  const Options& options() const;
  /// What frames run on: Backend::kCpu or Backend::kCuda, whichever the constructor chose.
  Backend backend() const;
  /// With Backend::kAuto, why frames run on the CPU: one line. Otherwise empty.
  const std::string& backend_reason() const;
  /// Instruction set of the kernels in use: "scalar", "avx2", "avx512" or "neon".
  static const char* isa();

 private:
  friend struct LocalizerInside;  // what tests and benchmarks see of a search
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handhold
