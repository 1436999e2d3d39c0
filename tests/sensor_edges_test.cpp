// What the sensor does where one surface ends before another: shadows of the projector, outlines that jitter, mixed
// pixels. The scene is a board before a wall, so that all can be computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "handhold/sensor.h"
#include "sensor_test_helpers.h"

namespace handhold::sensor {
namespace {

constexpr double kNear = 0.8, kFar = 1.2;  // m
constexpr double kHalf = 0.1;              // m; half the board's edge
constexpr int kBoard = 1;                  // index of the board

Scene board_before_wall() {
  Scene scene = wall(kFar);
  scene.add({"board", box(2 * kHalf, 2 * kHalf, 0.0002), {}}, translation(0, 0, kNear + 0.0001));
  return scene;
}

/// Columns (px) of the board's left and right edge, rows of its upper and lower one.
struct Outline {
  double left, right, top, bottom;
};
Outline outline(const CameraOptions& o) {
  return {o.cx - o.fx * kHalf / kNear, o.cx + o.fx * kHalf / kNear, o.cy - o.fy * kHalf / kNear,
          o.cy + o.fy * kHalf / kNear};
}

// ---- Shadows --------------------------------------------------------------------------------------------------------

TEST(Shadow, LiesLeftOfTheBoardAndIsAsWideAsTheBaselineMakesIt) {
  CameraOptions options;
  options.noise.shadows = true;
  const Outline board = outline(options);
  // What the projector sees past the board's left edge begins so many pixels beside it.
  const double width = options.fx * options.noise.baseline * (1 / kNear - 1 / kFar);
  ASSERT_NEAR(width, 17.97, 0.01);
  // The same from any place.
  for (const Pose& T : {Pose{}, translation(0.3, -2, 1) * rotation({1, 2, 3}, 1.1)}) {
    Scene scene;
    for (const Object& object : board_before_wall().objects) scene.add(object, T);
    const Frame frame = DepthCamera(options).capture(scene, T);
    for (std::uint32_t v = 0; v < options.height; ++v) {
      const bool beside = v > board.top + 1 && v < board.bottom - 1;
      if (!beside && v > board.top - 1 && v < board.bottom + 1) continue;
      for (std::uint32_t u = 0; u < options.width; ++u) {
        // The outline itself goes through these pixels.
        if (std::abs(u - board.left) < 0.6 || std::abs(u - (board.left - width)) < 0.6) continue;
        const bool shadow = beside && u < board.left && u > board.left - width;
        ASSERT_EQ(measured(frame.cloud, v * options.width + u), !shadow) << u << " " << v;
      }
    }
  }
}

TEST(Shadow, SidesThatFaceAwayFromTheProjectorAreDark) {
  // The camera sees the left side of this box, the projector stands behind that side's plane.
  Scene scene;
  scene.add({"box", box(0.2, 0.2, 0.2), {}}, translation(0.04 + 0.1, 0, 0.6));
  CameraOptions options;
  const Frame bare = DepthCamera(options).capture(scene, Pose{});
  options.noise.shadows = true;
  const Frame lit = DepthCamera(options).capture(scene, Pose{});
  int side = 0, front = 0;
  for (std::size_t i = 0; i < bare.cloud.size(); ++i) {
    if (!measured(bare.cloud, i)) continue;
    const double z = bare.cloud.xyz[3 * i + 2];
    if (z > 0.501) {
      ASSERT_FALSE(measured(lit.cloud, i)) << "pixel " << i;
      ++side;
    } else if (z < 0.5001) {
      ASSERT_TRUE(same_bytes(bare.cloud, lit.cloud, i)) << "pixel " << i;
      ++front;
    }
  }
  EXPECT_GT(side, 500);
  EXPECT_GT(front, 10000);
}

// ---- Lateral noise --------------------------------------------------------------------------------------------------

TEST(LateralNoise, SpreadIsAsPublished) {
  const NoiseOptions noise = CameraOptions::kinect().noise;
  EXPECT_NEAR(noise.lateral(0), 0.8, 1e-12);
  EXPECT_NEAR(noise.lateral(0.7853981633974483), 0.8 + 0.035, 1e-12);
  EXPECT_NEAR(noise.lateral(1.0471975511965976), 0.8 + 0.07, 1e-12);
  EXPECT_TRUE(std::isfinite(noise.lateral(1.5707963267948966)));
}

TEST(LateralNoise, OutlinesJitterByItsSpreadAndSurfacesStay) {
  // A board over everything with x < 0 (or y < 0), seen through a slot across its outline.
  constexpr double kSigma = 1.5;
  constexpr int kLength = 400, kBins = 13, kShots = 40;
  for (const bool rows : {false, true}) {
    Scene scene = wall(kFar);
    scene.add({"board", box(rows ? 4 : 2, rows ? 2 : 4, 0.0002), {}},
              translation(rows ? 0 : -1, rows ? -1 : 0, kNear + 0.0001));
    for (const double correlation : {0.0, 3.0}) {
      // By distance from the outline (px): how many pixels see the board, and how many ought to.
      std::vector<double> seen(kBins), expected(kBins), n(kBins);
      int between = 0, moved = 0;
      for (int shot = 0; shot < kShots; ++shot) {
        CameraOptions options;
        options.width = rows ? kLength : 40;
        options.height = rows ? 40 : kLength;
        options.cx = options.width / 2.0 + (rows ? 0 : 0.1 * shot);  // the outline at all places within a pixel
        options.cy = options.height / 2.0 + (rows ? 0.1 * shot : 0);
        const Cloud bare = DepthCamera(options).capture(scene, Pose{}).cloud;
        options.noise.lateral_sigma = kSigma;
        options.noise.correlation_u = options.noise.correlation_v = correlation;
        options.seed = 10 + shot;
        const Frame frame = DepthCamera(options).capture(scene, Pose{});
        for (std::size_t i = 0; i < bare.size(); ++i) {
          const double outside = rows ? static_cast<double>(i / options.width) - options.cy
                                      : static_cast<double>(i % options.width) - options.cx;
          between += std::abs(frame.cloud.xyz[3 * i + 2] - (frame.object[i] == kBoard ? kNear : kFar)) > 1e-6;
          moved += std::abs(outside) > 7 * kSigma && !same_bytes(bare, frame.cloud, i);
          const int bin = static_cast<int>(std::floor(outside + kBins / 2.0));
          if (bin < 0 || bin >= kBins) continue;
          seen[bin] += frame.object[i] == kBoard;
          expected[bin] += 0.5 * std::erfc(outside / kSigma / std::sqrt(2.0));
          ++n[bin];
        }
      }
      EXPECT_EQ(between, 0) << "a depth that is neither the board's nor the wall's";
      EXPECT_EQ(moved, 0) << "far from the outline";
      for (int bin = 0; bin < kBins; ++bin) {
        const double share = expected[bin] / n[bin];
        // Neighbours along the outline that draw alike count as fewer.
        const double independent = n[bin] / std::max(1.0, correlation * 1.77);
        EXPECT_NEAR(seen[bin] / n[bin], share, 5 * std::sqrt((share * (1 - share) + 1e-5) / independent))
            << "bin " << bin << ", correlation " << correlation << (rows ? ", rows" : ", columns");
      }
    }
  }
}

TEST(LateralNoise, BordersOfShadowsJitterToo) {
  CameraOptions options;
  options.noise.shadows = true;
  const Cloud sharp = DepthCamera(options).capture(board_before_wall(), Pose{}).cloud;
  options.noise.lateral_sigma = 1.5;
  const Cloud jittered = DepthCamera(options).capture(board_before_wall(), Pose{}).cloud;
  const Outline board = outline(options);
  const double border = board.left - options.fx * options.noise.baseline * (1 / kNear - 1 / kFar);
  int lost = 0, gained = 0;
  for (std::uint32_t v = 0; v < options.height; ++v) {
    if (v < board.top + 12 || v > board.bottom - 12) continue;
    for (std::uint32_t u = 0; u < board.left - 8; ++u) {  // short of the outline
      const std::size_t i = v * options.width + u;
      if (std::abs(u - border) > 8) {
        ASSERT_TRUE(same_bytes(sharp, jittered, i)) << u << " " << v;
      }
      lost += measured(sharp, i) && !measured(jittered, i);
      gained += !measured(sharp, i) && measured(jittered, i);
    }
  }
  // On average 0.4 sigma on either side.
  const double rows = board.bottom - board.top - 24;
  EXPECT_NEAR(lost, 0.4 * 1.5 * rows, 5 * std::sqrt(rows));
  EXPECT_NEAR(gained, 0.4 * 1.5 * rows, 5 * std::sqrt(rows));
}

// ---- Mixed pixels ---------------------------------------------------------------------------------------------------

TEST(MixedPixels, OnlyBesideEdgesInTheGivenShares) {
  CameraOptions options;
  const Frame bare = DepthCamera(options).capture(board_before_wall(), Pose{});
  options.noise.edge_dropout = 0.2;
  options.noise.mixed = 0.3;
  double edges = 0, lost = 0, mixed = 0, sum = 0, sum2 = 0;
  for (options.seed = 1; options.seed <= 8; ++options.seed) {
    const Frame frame = DepthCamera(options).capture(board_before_wall(), Pose{});
    for (std::size_t v = 0; v < 480; ++v) {
      for (std::size_t u = 0; u < 640; ++u) {
        const std::size_t i = v * 640 + u;
        const auto other = [&](std::size_t k) { return bare.object[k] != bare.object[i]; };
        const bool edge = (u > 0 && other(i - 1)) || (u < 639 && other(i + 1)) || (v > 0 && other(i - 640)) ||
                          (v < 479 && other(i + 640));
        if (!edge) {
          ASSERT_TRUE(same_bytes(bare.cloud, frame.cloud, i)) << u << " " << v;
          continue;
        }
        ++edges;
        if (!measured(frame.cloud, i)) {
          ++lost;
        } else if (!same_bytes(bare.cloud, frame.cloud, i)) {
          const double between = (frame.cloud.xyz[3 * i + 2] - kNear) / (kFar - kNear);
          ASSERT_GT(between, 0);
          ASSERT_LT(between, 1);
          EXPECT_EQ(frame.object[i] == kBoard, between < 0.5) << "the nearer of the two surfaces";
          ++mixed;
          sum += between;
          sum2 += between * between;
        }
      }
    }
  }
  EXPECT_NEAR(lost / edges, 0.2, 5 * std::sqrt(0.2 * 0.8 / edges));
  EXPECT_NEAR(mixed / edges, 0.3, 5 * std::sqrt(0.3 * 0.7 / edges));
  EXPECT_NEAR(sum / mixed, 0.5, 5 * std::sqrt(1 / 12.0 / mixed));
  EXPECT_NEAR(sum2 / mixed, 1 / 3.0, 5 * std::sqrt(4 / 45.0 / mixed));
}

TEST(MixedPixels, SteepSurfacesAndCreasesAreNoEdges) {
  // Two boards that meet in a ridge towards the camera, 1 m away, each seen at 65 degrees; and one seen at 80.
  Scene ridge, steep;
  ridge.add({"left", box(2, 2, 0.001), {}}, rotation({0, 1, 0}, 1.134) * translation(-1, 0, 0.0005));
  ridge.add({"right", box(2, 2, 0.001), {}}, rotation({0, 1, 0}, -1.134) * translation(1, 0, 0.0005));
  steep.add({"board", box(2, 2, 0.001), {}}, rotation({0, 1, 0}, 1.396));
  CameraOptions options;
  options.noise.edge_dropout = options.noise.mixed = 0.5;
  const auto unchanged = [&](const Scene& scene, std::size_t from, std::size_t to) {
    const Pose T_world_camera = translation(0, 0, -1.0);
    const Frame bare = DepthCamera(CameraOptions{}).capture(scene, T_world_camera);
    const Frame frame = DepthCamera(options).capture(scene, T_world_camera);
    std::size_t n = 0;
    for (std::size_t v = 0; v < 480; ++v) {
      for (std::size_t u = from; u < to; ++u) {
        const std::size_t i = v * 640 + u;
        n += measured(bare.cloud, i) && same_bytes(bare.cloud, frame.cloud, i);
      }
    }
    return n;
  };
  EXPECT_EQ(unchanged(ridge, 250, 390), 480u * 140);
  options.noise.lateral_sigma = 0.8;
  EXPECT_EQ(unchanged(steep, 300, 340), 480u * 40);
}

TEST(MixedPixels, NothingIsMixedWithWhatCannotBeMeasured) {
  CameraOptions options;
  options.noise.mixed = 1;
  // Beside empty space.
  Scene alone = board_before_wall();
  alone.objects.erase(alone.objects.begin());
  EXPECT_TRUE(
      same_bytes(DepthCamera().capture(alone, Pose{}).cloud, DepthCamera(options).capture(alone, Pose{}).cloud));
  // Beside the shadow, which is all along the board's left edge.
  options.noise.shadows = true;
  const Frame frame = DepthCamera(options).capture(board_before_wall(), Pose{});
  const Outline board = outline(options);
  int left = 0, right = 0;
  for (std::uint32_t v = 0; v < options.height; ++v) {
    if (v < board.top + 2 || v > board.bottom - 2) continue;
    for (std::uint32_t u = 0; u < options.width; ++u) {
      const double z = frame.cloud.xyz[3 * (v * options.width + u) + 2];
      const bool mixed = z > kNear + 1e-4 && z < kFar - 1e-4;
      left += mixed && u < options.cx;
      right += mixed && u > options.cx;
    }
  }
  EXPECT_EQ(left, 0);
  EXPECT_GT(right, 100);
}

}  // namespace
}  // namespace handhold::sensor
