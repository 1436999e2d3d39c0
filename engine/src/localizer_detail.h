// The steps of the localizer on samples that the caller chooses: for tests and benchmarks.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "conditions.h"
#include "device_frame.h"
#include "handhold/cloud.h"
#include "handhold/localizer.h"
#include "handhold/options.h"
#include "handhold/result.h"
#include "part_check.h"
#include "search.h"

namespace handhold {

/// Runs lines 3 to 15 of Algorithm 1 on the given samples (m, cloud frame) instead of drawn ones. steps[i]: where
/// sample i ended; result.affordances[j].sample is an index into `samples`. `device`: searches there, by the paper's
/// method; otherwise on the CPU, whatever Options::backend says.
void localize_samples(const Options& options, const CloudView& cloud, const std::vector<std::array<float, 3>>& samples,
                      Result& result, std::vector<Step>& steps, std::unique_ptr<DeviceFrame> device = nullptr);

/// What users of a localizer do not see.
struct LocalizerInside {
  /// A localizer with some of the default method's conditions off. @throws OptionError as Localizer
  static Localizer make(const Options& options, const Conditions& conditions);
  /// One that searches on this device, whatever Options::backend says. @throws OptionError as Localizer
  static Localizer on_device(const Options& options, std::unique_ptr<DeviceFrame> frame);
  /// What the last search left behind.
  /// Parts that may be handles, with what was measured about them, best first; empty with the paper's method.
  static const Recycled<PartCandidate>& candidates(const Localizer& localizer);
};

}  // namespace handhold
