// How long it takes to find out whether an arm on its way touches anything: a path of Baxter's right arm just over the
// objects of the table scene, 50 postures with all shapes of the moving arm and hand, against every point of the cloud
// in a plain double loop. One thread. Times are of a whole path.
//
// The pixels of data/table_scene.pcd that saw nothing get a wall behind the table, so that the cloud has about 300,000
// points. Before anything is timed, both ways must agree on every body.
#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "handhold/arm.h"
#include "handhold/collision.h"
#include "handhold/io.h"
#include "handhold/sensor.h"
#include "index.h"

namespace handhold::bench {
namespace {

using plan::Arm;
using plan::Body;
using plan::JointVector;
using plan::Obstacles;
using plan::Pose;

constexpr std::size_t kSteps = 50;
constexpr double kMargin = 0.015;  // m

/// Where the table scene stands before the robot.
const Pose kWorld = sensor::translation(0.6, -0.25, -0.15) * sensor::rotation({0, 0, 1}, -M_PI / 2);

Cloud scene_cloud() {
  Cloud cloud = read_cloud(HANDHOLD_DATA "/table_scene.pcd");
  const sensor::CameraOptions camera = sensor::table_scene_camera_options();
  constexpr float kWall = 2.5f;  // m
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    float* p = &cloud.xyz[3 * i];
    if (std::isfinite(p[0])) continue;
    p[0] = kWall * static_cast<float>((static_cast<double>(i % cloud.width) - camera.cx) / camera.fx);
    p[1] = kWall * static_cast<float>((static_cast<double>(i / cloud.width) - camera.cy) / camera.fy);
    p[2] = kWall;
  }
  return cloud;
}

/// A path in joint space with the hand pointing down, past the objects at this height over the table (m).
std::vector<JointVector> path_over_objects(const Arm& arm, double height) {
  const Pose down = sensor::rotation({1, 0, 0}, M_PI);
  std::vector<JointVector> corners;
  plan::IkOptions options;
  for (const Vector3& at : {Vector3{0.16, -0.08, 0}, {-0.15, 0.1, 0}, {0.03, 0.08, 0}, {0.21, 0.15, 0}}) {
    const auto q = arm.inverse(kWorld * sensor::translation(at[0], at[1], height) * down, options);
    if (!q) throw std::runtime_error("the arm does not reach over the table");
    corners.push_back(*q);
    options.reference = *q;
  }
  std::vector<JointVector> path;
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double at = static_cast<double>(i * (corners.size() - 1)) / static_cast<double>(kSteps - 1);
    const std::size_t from = std::min(static_cast<std::size_t>(at), corners.size() - 2);
    JointVector q = corners[from];
    for (std::size_t k = 0; k < q.size(); ++k) q[k] += (at - static_cast<double>(from)) * (corners[from + 1][k] - q[k]);
    path.push_back(q);
  }
  return path;
}

struct Setting {
  Cloud cloud = scene_cloud();
  Pose T_base_camera = kWorld * sensor::table_scene_camera();
  Arm arm = Arm::baxter(plan::Side::kRight);
  std::vector<JointVector> path;
  std::vector<plan::Shape> shapes;  // of the links that move
  std::vector<Body> bodies;         // of the whole path
  Obstacles obstacles;

  explicit Setting(double height) : path(path_over_objects(arm, height)) {
    JointVector other = path[0];
    for (double& q : other) q += 0.1;
    const std::vector<Pose> here = arm.link_poses(path[0]), there = arm.link_poses(other);
    for (const plan::Shape& shape : arm.shapes()) {
      if (here[shape.link].R != there[shape.link].R || here[shape.link].t != there[shape.link].t)
        shapes.push_back(shape);
    }
    for (const JointVector& q : path) {
      const std::vector<Pose> links = arm.link_poses(q);
      for (const plan::Shape& shape : shapes) bodies.push_back(placed(shape, links[shape.link]));
    }
    plan::CloudObstacleOptions options;
    options.speck_neighbours = 0;  // the brute force looks at all points
    obstacles.set_cloud(cloud.view(), T_base_camera, options);
  }
};

const Setting& setting() {
  static const Setting it(0.22);
  return it;
}

