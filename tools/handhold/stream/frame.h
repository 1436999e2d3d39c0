// One frame of a stream.
#pragma once

#include <cstddef>
#include <string>

#include "handhold/cloud.h"

namespace handhold::stream {

struct Frame {
  std::size_t number = 0;  ///< of the source, from 0 on
  std::string source;      ///< its file, or the recording or device that it is from
  double time_s = 0;       ///< since the stream began, when it came
  Cloud cloud;
  std::string problem;  ///< why there is no cloud; empty: there is one
};

}  // namespace handhold::stream
