// Depth frames from OpenNI2.
#include "openni2_source.h"

#include <OpenNI.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include "handhold/io.h"
#include "interrupt.h"
#include "oni_structure.h"
#include "usage_error.h"

namespace handhold::stream {
namespace {

namespace oni = openni;

/// A recording hands over a frame as soon as it is asked for one. Asked again before it did, it might hand over two, of
/// which OpenNI2 keeps one: so the wait is long.
constexpr int kRecordingWaitMs = 1000;
constexpr int kDeviceWaitMs = 100;
/// No frame for so long: none will come, from a device that hangs or a file that is damaged.
constexpr int kSilenceMs = 5000;

/// OpenNI2's last message in one line, in brackets; nothing when it has none.
std::string reason() {
  std::string text = oni::OpenNI::getExtendedError();
  for (char& c : text) {
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
  }
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string::npos) return "";
  return " (OpenNI2 says: " + text.substr(begin, text.find_last_not_of(' ') - begin + 1) + ")";
}

/// OpenNI2 while it lives.
class Library {
 public:
  Library() {
    be_quiet();
    if (oni::OpenNI::initialize() != oni::STATUS_OK) throw std::runtime_error("OpenNI2 does not start" + reason());
    be_quiet();  // OpenNI.ini may have said otherwise
  }
  ~Library() { oni::OpenNI::shutdown(); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

 private:
  static void be_quiet() {
    oni::OpenNI::setLogConsoleOutput(false);
    oni::OpenNI::setLogFileOutput(false);
  }
};

/// What OpenNI2 tells about one device, from threads of its own.
class Events : private oni::OpenNI::DeviceStateChangedListener, private oni::OpenNI::DeviceDisconnectedListener {
 public:
  explicit Events(std::string uri) : uri_(std::move(uri)) {
    oni::OpenNI::addDeviceStateChangedListener(this);
    oni::OpenNI::addDeviceDisconnectedListener(this);
  }
  ~Events() override {
    oni::OpenNI::removeDeviceStateChangedListener(this);
    oni::OpenNI::removeDeviceDisconnectedListener(this);
  }
  Events(const Events&) = delete;
  Events& operator=(const Events&) = delete;

  bool at_end() const { return at_end_; }
  bool unplugged() const { return unplugged_; }

 private:
  void onDeviceStateChanged(const oni::DeviceInfo* device, oni::DeviceState state) override {
    if (device->getUri() == uri_ && state == oni::DEVICE_STATE_EOF) at_end_ = true;
  }
  void onDeviceDisconnected(const oni::DeviceInfo* device) override {
    if (device->getUri() == uri_) unplugged_ = true;
  }

