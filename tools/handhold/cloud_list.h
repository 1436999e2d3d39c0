// The clouds or depth images that a user means: a folder's, or a list's.
#pragma once

#include <filesystem>
#include <vector>

namespace handhold {

struct CloudList {
  std::filesystem::path folder;               ///< the folder, or the list's
  std::vector<std::filesystem::path> clouds;  ///< one at least
};

/// Of a folder all .pcd and .ply files in order of their names, with those of its folders when `recursive`; of a text
/// file those that its lines name, relative to its folder (empty lines and those that begin with # are passed over).
/// @throws UsageError, std::runtime_error: no such source, or nothing in it
CloudList list_clouds(const std::filesystem::path& source, bool recursive);

struct FrameList {
  std::vector<std::filesystem::path> files;  ///< one at least
  bool depth_images = false;                 ///< PNGs, all of them; otherwise none
};

/// As list_clouds() of a folder or a list that may hold PNGs (depth images) instead.
/// PNGs beside clouds in a folder are pictures of something else, unless `images_meant`: the user spoke of depth
/// images.
/// @throws UsageError, std::runtime_error: as above, or there are both
FrameList list_frames(const std::filesystem::path& source, bool images_meant);

}  // namespace handhold
