// What an arm must keep clear of: Obstacles against plain loops over points and bodies.
#include "handhold/collision.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "arm_helpers.h"
#include "body_helpers.h"
#include "demo_cloud.h"

namespace handhold::plan {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kExact = 1e-5;  // m; what the header promises

Cloud cloud_of(const std::vector<Vector3d>& points, std::uint32_t width = 0) {
  Cloud cloud;
  for (const Vector3d& p : points) {
    for (int k = 0; k < 3; ++k) cloud.xyz.push_back(static_cast<float>(p[k]));
  }
  cloud.width = width ? width : static_cast<std::uint32_t>(points.size());
  cloud.height = width ? static_cast<std::uint32_t>(points.size()) / width : 1;
  return cloud;
}

bool is_finite(const float* p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// The points that are obstacles by the letter of CloudObstacleOptions, in the base's frame.
std::vector<Vector3d> plain_obstacles(const CloudView& cloud, const Pose& T, const CloudObstacleOptions& options) {
  std::vector<Vector3d> points;
  const int width = static_cast<int>(cloud.width), height = static_cast<int>(cloud.height);
  const auto at = [&](int u, int v) { return cloud.point(static_cast<std::size_t>(v) * cloud.width + std::size_t(u)); };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const float* p = at(u, v);
      if (!is_finite(p)) continue;
      int near = 0;
      for (int j = std::max(v - 1, 0); j <= std::min(v + 1, height - 1); ++j) {
        for (int i = std::max(u - 1, 0); i <= std::min(u + 1, width - 1); ++i) {
          if (i == u && j == v) continue;
          const float* q = at(i, j);
          const float dx = q[0] - p[0], dy = q[1] - p[1], dz = q[2] - p[2];
          near += dx * dx + dy * dy + dz * dz <= static_cast<float>(options.speck_distance * options.speck_distance);
        }
      }
      if (cloud.organized() && near < options.speck_neighbours) continue;
      const Vector3 q = T.point({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
      const Vector3d x(q[0], q[1], q[2]);
      const auto is_own = [&](const Body& body) { return plain_distance(body, x) <= options.own_margin; };
      if (std::any_of(options.own.begin(), options.own.end(), is_own)) continue;
      points.push_back(x);
    }
  }
  return points;
}

double plain_nearest(const Body& body, const std::vector<Vector3d>& points) {
  double least = kInfinity;
  for (const Vector3d& p : points) least = std::min(least, plain_distance(body, p));
  return least;
}

/// nearest() and within() of a body that is `truth` away. Known bodies that it overlaps are near whatever the margin.
void expect_distance(const Obstacles& obstacles, const Body& body, double truth, bool overlaps = false) {
  const Obstacles::Nearest nearest = obstacles.nearest(body);
  EXPECT_NEAR(nearest.distance, truth, kExact);
  if (nearest.is_point) {
    EXPECT_NEAR(distance(body, nearest.point), nearest.distance, 1e-12);
  }
  EXPECT_TRUE(obstacles.within(body, truth + kExact));
  EXPECT_EQ(obstacles.nearest(body, truth + kExact).distance, nearest.distance);
  EXPECT_EQ(obstacles.within(body, truth - kExact), overlaps);
  const Obstacles::Nearest limited = obstacles.nearest(body, truth - kExact);
  EXPECT_EQ(limited.distance, truth - kExact);
  EXPECT_FALSE(limited.is_point);
}

// ---- Points ---------------------------------------------------------------------------------------------------------

TEST(CloudObstacles, TableSceneAgreesWithAllPoints) {
  Random random(521);
  const Pose T = sensor::translation(0.7, -0.3, -0.1) * sensor::table_scene_camera();
  CloudObstacleOptions options;
  options.own = {capsule_at(sensor::translation(0.6, -0.4, 0), 0.05, 0.2)};
  const std::vector<Vector3d> points = plain_obstacles(test::demo_cloud().view(), T, options);
  Obstacles obstacles;
  obstacles.set_cloud(test::demo_cloud().view(), T, options);
  EXPECT_EQ(obstacles.points(), points.size());
  // Specks and own points are few.
  Obstacles all;
  all.set_cloud(test::demo_cloud().view(), T, [] {
    CloudObstacleOptions every;
    every.speck_neighbours = 0;
    return every;
  }());
  EXPECT_GT(points.size(), 100'000u);
  EXPECT_LT(points.size(), all.points());
  EXPECT_GT(points.size(), all.points() - all.points() / 10) << all.points();
  for (int trial = 0; trial < 100; ++trial) {
    Body body = random_body(random, 0.3, 0.4);
    const Vector3d at = points[random.index(points.size())] + random.normal3(0.1);
    if (trial % 4) body.T_base_body.t = plain(at);
    expect_distance(obstacles, body, plain_nearest(body, points));
  }
}

TEST(CloudObstacles, RandomCloudsAgreeWithAllPoints) {
  Random random(522);
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<Vector3d> xyz;
    const std::uint32_t width = 10 + static_cast<std::uint32_t>(random.index(60));
    for (std::size_t i = 0; i < 40 * width; ++i) {
      // Rows of a rough surface with gaps and steps, or no order at all.
      const double u = static_cast<double>(i % width), v = static_cast<double>(i / width);
      Vector3d p = trial % 2 ? Vector3d(u * 0.006, v * 0.006, 0.7 + 0.1 * std::floor(u / 9)) + random.normal3(0.002)
                             : random.normal3(0.3);
      if (random.index(10) == 0) p[static_cast<int>(random.index(3))] = random.index(2) ? kInfinity : std::nan("");
      xyz.push_back(p);
    }
    const Cloud cloud = cloud_of(xyz, trial % 4 < 2 ? width : 0);
    CloudObstacleOptions options;
    options.speck_neighbours = static_cast<int>(random.index(9));
    for (int i = 0; i < trial % 3; ++i) options.own.push_back(random_body(random, 0.2, 0.5));
    const Pose T = random_pose(random, 1);
    const std::vector<Vector3d> points = plain_obstacles(cloud.view(), T, options);
    Obstacles obstacles;
    obstacles.set_cloud(cloud.view(), T, options);
    ASSERT_EQ(obstacles.points(), points.size());
    for (int i = 0; i < 20 && !points.empty(); ++i) {
      Body body = random_body(random, 0.3, 1);
      if (i % 4) body.T_base_body.t = plain(points[random.index(points.size())] + random.normal3(0.05));
      expect_distance(obstacles, body, plain_nearest(body, points));
    }
  }
}

TEST(CloudObstacles, PointsFarApartInMemory) {
  std::vector<float> wide;  // x, y, z and five more floats
  for (int i = 0; i < 100; ++i) wide.insert(wide.end(), {0.01f * static_cast<float>(i), 1, 2, 9, 9, 9, 9, 9});
  for (const std::uint32_t width : {100u, 10u}) {
    const CloudView view = {wide.data(), 32, width, 100 / width, {}};
    CloudObstacleOptions options;
    options.own = {sphere_at(sensor::translation(5, 5, 5), 0.1)};
    options.speck_neighbours = 1;
    options.speck_distance = 0.011;
    Obstacles obstacles;
    obstacles.set_cloud(view, {}, options);
    EXPECT_EQ(obstacles.points(), 100u);
    EXPECT_NEAR(obstacles.nearest(sphere_at(sensor::translation(0.5, 1, 4), 0.5)).distance, 1.5, kExact);
  }
}

TEST(CloudObstacles, Specks) {
  // A wall, one pixel far before it, a pair and a bar two pixels wide.
  constexpr std::uint32_t kWidth = 30, kHeight = 20;
  std::vector<Vector3d> xyz;
  for (std::uint32_t v = 0; v < kHeight; ++v) {
    for (std::uint32_t u = 0; u < kWidth; ++u) {
      const bool speck = (u == 5 && v == 5) || (v == 10 && (u == 10 || u == 11)), bar = u == 20 || u == 21;
      xyz.emplace_back(0.003 * u, 0.003 * v, speck || bar ? 0.5 : 1.0);
    }
  }
  const Cloud cloud = cloud_of(xyz, kWidth);
  const Body probe = sphere_at(sensor::translation(0.015, 0.015, 0.4), 0.05),
             at_pair = sphere_at(sensor::translation(0.0315, 0.03, 0.4), 0.05);
  const Body at_bar = sphere_at(sensor::translation(0.0615, 0.03, 0.4), 0.05);
  Obstacles obstacles;
  CloudObstacleOptions options;
  obstacles.set_cloud(cloud.view(), {}, options);
  EXPECT_FALSE(obstacles.within(probe, 0.051));
  EXPECT_TRUE(obstacles.within(at_bar, 0.051));
  EXPECT_FALSE(obstacles.within(at_pair, 0.051));
  const std::size_t without = obstacles.points();
  options.speck_neighbours = 1;
  obstacles.set_cloud(cloud.view(), {}, options);
  EXPECT_FALSE(obstacles.within(probe, 0.051));
  EXPECT_TRUE(obstacles.within(at_pair, 0.051));
  options.speck_neighbours = 0;
  obstacles.set_cloud(cloud.view(), {}, options);
  EXPECT_TRUE(obstacles.within(probe, 0.051));
  EXPECT_EQ(obstacles.points(), kWidth * kHeight);
  EXPECT_LE(without, kWidth * kHeight - 3);
  EXPECT_GE(without, kWidth * kHeight - 7);  // corners of the picture have three neighbours, the bar's ends too
  // Specks are there only where there is a picture.
  Cloud flat = cloud;
  flat.width = kWidth * kHeight, flat.height = 1;
  obstacles.set_cloud(flat.view(), {});
  EXPECT_EQ(obstacles.points(), kWidth * kHeight);
}

TEST(CloudObstacles, OwnPoints) {
  const Cloud cloud = cloud_of({{0, 0, 1}, {0, 0, 1.119}, {0, 0, 1.121}, {0.5, 0, 1}});
  const Pose T = sensor::translation(1, 2, 3);
  CloudObstacleOptions options;
  options.own = {sphere_at(sensor::translation(1, 2, 4), 0.1)};
  Obstacles obstacles;
  obstacles.set_cloud(cloud.view(), T, options);
  EXPECT_EQ(obstacles.points(), 2u);
  EXPECT_NEAR(obstacles.nearest(options.own[0]).distance, 0.021, 1e-6);
  options.own_margin = 0;
  obstacles.set_cloud(cloud.view(), T, options);
  EXPECT_EQ(obstacles.points(), 3u);
}

TEST(CloudObstacles, DegenerateClouds) {
  const Body body = capsule_at(sensor::translation(0, 0, 0.5), 0.1, 0.2);
  Obstacles obstacles;
  const auto expect_nothing = [&] {
    EXPECT_EQ(obstacles.points(), 0u);
    EXPECT_EQ(obstacles.nearest(body).distance, kInfinity);
    EXPECT_FALSE(obstacles.nearest(body).is_point);
    EXPECT_FALSE(obstacles.within(body, kInfinity));
  };
  expect_nothing();
  obstacles.set_cloud(CloudView{}, {});
  expect_nothing();
  Cloud cloud;
  cloud.width = 40, cloud.height = 30;
  cloud.xyz.assign(3 * cloud.size(), kNan);
  obstacles.set_cloud(cloud.view(), {});
  expect_nothing();
  // One point, the same one again and again, a plane.
  obstacles.set_cloud(cloud_of({{0.3, 0, 0.5}}).view(), {});
  EXPECT_EQ(obstacles.points(), 1u);
  expect_distance(obstacles, body, 0.2);
  obstacles.set_cloud(cloud_of(std::vector<Vector3d>(5000, Vector3d(0, 0, 0.5))).view(), {});
  EXPECT_EQ(obstacles.points(), 5000u);
  expect_distance(obstacles, body, -0.1);
  std::vector<Vector3d> plane;
  for (int i = 0; i < 10000; ++i) plane.emplace_back(0.01 * (i % 100) - 0.5, 0.01 * (i / 100) - 0.5, 1);
  obstacles.set_cloud(cloud_of(plane).view(), {});
  expect_distance(obstacles, body, 0.3);
  // Points that nobody measured do not hide the others.
  plane.emplace_back(1e30, 0, 0);
  plane.emplace_back(0, -3e38, 1e9);
  plane.emplace_back(9e5, 9e5, -9e5);
  obstacles.set_cloud(cloud_of(plane).view(), {});
  EXPECT_EQ(obstacles.points(), 10001u);
  expect_distance(obstacles, body, 0.3);
  // A picture of one row or column.
  for (const std::uint32_t width : {1u, 10000u}) {
    Cloud line = cloud_of(std::vector<Vector3d>(plane.begin(), plane.begin() + 10000), width);
    obstacles.set_cloud(line.view(), {});
    EXPECT_EQ(obstacles.points(), 10000u);
    expect_distance(obstacles, body, 0.3);
  }
  obstacles.set_cloud(CloudView{}, {});
  expect_nothing();
}

TEST(CloudObstacles, PlacesFarAway) {
  Random random(523);
  // Within 10 m of the camera and wherever that is, to 1e-5 m.
  std::vector<Vector3d> points;
  for (int i = 0; i < 3000; ++i) points.push_back(8 * random.direction() + random.normal3(0.3));
  const Cloud cloud = cloud_of(points);
  const Pose T = random_pose(random, 1000);
  const std::vector<Vector3d> there = plain_obstacles(cloud.view(), T, {});
  Obstacles obstacles;
  obstacles.set_cloud(cloud.view(), T);
  for (int i = 0; i < 200; ++i) {
    Body body = random_body(random, 0.5, 1);
    body.T_base_body.t = T.point(plain(random.uniform(0, 9) * random.direction()));
    expect_distance(obstacles, body, plain_nearest(body, there));
  }
  // Farther it grows with the distance.
  const Body far = sphere_at(sensor::translation(-9e5, 4e5, 1e5), 2);
  EXPECT_NEAR(obstacles.nearest(far).distance, plain_nearest(far, there), 1e-6 * 1e6);
}

// ---- Known bodies ---------------------------------------------------------------------------------------------------

TEST(KnownBodies, AgreeWithAllOfThem) {
  Random random(524);
  std::vector<Vector3d> xyz;
  for (int i = 0; i < 500; ++i) xyz.push_back(random.normal3(1));
  const Cloud cloud = cloud_of(xyz);
  int points = 0, bodies = 0;
  for (int trial = 0; trial < 100; ++trial) {
    Obstacles obstacles;
    if (trial % 2) obstacles.set_cloud(cloud.view(), {});
    std::vector<Body> known;
    for (int i = 0; i < 6; ++i) {
      known.push_back(random_body(random, i ? 0.4 : 2, 0.8));
      obstacles.add("body " + std::to_string(i), known.back());
    }
    EXPECT_EQ(obstacles.name(4), "body 4");
    for (int i = 0; i < 30; ++i) {
      const Body body = random_body(random, 0.4, 0.8);
      const double truth = trial % 2 ? plain_nearest(body, plain_obstacles(cloud.view(), {}, {})) : kInfinity;
      double of_bodies = kInfinity;
      for (const Body& other : known) of_bodies = std::min(of_bodies, distance(body, other));
      expect_distance(obstacles, body, std::min(truth, of_bodies), of_bodies == 0);
      const Obstacles::Nearest nearest = obstacles.nearest(body);
      ++(nearest.is_point ? points : bodies);
      if (!nearest.is_point) {
        EXPECT_EQ(distance(body, known[nearest.body]), nearest.distance);
      }
    }
  }
  EXPECT_GT(points, 100);
  EXPECT_GT(bodies, 500);
}

TEST(KnownBodies, OverlapIsNearWhateverTheMargin) {
  Obstacles obstacles;
  obstacles.add("table", box_at({}, {1, 1, 0.1}));
  const Body on_it = box_at(sensor::translation(0, 0, 0.0999), {0.1, 0.1, 0.1});
  const Body above = box_at(sensor::translation(0, 0, 0.1101), {0.1, 0.1, 0.1});
  EXPECT_TRUE(obstacles.within(on_it, 0));
  EXPECT_EQ(obstacles.nearest(on_it).distance, 0);
  EXPECT_FALSE(obstacles.within(above, 0.01));
  EXPECT_TRUE(obstacles.within(above, 0.0102));
  obstacles.clear_bodies();
  EXPECT_FALSE(obstacles.within(on_it, 10));
}

TEST(KnownBodies, TheCloudStaysWhenTheyGo) {
  Obstacles obstacles;
  const Cloud cloud = cloud_of({{0, 0, 1}});
  obstacles.set_cloud(cloud.view(), {});
  obstacles.add("wall", box_at(sensor::translation(0, 0, 2), {1, 1, 0.1}));
  const Body body = sphere_at({}, 0.1);
  EXPECT_TRUE(obstacles.nearest(body).is_point);
  obstacles.set_cloud(CloudView{}, {});
  EXPECT_NEAR(obstacles.nearest(body).distance, 1.85, 1e-12);
  EXPECT_EQ(obstacles.name(obstacles.nearest(body).body), "wall");
  obstacles.set_cloud(cloud.view(), {});
  obstacles.clear_bodies();
  Obstacles moved = std::move(obstacles);
  EXPECT_NEAR(moved.nearest(body).distance, 0.9, 1e-6);
}

// ---- Everything else ------------------------------------------------------------------------------------------------

TEST(Obstacles, AnyThreadAndAnyNumberOfThreads) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  Random random(525);
  const Pose T = sensor::table_scene_camera();
  std::vector<Body> bodies;
  for (int i = 0; i < 300; ++i) bodies.push_back(random_body(random, 0.2, 0.3));
  CloudObstacleOptions options;
  options.own = {bodies[0], bodies[1]};
  const auto build = [&](Obstacles& obstacles, int threads) {
    tbb::task_arena arena(threads);
    arena.execute([&] { obstacles.set_cloud(test::demo_cloud().view(), T, options); });
  };
  Obstacles one, many;
  build(one, 1), build(many, 4);
  const auto answers = [&](const Obstacles& obstacles) {
    std::vector<double> all;
    for (const Body& body : bodies) {
      const Obstacles::Nearest nearest = obstacles.nearest(body);
      all.insert(all.end(), {nearest.distance, nearest.point[0], nearest.point[1], nearest.point[2],
                             obstacles.within(body, 0.05) ? 1.0 : 0.0});
    }
    return all;
  };
  const std::vector<double> expected = answers(one);
  std::vector<std::vector<double>> found(4);
  std::vector<std::thread> threads;
  for (std::vector<double>& mine : found) threads.emplace_back([&] { mine = answers(many); });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& theirs : found) EXPECT_EQ(theirs, expected);
}

