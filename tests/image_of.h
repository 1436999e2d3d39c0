// What a depth camera at the origin saw, for tests that look at the image itself.
#pragma once

#include <gtest/gtest.h>

#include "depth_image.h"
#include "test_clouds.h"

namespace handhold::test {

/// Points row by row (m).
inline DepthImage image_of(const FloatPoints& points, int width, int height) {
  CloudView view;
  view.data = points.data()->data();
  view.width = static_cast<std::uint32_t>(width), view.height = static_cast<std::uint32_t>(height);
  view.viewpoint = Vector3{0, 0, 0};
  DepthImage image;
  EXPECT_TRUE(image.build(view));
  return image;
}

}  // namespace handhold::test
