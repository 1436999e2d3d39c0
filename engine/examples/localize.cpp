// Finds what can be held in a frame, in C++. The frame is made up: a rod before the sensor. With CMake:
//   find_package(handhold REQUIRED)
//   target_link_libraries(your_program PRIVATE handhold::handhold)
// Without: g++ -std=c++17 localize.cpp $(pkg-config --cflags --libs handhold)
#include <handhold/localizer.h>

#include <cmath>
#include <cstdio>
#include <vector>

int main() {
  std::vector<float> points;  // x, y, z in metres; the sensor stands in the origin and looks along z
  for (int row = 0; row < 150; ++row) {
    for (int column = -35; column <= 35; ++column) {
      const double angle = 0.04 * column;
      points.push_back(static_cast<float>(0.025 * std::sin(angle)));
      points.push_back(static_cast<float>(0.002 * row - 0.15));
      points.push_back(static_cast<float>(0.7 - 0.025 * std::cos(angle)));
    }
  }
  handhold::CloudView cloud;
  cloud.data = points.data();
  cloud.width = static_cast<std::uint32_t>(points.size() / 3);

  handhold::Options options;
  options.hand_aperture = 0.1;             // m
  handhold::Localizer localizer(options);  // once; throws OptionError on a bad option
  handhold::Result result;                 // once; its memory is used again
  localizer.localize(cloud, result);       // for each frame
  std::printf("status %s\n", handhold::to_string(result.status).data());
  for (const handhold::Handle& h : result.handles) {
    std::printf("handle at %.3f %.3f %.3f m, axis %.2f %.2f %.2f, radius %.3f m, confidence %.2f\n", h.center[0],
                h.center[1], h.center[2], h.axis[0], h.axis[1], h.axis[2], h.radius, h.confidence);
  }
  return result.handles.empty() ? 1 : 0;
}
