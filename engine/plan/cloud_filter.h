// Which points of a cloud are obstacles.
#pragma once

#include <vector>

#include "bodies.h"

namespace handhold::plan {

/// Leaves out specks and a robot's own points, see CloudObstacleOptions. Reuses its memory.
class CloudFilter {
 public:
  /// The cloud, with NaN for what is no obstacle; valid until the next call or until the cloud ends. Runs in the
  /// caller's TBB arena.
  /// @param own  as in the options, but in the frame of the cloud
  CloudView run(const CloudView& cloud, const std::vector<Core>& own, const CloudObstacleOptions& options);

 private:
  void copy(const CloudView& cloud);
  void leave_out_specks(const CloudView& cloud, const CloudObstacleOptions& options);
  void leave_out_own(const std::vector<Core>& own, double margin);

  std::vector<float> coordinates_[3];  ///< of the image with a frame of NaN about it, row by row
  std::vector<float> counts_;          ///< of near neighbours; room for a row in each batch of rows
  std::vector<float> xyz_;             ///< what is left
};

}  // namespace handhold::plan
