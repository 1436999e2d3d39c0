// One cloud after the other: from a message to handles and tracks. The whole of a node's work but for its transport.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "handhold/localizer.h"
#include "handhold/tracker.h"
#include "point_cloud.h"
#include "settings.h"

namespace handhold::ros_bridge {

/// What transforms say of a cloud.
struct FramePlace {
  std::optional<Motion> T_workspace_cloud;              ///< none: the workspace is in the cloud's frame
  std::optional<Vector3> viewpoint = Vector3{0, 0, 0};  ///< m; cloud frame; none: no single viewpoint
  Motion T_now_last;                                    ///< from the last cloud's frame to this one's
};

/// Serves one cloud at a time. Holds the localizer and all memory, which is reused from cloud to cloud.
class FrameSearch {
 public:
  /// @throws OptionError, also where the backend cannot be had
  explicit FrameSearch(const Settings& settings);

  /// Both together are one search; apart so that each can be timed.
  /// @throws MessageError for a message that contradicts itself
  void take(const PointCloudMessage& message, const FramePlace& place);
  void search();

  /// As Localizer's.
  const std::string& backend_reason() const { return localizer_.backend_reason(); }
  /// What was found, in the frame of the cloud.
  const Result& result() const { return result_; }
  const std::vector<Track>& tracks() const { return tracker_.tracks(); }
  /// Forgets all tracks: another camera, or the time went back.
  void begin_anew();

  /// Ends the search in progress, from another thread.
  void cancel() noexcept { localizer_.cancel(); }

 private:
  bool track_;
  std::uint64_t seed_, searched_ = 0;
  PointCloudReader reader_;
  Localizer localizer_;
  Tracker tracker_;
  FramePlace place_;
  CloudView cloud_;
  Result result_;
  std::vector<Vector3> guesses_;
};

}  // namespace handhold::ros_bridge
