// What the sensor saw: projections, shadows, the void, and what is known of a place.
#include "depth_image.h"

#include <gtest/gtest.h>

#include <cmath>

#include "handhold/cloud.h"
#include "test_clouds.h"

namespace handhold {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Seen = DepthImage::Seen;
using test::FloatPoints;
using test::kNan;
using test::Random;

constexpr int kWidth = 160, kHeight = 120;
constexpr double kFocal = 150;

Vector3d ray(double u, double v) {
  return {(u - 79.5) / kFocal, (v - 59.5) / kFocal, 1};
}

/// A board at 0.5 m in the middle, 40 pixels wide, before a wall at 1 m.
FloatPoints board_and_wall() {
  FloatPoints points;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) points.push_back(((u >= 60 && u < 100 ? 0.5 : 1.0) * ray(u, v)).cast<float>());
  return points;
}

/// The cloud and how it came to stand where it stands.
struct Placed {
  FloatPoints points;
  Matrix3d R = Matrix3d::Identity();
  Vector3d t = Vector3d::Zero();
  CloudView view(std::uint32_t width) const {
    CloudView v;
    v.data = points.data()->data();
    v.width = width;
    v.height = static_cast<std::uint32_t>(points.size()) / width;
    v.viewpoint = Vector3{t[0], t[1], t[2]};
    return v;
  }
  Vector3 at(double u, double v, double depth) const {
    const Vector3d p = R * (depth * ray(u, v)) + t;
    return {p[0], p[1], p[2]};
  }
};
Placed place(const FloatPoints& points, const Matrix3d& R, const Vector3d& t) {
  return {test::transformed(points, R, t), R, t};
}

void expect_board(const DepthImage& image, const Placed& cloud) {
  EXPECT_EQ(image.look(cloud.at(80, 60, 0.4), 0.003), Seen::kFree);
  EXPECT_EQ(image.look(cloud.at(80, 60, 0.5), 0.003), Seen::kOccupied);
  EXPECT_EQ(image.look(cloud.at(80, 60, 0.7), 0.003), Seen::kUnknown) << "behind the board";
  EXPECT_EQ(image.look(cloud.at(30, 60, 0.7), 0.003), Seen::kFree) << "beside it";
  EXPECT_EQ(image.look(cloud.at(30, 60, 1.2), 0.003), Seen::kUnknown) << "behind the wall";
  EXPECT_EQ(image.look(cloud.at(200, 60, 0.5), 0.003), Seen::kUnknown) << "out of view";
  EXPECT_EQ(image.look(cloud.at(80, 60, -0.5), 0.003), Seen::kUnknown) << "behind the sensor";
}

TEST(DepthImage, FindsTheProjectionInAnyFrame) {
  Random random(401);
  for (int i = 0; i < 5; ++i) {
    const Placed cloud =
        i == 0 ? Placed{board_and_wall()} : place(board_and_wall(), random.rotation(), random.normal3(1));
    DepthImage image;
    ASSERT_TRUE(image.build(cloud.view(kWidth)));
    EXPECT_NEAR(image.focal(), kFocal, 0.5);
    expect_board(image, cloud);
  }
}

TEST(DepthImage, DrawsACloudThatIsNoImage) {
  Random random(402);
  FloatPoints points = board_and_wall();
  random.shuffle(points);
  for (const bool moved : {false, true}) {
    const Placed cloud = moved ? place(points, random.rotation(), random.normal3(1)) : Placed{points};
    DepthImage image;
    ASSERT_TRUE(image.build(cloud.view(static_cast<std::uint32_t>(points.size())))) << "one row";
    expect_board(image, cloud);
    ASSERT_TRUE(image.build(cloud.view(kWidth))) << "an image in name only";
    expect_board(image, cloud);
  }
}

TEST(DepthImage, ShadowsAreSeenThrough) {
  // The projector's shadow of the board on the wall: f b (1 / 0.5 - 1 / 1) = 11 pixels, and a few for the edges.
  FloatPoints points = board_and_wall();
  const auto remove = [&points](int u0, int u1, int v0, int v1) {
    for (int v = v0; v < v1; ++v)
      for (int u = u0; u < u1; ++u) points[static_cast<std::size_t>(v * kWidth + u)].setConstant(kNan);
  };
  remove(48, 60, 0, 60);      // as wide as a shadow
  remove(100, 140, 60, 110);  // too wide
  remove(20, 22, 80, 84);     // speckle
  const Placed cloud{points};
  DepthImage image;
  ASSERT_TRUE(image.build(cloud.view(kWidth)));
  EXPECT_EQ(image.look(cloud.at(55, 30, 0.8), 0.003), Seen::kFree);
  EXPECT_EQ(image.look(cloud.at(120, 90, 0.8), 0.003), Seen::kUnknown);
  EXPECT_EQ(image.look(cloud.at(21, 82, 0.8), 0.003), Seen::kFree);
}

TEST(DepthImage, LargeEmptyBordersAreVoid) {
  FloatPoints points = board_and_wall();
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const bool border = v < 30, hole = u >= 70 && u < 95 && v >= 60 && v < 90;
      if (border || hole) points[static_cast<std::size_t>(v * kWidth + u)].setConstant(kNan);
    }
  const Placed cloud{points};
  DepthImage image;
  ASSERT_TRUE(image.build(cloud.view(kWidth)));
  EXPECT_EQ(image.look(cloud.at(80, 10, 0.8), 0.003), Seen::kFree);
  EXPECT_EQ(image.look(cloud.at(82, 75, 0.4), 0.003), Seen::kUnknown) << "a hole in a surface";
}

TEST(DepthImage, KnowsNothingWithoutAViewpointOrPoints) {
  const Placed cloud{board_and_wall()};
  CloudView view = cloud.view(kWidth);
  view.viewpoint.reset();
  DepthImage image;
  EXPECT_FALSE(image.build(view));
  EXPECT_TRUE(image.empty());
  EXPECT_FALSE(image.build(Placed{FloatPoints(400, {kNan, kNan, kNan})}.view(20)));
  EXPECT_FALSE(image.build(Placed{FloatPoints(400, {0, 0, 0})}.view(20))) << "all at the viewpoint";
  EXPECT_FALSE(image.build(CloudView{}));
}

}  // namespace
}  // namespace handhold