  std::string uri_;
  std::atomic<bool> at_end_{false}, unplugged_{false};
};

/// A device that is open, and its depth.
struct Session {
  Library library;  ///< first: it outlives the others
  oni::Device device;
  oni::VideoStream depth;
};

/// OpenNI2's player of recordings stays, stopped, until the program ends: its thread looks at the list of streams
/// without a lock while they are removed, and when it starts only after it was told to end, it runs on in memory that
/// is gone.
struct CloseSession {
  void operator()(Session* session) const {
    const bool recording = session->device.isValid() && session->device.isFile();
    session->depth.stop();
    if (!recording) delete session;
  }
};

/// The frame's pixels as they would be without a mirror, and the camera that belongs to them.
Cloud cloud_of(const oni::VideoFrameRef& frame, double h_fov, double v_fov, bool mirrored, double unit_m) {
  const int width = frame.getWidth(), height = frame.getHeight();
  const double full_width = frame.getVideoMode().getResolutionX(), full_height = frame.getVideoMode().getResolutionY();
  Intrinsics k;
  k.fx = full_width / 2 / std::tan(h_fov / 2);
  k.fy = full_height / 2 / std::tan(v_fov / 2);
  const int left = frame.getCropOriginX();
  k.cx = (full_width - 1) / 2 - (mirrored ? full_width - width - left : left);
  k.cy = (full_height - 1) / 2 - frame.getCropOriginY();
  std::vector<std::uint16_t> values(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int v = 0; v < height; ++v) {
    const char* row = static_cast<const char*>(frame.getData()) + std::ptrdiff_t{v} * frame.getStrideInBytes();
    std::uint16_t* out = values.data() + std::ptrdiff_t{v} * width;
    std::memcpy(out, row, 2 * static_cast<std::size_t>(width));
    if (mirrored) std::reverse(out, out + width);
  }
  return cloud_of_depth(values, static_cast<std::uint32_t>(width), k, unit_m);
}

class OpenNi2Source : public FrameSource {
 public:
  /// `uri`: what OpenNI2 opens, null: any device. `name`: what the user calls it.
  OpenNi2Source(const char* uri, const std::string& name, const std::optional<OniStructure>& recording)
      : recording_(recording), session_(new Session), name_(name) {
    oni::Device& device = session_->device;
    if (device.open(uri) != oni::STATUS_OK) throw std::runtime_error(why_not_opened(uri));
    live_ = !recording;
    if (live_ && device.isFile()) throw UsageError("'" + name_ + "' is a recording; give its path alone");
    const std::string opened = device.getDeviceInfo().getUri();
    if (name_.empty()) name_ = opened;
    events_ = std::make_unique<Events>(opened);
    if (!device.getSensorInfo(oni::SENSOR_DEPTH)) {
      throw std::runtime_error("'" + name_ + "' has no depth stream; one is needed");
    }
    if (depth_.create(device, oni::SENSOR_DEPTH) != oni::STATUS_OK) {
      throw std::runtime_error("the depth stream of '" + name_ + "' cannot be opened" + reason());
    }
    if (live_) {
      depth_.setMirroringEnabled(false);  // where it cannot, cloud_of() turns its frames back
    } else {
      play_on_demand(device);
    }
    check_camera();
    if (depth_.start() != oni::STATUS_OK) {
      throw std::runtime_error("the depth stream of '" + name_ + "' does not start" + reason());
    }
  }

  std::optional<Frame> next() override {
    if (size_ && received_ == *size_) return std::nullopt;
    if (recording_ && !recording_->complete && received_ == recording_->depth_frames) {
      throw std::runtime_error(why_silent());
    }
    if (!wait()) return std::nullopt;
    oni::VideoFrameRef frame;
    if (depth_.readFrame(&frame) != oni::STATUS_OK || !frame.isValid()) {
      throw std::runtime_error("'" + name_ + "' gives no frame" + reason());
    }
    ++received_;
    Frame result;
    result.source = name_;
    const std::int64_t bytes = std::int64_t{frame.getStrideInBytes()} * frame.getHeight();
    if (frame.getDataSize() < bytes) {
      result.problem = "frame " + std::to_string(frame.getFrameIndex()) + " of '" + name_ +
                       "' is damaged: " + std::to_string(frame.getDataSize()) + " bytes instead of " +
                       std::to_string(bytes);
    } else {
      result.cloud = cloud_of(frame, depth_.getHorizontalFieldOfView(), depth_.getVerticalFieldOfView(),
                              depth_.getMirroringEnabled(), unit_m(frame.getVideoMode().getPixelFormat()));
    }
    return result;
  }
  std::optional<std::size_t> size() const override { return size_; }
  bool live() const override { return live_; }

 private:
  std::string why_not_opened(const char* uri) const {
    const std::string why = reason();
    if (recording_) return "the recording '" + name_ + "' cannot be opened" + why + "; it is truncated or damaged";
    if (uri) return "the device '" + name_ + "' cannot be opened" + why + "; is it connected?";
    oni::Array<oni::DeviceInfo> devices;
    oni::OpenNI::enumerateDevices(&devices);
    if (devices.getSize() == 0) return "OpenNI2 finds no device; connect one, or give a recording (.oni)";
    return "the device '" + std::string(devices[0].getUri()) + "' cannot be opened" + why;
  }

