// Distances of bodies from points and from each other.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "arm_helpers.h"
#include "body_helpers.h"

namespace handhold::plan {
namespace {

/// Points all over a body's surface, some `step` (m) apart.
std::vector<Vector3d> surface(const Body& body, double step) {
  std::vector<Vector3d> points;
  const Eigen::Matrix3d R = rotation_of(body);
  const Vector3d c = centre_of(body);
  if (body.kind == Kind::kBox) {
    int n[3];
    for (int k = 0; k < 3; ++k) n[k] = 1 + static_cast<int>(body.size[k] / step);
    for (int i = 0; i <= n[0]; ++i)
      for (int j = 0; j <= n[1]; ++j)
        for (int k = 0; k <= n[2]; ++k) {
          if (i % n[0] && j % n[1] && k % n[2]) continue;
          points.push_back(R * Vector3d((double(i) / n[0] - 0.5) * body.size[0],
                                        (double(j) / n[1] - 0.5) * body.size[1],
                                        (double(k) / n[2] - 0.5) * body.size[2]) +
                           c);
        }
    return points;
  }
  const double half = body.kind == Kind::kCapsule ? body.length / 2 : 0;
  const int rings = 4 + static_cast<int>(M_PI * body.radius / step), sides = 2 * rings;
  const int along = 1 + static_cast<int>(2 * half / step);
  const auto add_ring = [&](double r, double z) {
    for (int i = 0; i < sides; ++i) {
      const double a = 2 * M_PI * i / sides;
      points.push_back(R * Vector3d(r * std::cos(a), r * std::sin(a), z) + c);
    }
  };
  for (int i = 0; i <= rings; ++i) {
    const double a = M_PI * i / rings;
    add_ring(body.radius * std::sin(a), body.radius * std::cos(a) + (2 * i < rings ? half : -half));
  }
  for (int i = 0; i <= along; ++i) add_ring(body.radius, (2.0 * i / along - 1) * half);
  return points;
}

Vector3d eigen(const Vector3& v) {
  return {v[0], v[1], v[2]};
}

TEST(BodyPoint, AgreesWithProjection) {
  Random random(501);
  int inside = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const Body body = random_body(random, 0.4, 0.1);
    const Vector3d p = random.normal3(0.15);
    const double d = distance(body, plain(p));
    EXPECT_NEAR(d, plain_distance(body, p), 1e-12);
    inside += d < 0;
  }
  EXPECT_GT(inside, 1000);
}

TEST(BodyPoint, IsTheWayToTheSurface) {
  Random random(502);
  for (int trial = 0; trial < 40; ++trial) {
    const Body body = random_body(random, 0.3, 0.1);
    const double step = 0.01;
    const std::vector<Vector3d> points = surface(body, step);
    for (const Vector3d& s : points) ASSERT_NEAR(distance(body, plain(s)), 0, 1e-12);
    for (int i = 0; i < 10; ++i) {
      const Vector3d p = random.normal3(0.15);
      double nearest = 1e9;
      for (const Vector3d& s : points) nearest = std::min(nearest, (s - p).norm());
      const double d = std::fabs(distance(body, plain(p)));
      EXPECT_LE(d, nearest + 1e-12);
      EXPECT_GE(d, nearest - step);
    }
  }
}

TEST(BodyPoint, KnownPlaces) {
  const Body capsule = capsule_at(sensor::translation(1, 0, 0), 0.1, 0.4);
  EXPECT_DOUBLE_EQ(distance(capsule, {1.3, 0, 0.1}), 0.3 - 0.1);
  EXPECT_DOUBLE_EQ(distance(capsule, {1, 0, 0.5}), 0.2);
  EXPECT_DOUBLE_EQ(distance(capsule, {1, 0, 0}), -0.1);
  const Body box = box_at({}, {0.2, 0.4, 0.6});
  EXPECT_DOUBLE_EQ(distance(box, {0, 0, 0}), -0.1);
  EXPECT_DOUBLE_EQ(distance(box, {0, 0.19, 0.25}), 0.19 - 0.2);
  EXPECT_DOUBLE_EQ(distance(box, {0.4, 0.6, 0.3}), 0.5);
  EXPECT_DOUBLE_EQ(distance(sphere_at({}, 0.5), {0, 3, 4}), 4.5);
}

TEST(BodyBody, LiesBetweenTheBoundsOfAlternatingProjections) {
  Random random(503);
  int apart = 0, together = 0, pairs[3][3] = {};
  for (int trial = 0; trial < 1500; ++trial) {
    const Body a = random_body(random, 0.4, 0.2), b = random_body(random, 0.4, 0.2);
    const double d = distance(a, b);
    const Bounds bounds = bounds_of_distance(a, b, 3000);
    EXPECT_LE(d, bounds.high + 1e-9) << trial;
    EXPECT_GE(d, bounds.low - 1e-9) << trial;
    // Where the projections have come to an end, it is the value.
    if (bounds.high - bounds.low < 1e-7) {
      ++pairs[static_cast<int>(a.kind)][static_cast<int>(b.kind)];
      ++(d > 0 ? apart : together);
    }
  }
  EXPECT_GT(apart, 500);
  EXPECT_GT(together, 100);
  for (const auto& row : pairs)
    for (int n : row) EXPECT_GT(n, 50);
}

TEST(BodyBody, IsAtMostThatOfPointsOfTheSurface) {
  Random random(504);
  for (int trial = 0; trial < 60; ++trial) {
    const Body a = random_body(random, 0.3, 0.15), b = random_body(random, 0.3, 0.15);
    const double step = 0.02, d = distance(a, b);
    double least = 1e9;
    for (const Vector3d& p : surface(a, step)) least = std::min(least, plain_distance(b, p));
    EXPECT_LE(d, std::max(least, 0.0) + 1e-12);
    if (d > 0) {
      EXPECT_GE(d, least - step);
    }
  }
}

TEST(BodyBody, NeitherOrderNorFrameMatters) {
  Random random(505);
  for (int trial = 0; trial < 3000; ++trial) {
    const Body a = random_body(random, 0.4, 0.3), b = random_body(random, 0.4, 0.3);
    const double d = distance(a, b);
    EXPECT_NEAR(distance(b, a), d, 1e-12);
    const Pose T = random_pose(random, 2);
    Body moved_a = a, moved_b = b;
    moved_a.T_base_body = T * a.T_base_body, moved_b.T_base_body = T * b.T_base_body;
    EXPECT_NEAR(distance(moved_a, moved_b), d, 1e-12);
    const Vector3 p = plain(random.normal3(0.3));
    EXPECT_NEAR(distance(moved_a, T.point(p)), distance(a, p), 1e-12);
    // A point is a sphere of no radius.
    EXPECT_NEAR(distance(a, sphere_at(sensor::translation(p[0], p[1], p[2]), 0)), std::max(distance(a, p), 0.0), 1e-12);
  }
}

TEST(BodyBody, GrowsByTheWayOfABodyThatGoesStraightAway) {
  Random random(506);
  for (int trial = 0; trial < 500; ++trial) {
    const Body a = random_body(random, 0.3, 0.2);
    Body b = random_body(random, 0.3, 0.2);
    // Beyond the plane that holds a back: support functions tell how far apart they are along it.
    const Vector3d n = random.direction();
    const double gap = -support(b, -n) - support(a, n), way = random.uniform(0.01, 0.5) - gap;
    b.T_base_body = sensor::translation(way * n[0], way * n[1], way * n[2]) * b.T_base_body;
    EXPECT_GE(distance(a, b), gap + way - 1e-12);
  }
}

TEST(BodyBody, KnownPlaces) {
  using sensor::rotation;
  using sensor::translation;
  const Body box = box_at({}, {0.2, 0.2, 0.2});
  // Face to face, edge to edge (crossing), corner to face, one within the other, crossing without a corner inside.
  EXPECT_NEAR(distance(box, box_at(translation(0.5, 0.05, 0), {0.2, 0.2, 0.2})), 0.3, 1e-15);
  const Pose diamond = rotation({0, 0, 1}, M_PI / 4), tilted = rotation({1, 0, 0}, M_PI / 4);
  const double edge = 0.1 * std::sqrt(2.0);
  EXPECT_NEAR(distance(box_at(rotation({0, 1, 0}, M_PI / 4), {0.2, 0.2, 0.2}),
                       box_at(translation(0, 0, 0.5) * tilted, {0.2, 0.2, 0.2})),
              0.5 - 2 * edge, 1e-15);
  EXPECT_NEAR(distance(box, box_at(translation(0.5, 0, 0) * diamond, {0.2, 0.2, 0.2})), 0.4 - edge, 1e-15);
  EXPECT_EQ(distance(box, box_at(rotation({1, 2, 3}, 1), {0.01, 0.02, 0.03})), 0);
  EXPECT_EQ(distance(box, box_at({}, {1, 0.05, 0.05})), 0);
  EXPECT_EQ(distance(box, box), 0);
  // Parallel, skew and crossing capsules.
  const Body capsule = capsule_at({}, 0.05, 0.6);
  EXPECT_NEAR(distance(capsule, capsule_at(translation(0.3, 0, 0.2), 0.1, 0.4)), 0.15, 1e-15);
  EXPECT_NEAR(distance(capsule, capsule_at(translation(0, 0, 1), 0.1, 0.4)), 0.35, 1e-15);
  EXPECT_NEAR(distance(capsule, capsule_at(translation(0, 0.4, 0) * rotation({0, 1, 0}, 1), 0.1, 0.4)), 0.25, 1e-15);
  EXPECT_EQ(distance(capsule, capsule_at(rotation({0, 1, 0}, 1), 0.001, 0.4)), 0);
  EXPECT_NEAR(distance(sphere_at({}, 0.1), sphere_at(translation(0, 3, 4), 0.2)), 4.7, 1e-15);
  EXPECT_NEAR(distance(box, sphere_at(translation(0.4, 0.5, 0), 0.2)), 0.3, 1e-15);
  EXPECT_NEAR(distance(box, capsule_at(translation(0, 0, 0.3) * rotation({0, 1, 0}, M_PI / 2), 0.05, 2)), 0.15, 1e-15);
}

TEST(BodyBody, WhatSharesAPointTouches) {
  Random random(508);
  for (int trial = 0; trial < 1000; ++trial) {
    // Plates, rods and points without any volume that hold the origin, and the same point somewhere else.
    const Pose T = random_pose(random, 1);
    std::vector<Body> thin = {box_at(sensor::translation(0.1, -0.05, 0), {0.3, 0.2, 0}),
                              box_at(sensor::translation(0, 0.05, 0), {0, 0.2, 0}),
                              capsule_at(sensor::translation(0, 0, 0.1), 0, 0.3), sphere_at({}, 0)};
    for (Body& body : thin) body.T_base_body = T * pose_of(random.rotation(), {0, 0, 0}) * body.T_base_body;
    for (const Body& a : thin)
      for (const Body& b : thin) EXPECT_EQ(distance(a, b), 0);
  }
}

TEST(Placed, StandsOnItsLink) {
  Random random(507);
  Shape shape;
  shape.kind = Kind::kCapsule, shape.radius = 0.1, shape.length = 0.3, shape.T_link_shape = random_pose(random, 1);
  const Pose T_base_link = random_pose(random, 1);
  const Body body = placed(shape, T_base_link);
  EXPECT_EQ(body.kind, Kind::kCapsule);
  EXPECT_EQ(body.radius, 0.1);
  EXPECT_EQ(body.length, 0.3);
  for (int i = 0; i < 10; ++i) {
    const Vector3 p = plain(random.normal3(0.3));
    const Vector3d a = eigen(body.T_base_body.point(p)), b = eigen(T_base_link.point(shape.T_link_shape.point(p)));
    EXPECT_LT((a - b).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace handhold::plan
