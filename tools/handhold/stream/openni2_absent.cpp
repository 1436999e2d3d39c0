// Without OpenNI2 there are neither recordings nor devices.
#include "openni2_source.h"
#include "usage_error.h"

namespace handhold::stream {
namespace {

[[noreturn]] void refuse(const std::string& source) {
  throw UsageError("'" + source +
                   "' needs OpenNI2, and this program was built without it; install libopenni2-dev and build again, or "
                   "give a folder of depth images");
}

}  // namespace

std::unique_ptr<FrameSource> open_recording(const std::string& path) {
  refuse(path);
}

std::unique_ptr<FrameSource> open_device(const std::string& uri) {
  refuse("openni2:" + uri);
}

}  // namespace handhold::stream
