// Surfaces through rings of vertices.
#pragma once

#include <cstdint>

#include "handhold/sensor.h"

namespace handhold::sensor {

/// Closes the surface through the first `rings` rings of `n` vertices each, one after the other in mesh.vertices: sides
/// between neighbouring rings, fans over the first and the last, which must be convex.
inline void close_rings(Mesh& mesh, std::uint32_t rings, std::uint32_t n) {
  for (std::uint32_t i = 0; i + 1 < rings; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * n + j, b = i * n + (j + 1) % n, c = b + n, d = a + n;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  const std::uint32_t last = (rings - 1) * n;
  for (std::uint32_t j = 1; j + 1 < n; ++j) {
    mesh.triangles.push_back({0, j + 1, j});
    mesh.triangles.push_back({last, last + j, last + j + 1});
  }
}

}  // namespace handhold::sensor
