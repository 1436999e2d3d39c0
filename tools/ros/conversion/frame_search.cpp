#include "frame_search.h"

#include "motion.h"

namespace handhold::ros_bridge {

FrameSearch::FrameSearch(const Settings& settings)
    : track_(settings.track), seed_(settings.options.seed), localizer_(settings.options) {}

void FrameSearch::take(const PointCloudMessage& message, const FramePlace& place) {
  place_ = place;
  const std::optional<Motion>& T = place_.T_workspace_cloud;
  cloud_ = reader_.read(message, T ? &*T : nullptr);
  cloud_.viewpoint = place_.viewpoint;
  if (T && cloud_.viewpoint) cloud_.viewpoint = moved(*T, *cloud_.viewpoint);
}

void FrameSearch::search() {
  guesses_.clear();
  if (track_) {
    // Other random numbers in each frame: what one overlooks another one finds. Alone, a cloud always gives the same.
    localizer_.set_seed(seed_ + searched_++);
    tracker_.guesses(guesses_, place_.T_now_last);
    if (place_.T_workspace_cloud) {
      for (Vector3& place : guesses_) place = moved(*place_.T_workspace_cloud, place);
    }
  }
  localizer_.localize(cloud_, result_, guesses_);
  if (place_.T_workspace_cloud) move(result_, inverse(*place_.T_workspace_cloud));
  if (track_) tracker_.update(result_.handles, place_.T_now_last);
}

void FrameSearch::begin_anew() {
  tracker_ = Tracker();
}

}  // namespace handhold::ros_bridge