/// Signed distance of the nearest point, by looking at all of them.
double plain_nearest(const Body& body, const Setting& s) {
  // The body in the cloud's frame: one frame less for each point.
  Body there = body;
  there.T_base_body = s.T_base_camera.inverse() * body.T_base_body;
  const auto& R = there.T_base_body.R;
  const Vector3& t = there.T_base_body.t;
  const bool box = body.kind == plan::Shape::Kind::kBox;
  const double half[3] = {box ? body.size[0] / 2 : 0, box ? body.size[1] / 2 : 0,
                          box                                        ? body.size[2] / 2
                          : body.kind == plan::Shape::Kind::kCapsule ? body.length / 2
                                                                     : 0};
  double least = std::numeric_limits<double>::infinity(), deepest = 0;
  for (std::size_t i = 0; i < s.cloud.size(); ++i) {
    const float* p = &s.cloud.xyz[3 * i];
    const double d[3] = {static_cast<double>(p[0]) - t[0], static_cast<double>(p[1]) - t[1],
                         static_cast<double>(p[2]) - t[2]};
    double sum = 0, most = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const double out = std::fabs(R[k] * d[0] + R[3 + k] * d[1] + R[6 + k] * d[2]) - half[k];
      most = std::max(most, out);
      if (out > 0) sum += out * out;
    }
    least = std::min(least, sum);
    deepest = std::min(deepest, most);
  }
  return (deepest < 0 ? deepest : std::sqrt(least)) - (box ? 0 : body.radius);
}

/// @throws std::runtime_error
void check_agreement() {
  const Setting& s = setting();
  for (std::size_t i = 0; i < s.bodies.size(); i += 7) {
    const double truth = plain_nearest(s.bodies[i], s), found = s.obstacles.nearest(s.bodies[i]).distance;
    if (!(std::fabs(truth - found) < 1e-5) || s.obstacles.within(s.bodies[i], truth - 1e-5) ||
        !s.obstacles.within(s.bodies[i], truth + 1e-5)) {
      throw std::runtime_error("body " + std::to_string(i) + ": " + std::to_string(found) + " m instead of " +
                               std::to_string(truth));
    }
  }
}

