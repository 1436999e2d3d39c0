// Where frames come from.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "camera_arguments.h"
#include "frame.h"

namespace handhold::stream {

/// Gives one frame after the other. One thread at a time may ask.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// The next frame, without number and time; one that cannot be read says why. None: there are no more, or the user
  /// interrupts. @throws std::runtime_error when the source broke off, so that no more can come
  virtual std::optional<Frame> next() = 0;
  /// How many there are in all; none: nobody knows.
  virtual std::optional<std::size_t> size() const = 0;
  /// It delivers at its own rate and waits for nobody.
  virtual bool live() const = 0;
};

/// Opens what the user named: a folder or a list of clouds or of depth images, a recording (.oni), or a device
/// ("openni2:" or "openni2:URI"). `camera`: of depth images; other sources need none. `has_rate`: the user gave a rate,
/// which a device refuses. @throws UsageError, std::runtime_error: one line that says what is wrong
std::unique_ptr<FrameSource> open_source(const std::string& source, const CameraArguments& camera, bool has_rate);

}  // namespace handhold::stream
