// OpenNI2's recordings (.oni), as small ones as its player takes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sample_files.h"

namespace handhold::test {

struct OniRecording {
  std::vector<DepthImage> frames;  ///< all of one size; one at least
  double h_fov = 0, v_fov = 0;     ///< rad; 0: not recorded
  bool mirrored = false;           ///< what the file says about its frames
  bool depth = true;               ///< otherwise its only stream is infrared
  bool tenths = false;             ///< values are of 0.1 mm
  std::size_t announced = 0;       ///< number of frames that the file claims to have; 0: the true one
};

std::string oni_file(const OniRecording& recording);

}  // namespace handhold::test
