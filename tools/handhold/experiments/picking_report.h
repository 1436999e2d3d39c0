// What the experiments with a grasping robot share: flags, attempts as CSV, failures in words and as pictures.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "common.h"
#include "picking.h"
#include "progress.h"
#include "text.h"
#include "threads.h"

namespace handhold::experiments {

/// An attempt with where it belongs.
struct AttemptRecord {
  std::string scene;
  plan::ElectricGripper gripper;
  int number = 1;      ///< in its scene, from 1 on
  std::string object;  ///< family of what was tried; empty: nothing
  Attempt attempt;
};

/// Options of the localizer for a gripper.
Options localizer_options(const plan::ElectricGripper& gripper);

/// "slot 2, hard tips"
std::string gripper_text(const plan::ElectricGripper& gripper);
/// Which gripper was used for which objects, and why.
std::string gripper_reasons(const std::vector<std::pair<std::string, plan::ElectricGripper>>& used);

std::string attempts_csv(const std::vector<AttemptRecord>& records);
/// A sentence for every way in which attempts failed.
std::string failures_text(const std::vector<AttemptRecord>& records);

/// Carries out each of `works`, side by side on so many threads (0: all), and shows how many are done.
/// @param what  one of them: "trial"
template <class Work, class CarryOut>
void carry_out_all(std::vector<Work>& works, int threads, const char* what, CarryOut carry_out) {
  Progress progress;
  std::mutex mutex;
  std::size_t done = 0;
  with_threads(threads, [&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, works.size(), 1), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        carry_out(works[i]);
        const std::lock_guard<std::mutex> lock(mutex);
        progress.show(evaluation::format("%s %zu of %zu", what, ++done, works.size()));
      }
    });
  });
}

/// What the robot saw and meant to do, FOLDER/SCENE_attempt_N.png.
void write_failure(const std::string& folder, const AttemptRecord& record, const Look& look, const plan::Arm& arm);

}  // namespace handhold::experiments