TEST(Obstacles, BadArgumentsAreRefused) {
  Obstacles obstacles;
  const Cloud cloud = cloud_of({{0, 0, 1}});
  const auto with = [&](auto change) {
    CloudObstacleOptions options;
    change(options);
    return message_of([&] { obstacles.set_cloud(cloud.view(), {}, options); });
  };
  for (const int n : {-1, 9}) EXPECT_MENTIONS(with([&](auto& o) { o.speck_neighbours = n; }), "speck_neighbours");
  for (const double d : {0.0, -1.0, kInfinity, std::nan("")}) {
    EXPECT_MENTIONS(with([&](auto& o) { o.speck_distance = d; }), "speck_distance");
  }
  for (const double d : {-0.1, kInfinity, std::nan("")}) {
    EXPECT_MENTIONS(with([&](auto& o) { o.own_margin = d; }), "own_margin");
  }
  EXPECT_MENTIONS(with([&](auto& o) { o.own = {sphere_at({}, -1)}; }), "own body '0': its radius");
  Pose bad;
  bad.R[0] = 1.1;
  EXPECT_MENTIONS(message_of([&] { obstacles.set_cloud(cloud.view(), bad); }), "T_base_cloud");
  Pose mirrored;
  mirrored.R[8] = -1;
  EXPECT_MENTIONS(message_of([&] { obstacles.set_cloud(cloud.view(), mirrored); }), "rotation");
  EXPECT_MENTIONS(message_of([&] { obstacles.set_cloud(cloud.view(), sensor::translation(std::nan(""), 0, 0)); }),
                  "T_base_cloud");
  EXPECT_MENTIONS(message_of([&] { obstacles.set_cloud(cloud.view(), sensor::translation(0, 2e6, 0)); }), "1e6 m");
  CloudView view = cloud.view();
  view.data = nullptr;
  EXPECT_MENTIONS(message_of([&] { obstacles.set_cloud(view, {}); }), "data is null");
  view = cloud.view(), view.point_step = 10;
  EXPECT_MENTIONS(message_of([&] { obstacles.set_cloud(view, {}); }), "point_step");
  view = cloud.view(), view.width = view.height = 1u << 20;
  EXPECT_MENTIONS(message_of([&] { obstacles.set_cloud(view, {}); }), "2^31");

  const std::vector<std::pair<Body, std::string>> bodies = {
      {sphere_at({}, -0.1), "radius"},
      {sphere_at({}, std::nan("")), "radius"},
      {capsule_at({}, kInfinity, 1), "radius"},
      {capsule_at({}, 1, -1), "length"},
      {box_at({}, {1, -1, 1}), "size"},
      {box_at({}, {1, 1, std::nan("")}), "size"},
      {sphere_at(bad, 1), "pose"},
      {sphere_at(sensor::translation(0, 0, kInfinity), 1), "pose"},
      {sphere_at(sensor::translation(0, 0, 1e7), 1), "far"}};
  for (const auto& [body, part] : bodies) {
    const std::string message = message_of([&, &b = body] { obstacles.add("shelf", b); });
    EXPECT_MENTIONS(message, "'shelf'");
    EXPECT_MENTIONS(message, part);
    // A query must not say that nothing is near.
    EXPECT_MENTIONS(message_of([&, &b = body] { obstacles.within(b, 0.1); }), part);
    EXPECT_MENTIONS(message_of([&, &b = body] { obstacles.nearest(b); }), part);
  }
  EXPECT_MENTIONS(message_of([&] { obstacles.within(sphere_at({}, 1), std::nan("")); }), "margin");
  EXPECT_MENTIONS(message_of([&] { obstacles.nearest(sphere_at({}, 1), std::nan("")); }), "limit");
  EXPECT_MENTIONS(message_of([&] { obstacles.name(0); }), "no body 0");
  // Nothing of this changed anything.
  EXPECT_EQ(obstacles.points(), 0u);
}

}  // namespace
}  // namespace handhold::plan
