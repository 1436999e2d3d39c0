#include "frame_source.h"

#include <cctype>
#include <exception>
#include <filesystem>
#include <functional>
#include <utility>
#include <vector>

#include "cloud_list.h"
#include "handhold/io.h"
#include "openni2_source.h"
#include "usage_error.h"

namespace handhold::stream {
namespace {

namespace fs = std::filesystem;

const std::string kDevicePrefix = "openni2:";

/// Files, one a frame.
class Files : public FrameSource {
 public:
  using Read = std::function<Cloud(const std::string& path)>;
  Files(std::vector<fs::path> paths, Read read) : paths_(std::move(paths)), read_(std::move(read)) {}

  std::optional<Frame> next() override {
    if (next_ == paths_.size()) return std::nullopt;
    Frame frame;
    frame.source = paths_[next_++].string();
    try {
      frame.cloud = read_(frame.source);
    } catch (const std::exception& error) {
      frame.problem = error.what();
    }
    return frame;
  }
  std::optional<std::size_t> size() const override { return paths_.size(); }
  bool live() const override { return false; }

 private:
  std::vector<fs::path> paths_;
  Read read_;
  std::size_t next_ = 0;
};

bool is_device(const std::string& source) {
  return source.compare(0, kDevicePrefix.size(), kDevicePrefix) == 0;
}

bool is_recording(const std::string& source) {
  std::string extension = fs::path(source).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  std::error_code ignored;
  return extension == ".oni" && !fs::is_directory(source, ignored);
}

std::unique_ptr<FrameSource> open_files(const std::string& source, const CameraArguments& camera) {
  FrameList list = list_frames(source, camera.any());
  if (!list.depth_images) {
    refuse_camera(camera, "depth images (PNG), and '" + source + "' is of clouds");
    return std::make_unique<Files>(std::move(list.files), read_cloud);
  }
  const DepthCamera k = depth_camera(camera, "'" + source + "' is of depth images (PNG), and");
  return std::make_unique<Files>(std::move(list.files), [k](const std::string& path) {
    return read_depth_png(path, k.intrinsics, k.depth_unit_m);
  });
}

}  // namespace

std::unique_ptr<FrameSource> open_source(const std::string& source, const CameraArguments& camera, bool has_rate) {
  if (!is_device(source) && !is_recording(source)) return open_files(source, camera);
  refuse_camera(camera, "depth images (PNG); '" + source + "' brings its own camera");
  if (!is_device(source)) return open_recording(source);
  if (has_rate) throw UsageError("--rate-hz: the device '" + source + "' delivers at its own rate; leave it out");
  return open_device(source.substr(kDevicePrefix.size()));
}

}  // namespace handhold::stream