  /// Each frame when it is asked for, and each once.
  void play_on_demand(oni::Device& device) {
    oni::PlaybackControl* playback = device.getPlaybackControl();
    if (!playback || playback->setRepeatEnabled(false) != oni::STATUS_OK || playback->setSpeed(-1) != oni::STATUS_OK) {
      throw std::runtime_error("'" + name_ + "' cannot be played" + reason());
    }
    const int frames = playback->getNumberOfFrames(depth_);
    if (frames == 0) throw std::runtime_error("the recording '" + name_ + "' holds no depth frame");
    // A recorder that was killed left -1.
    if (frames >= 0) size_ = static_cast<std::size_t>(frames);
  }

  void check_camera() const {
    unit_m(depth_.getVideoMode().getPixelFormat());
    for (const float fov : {depth_.getHorizontalFieldOfView(), depth_.getVerticalFieldOfView()}) {
      if (fov > 0 && fov < 3.1f) continue;
      throw std::runtime_error("the depth stream of '" + name_ + "' has no field of view; its camera is unknown");
    }
  }

  double unit_m(oni::PixelFormat format) const {
    if (format == oni::PIXEL_FORMAT_DEPTH_1_MM) return 1e-3;
    if (format == oni::PIXEL_FORMAT_DEPTH_100_UM) return 1e-4;
    throw std::runtime_error("the depth stream of '" + name_ + "' has pixel format " + std::to_string(format) +
                             "; steps of 1 mm or 100 um are needed");
  }

  /// Until there is a frame to read. False: there are no more, or the user interrupts.
  bool wait() {
    const int wait_ms = live_ ? kDeviceWaitMs : kRecordingWaitMs;
    for (int waited_ms = 0; waited_ms < kSilenceMs && !interrupted; waited_ms += wait_ms) {
      // Asked before the last look, as a recording may end with a frame that still waits.
      const bool last_look = events_->at_end() || events_->unplugged();
      oni::VideoStream* stream = &depth_;
      int index = 0;
      const oni::Status status = oni::OpenNI::waitForAnyStream(&stream, 1, &index, last_look ? 0 : wait_ms);
      if (status == oni::STATUS_OK) return true;
      if (last_look || status != oni::STATUS_TIME_OUT) break;
    }
    if (interrupted || (events_->at_end() && !size_)) return false;
    throw std::runtime_error(why_silent());
  }

  std::string why_silent() const {
    const std::string frames = std::to_string(received_);
    if (events_->unplugged()) return "the device '" + name_ + "' was unplugged after " + frames + " frames";
    if (live_) return "the device '" + name_ + "' delivers no more frames after " + frames;
    return "the recording '" + name_ + "' breaks off after " + frames +
           (size_ ? " of " + std::to_string(*size_) : std::string()) + " frames; it is truncated or damaged";
  }

  std::optional<OniStructure> recording_;  ///< none: a device
  std::unique_ptr<Session, CloseSession> session_;
  oni::VideoStream& depth_ = session_->depth;
  std::unique_ptr<Events> events_;
  std::string name_;
  std::optional<std::size_t> size_;
  std::size_t received_ = 0;
  bool live_ = false;
};

}  // namespace

std::unique_ptr<FrameSource> open_recording(const std::string& path) {
  const OniStructure structure = check_oni(path);
  if (path.size() >= ONI_MAX_STR) {
    throw std::runtime_error("the path '" + path + "' is too long for OpenNI2; " + std::to_string(ONI_MAX_STR - 1) +
                             " bytes at most");
  }
  return std::make_unique<OpenNi2Source>(path.c_str(), path, structure);
}

std::unique_ptr<FrameSource> open_device(const std::string& uri) {
  return std::make_unique<OpenNi2Source>(uri.empty() ? oni::ANY_DEVICE : uri.c_str(), uri, std::nullopt);
}

}  // namespace handhold::stream
