// Uses the installed library as a stranger does: finds a rod that stands free before the sensor.
#include <handhold/localizer.h>

#include <cmath>
#include <cstdio>

int main() {
  constexpr double kRadius = 0.025, kStep = 0.002;
  handhold::Cloud cloud;
  for (double y = -0.15; y <= 0.15; y += kStep) {
    for (double angle = -1.4; angle <= 1.4; angle += kStep / kRadius) {
      cloud.xyz.insert(cloud.xyz.end(), {static_cast<float>(kRadius * std::sin(angle)), static_cast<float>(y),
                                         static_cast<float>(0.7 - kRadius * std::cos(angle))});
    }
  }
  cloud.width = static_cast<std::uint32_t>(cloud.xyz.size() / 3);

  handhold::Localizer localizer;
  const handhold::Result result = localizer.localize(cloud.view());
  std::printf("%s: %zu handles with the %s kernels\n", handhold::to_string(result.status).data(), result.handles.size(),
              handhold::Localizer::isa());
  if (result.status != handhold::Status::kOk || result.handles.empty()) return 1;
  const handhold::Handle& rod = result.handles.front();
  return std::abs(rod.axis[1]) > 0.98 && std::abs(rod.radius - kRadius) < 0.005 ? 0 : 1;
}