void count(benchmark::State& state, std::size_t hits) {
  const Setting& s = setting();
  state.counters["bodies"] = static_cast<double>(s.bodies.size());
  state.counters["hits"] = static_cast<double>(hits);
  state.counters["per_body"] =
      benchmark::Counter(static_cast<double>(s.bodies.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// All bodies, even behind a hit: as on a path that is free.
void within(benchmark::State& state, double margin) {
  const Setting& s = setting();
  std::size_t hits = 0;
  for (auto _ : state) {
    hits = 0;
    for (const Body& body : s.bodies) hits += s.obstacles.within(body, margin);
    benchmark::DoNotOptimize(hits);
  }
  count(state, hits);
}

void nearest(benchmark::State& state, double limit) {
  const Setting& s = setting();
  std::size_t hits = 0;
  double least = 1e9;
  for (auto _ : state) {
    hits = 0;
    for (const Body& body : s.bodies) {
      const double d = s.obstacles.nearest(body, limit).distance;
      hits += d < kMargin, least = std::min(least, d);
    }
    benchmark::DoNotOptimize(hits);
  }
  count(state, hits);
  state.counters["least_mm"] = 1000 * least;
}

/// With the arm's kinematics, as a planner asks.
void path(benchmark::State& state) {
  const Setting& s = setting();
  std::size_t hits = 0;
  for (auto _ : state) {
    hits = 0;
    for (const JointVector& q : s.path) {
      const std::vector<Pose> links = s.arm.link_poses(q);
      for (const plan::Shape& shape : s.shapes) hits += s.obstacles.within(placed(shape, links[shape.link]), kMargin);
    }
    benchmark::DoNotOptimize(hits);
  }
  count(state, hits);
}

void brute_force(benchmark::State& state) {
  const Setting& s = setting();
  std::size_t hits = 0;
  for (auto _ : state) {
    hits = 0;
    for (const Body& body : s.bodies) hits += plain_nearest(body, s) < kMargin;
    benchmark::DoNotOptimize(hits);
  }
  count(state, hits);
}

/// What finding the blocks alone would take with the index of the localizer: those about the ball about a body.
void blocks_by_index(benchmark::State& state, IndexKind kind) {
  const Setting& s = setting();
  TileStore tiles;
  tiles.build(s.cloud.view());
  const auto index = make_index(kind);
  index->build(tiles);
  BlockSet found;
  found.resize(tiles.blocks());
  const Pose T_camera_base = s.T_base_camera.inverse();
  std::size_t blocks = 0;
  for (auto _ : state) {
    blocks = 0;
    for (const Body& body : s.bodies) {
      const Vector3 c = T_camera_base.point(body.T_base_body.t);
      const float centre[3] = {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
      const double reach = body.radius + std::hypot(body.size[0], body.size[1], body.size[2]) / 2 + body.length / 2;
      index->query(centre, static_cast<float>(reach + kMargin), found);
      found.drain([&](std::uint32_t) { ++blocks; });
    }
    benchmark::DoNotOptimize(blocks);
  }
  count(state, 0);
  state.counters["blocks"] = static_cast<double>(blocks) / static_cast<double>(s.bodies.size());
}

/// Known bodies alone: the table, four walls.
void known_bodies(benchmark::State& state) {
  const Setting& s = setting();
  Obstacles obstacles;
  obstacles.add("table", {plan::Shape::Kind::kBox, 0, 0, {0.9, 1.4, 0.04}, kWorld * sensor::translation(0, 0, -0.02)});
  for (const double side : {-1.0, 1.0}) {
    obstacles.add("wall", {plan::Shape::Kind::kBox, 0, 0, {4, 0.1, 3}, sensor::translation(0, 1.5 * side, 0)});
    obstacles.add("wall", {plan::Shape::Kind::kBox, 0, 0, {0.1, 4, 3}, sensor::translation(1.5 * side, 0, 0)});
  }
  std::size_t hits = 0;
  for (auto _ : state) {
    hits = 0;
    for (const Body& body : s.bodies) hits += obstacles.within(body, kMargin);
    benchmark::DoNotOptimize(hits);
  }
  count(state, hits);
}

void link_poses(benchmark::State& state) {
  const Setting& s = setting();
  std::size_t i = 0;
  for (auto _ : state) {
    const std::vector<Pose> links = s.arm.link_poses(s.path[i++ % kSteps]);
    benchmark::DoNotOptimize(links.data());
  }
}

/// @param own  with the robot's own bodies in its first posture
void set_cloud(benchmark::State& state, int specks, bool own, bool organized) {
  const Setting& s = setting();
  plan::CloudObstacleOptions options;
  options.speck_neighbours = specks;
  if (own) options.own.assign(s.bodies.begin(), s.bodies.begin() + static_cast<std::ptrdiff_t>(s.shapes.size()));
  CloudView view = s.cloud.view();
  if (!organized) view.width = static_cast<std::uint32_t>(view.size()), view.height = 1;
  Obstacles obstacles;
  for (auto _ : state) obstacles.set_cloud(view, s.T_base_camera, options);
  state.counters["points"] = static_cast<double>(obstacles.points());
}

void register_all() {
  const auto add = [](const char* name, auto run) {
    benchmark::RegisterBenchmark(name, run)->Unit(benchmark::kMicrosecond);
  };
  add("path/within/margin_mm:15", [](auto& state) { within(state, kMargin); });
  add("path/within/margin_mm:1", [](auto& state) { within(state, 0.001); });
  add("path/nearest/limit_mm:50", [](auto& state) { nearest(state, 0.05); });
  add("path/nearest", [](auto& state) { nearest(state, std::numeric_limits<double>::infinity()); });
  add("path/link_poses_and_within", path);
  add("path/brute_force", brute_force);
  add("path/known_bodies", known_bodies);
  add("path/blocks_of_balls/embree", [](auto& state) { blocks_by_index(state, IndexKind::kEmbree); });
  add("path/blocks_of_balls/grid", [](auto& state) { blocks_by_index(state, IndexKind::kGrid); });
  add("step/link_poses", link_poses);
  add("set_cloud/organized", [](auto& state) { set_cloud(state, 3, false, true); });
  add("set_cloud/organized/own", [](auto& state) { set_cloud(state, 3, true, true); });
  add("set_cloud/organized/all_points", [](auto& state) { set_cloud(state, 0, false, true); });
  add("set_cloud/unorganized", [](auto& state) { set_cloud(state, 0, false, false); });
  add("set_cloud/unorganized/own", [](auto& state) { set_cloud(state, 0, true, false); });
}

}  // namespace
}  // namespace handhold::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  try {
    tbb::task_arena(1).execute([] {
      handhold::bench::check_agreement();
      handhold::bench::register_all();
      benchmark::RunSpecifiedBenchmarks();
    });
  } catch (const std::exception& error) {
    std::fprintf(stderr, "collision_bench: %s\n", error.what());
    return 1;
  }
  benchmark::Shutdown();
}
