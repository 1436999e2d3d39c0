// The grasp planner on a simulated table with five handles: taking the cloud in, the first grasp that can be carried
// out, and every candidate with its reason.
//
// The argument is the scene's number, 0 to 4, in sensor::paper_scenes(). Handles are the five most confident ones that
// the localizer finds in Kinect-like noise for Baxter's gripper with its fingers in slot 1, which close on parts up to
// 30 mm thick; it ran before, and is not timed. One thread.
#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "handhold/localizer.h"
#include "handhold/planner.h"
#include "handhold/random_scene.h"
#include "handhold/scene_file.h"

namespace handhold::bench {
namespace {

constexpr int kScenes = 5;
constexpr std::size_t kHandles = 5;

struct Input {
  Cloud cloud;
  std::vector<Handle> handles;
  plan::Pose T_base_camera;
};

const plan::Arm& arm() {
  plan::ElectricGripper gripper;
  gripper.slot = 1;
  static const plan::Arm arm = plan::Arm::baxter(plan::Side::kRight, gripper);
  return arm;
}

/// The tables stand before Baxter, 0.15 m below its base.
const Input& input(std::int64_t number) {
  static std::vector<Input> inputs(kScenes);
  Input& made = inputs.at(static_cast<std::size_t>(number));
  if (!made.cloud.xyz.empty()) return made;
  const sensor::SceneFile file = sensor::paper_scenes().at(static_cast<std::size_t>(number));
  const sensor::Pose T_base_scene =
      sensor::translation(0.72, 0, -0.15) * sensor::rotation({0, 0, 1}, -1.5707963267948966);
  made.cloud = sensor::DepthCamera(file.camera).capture(sensor::build(file), file.T_world_camera).cloud;
  made.T_base_camera = T_base_scene * file.T_world_camera;
  Options options = Options::baxter();
  options.hand_minimum = arm().hand().opening_min;
  options.hand_aperture = arm().hand().opening_max;
  made.handles = Localizer(options).localize(made.cloud.view()).handles;
  made.handles.resize(std::min(made.handles.size(), kHandles));
  return made;
}

plan::GraspPlanner planner_for(const Input& in, bool all) {
  plan::PlannerOptions options;
  options.max_grasps = all ? 0 : 1;
  options.all = all;
  plan::GraspPlanner planner(arm(), options);
  planner.obstacles().set_cloud(in.cloud.view(), in.T_base_camera);
  return planner;
}

template <class Work>
void on_one_thread(benchmark::State& state, Work work) {
  tbb::task_arena arena(1);
  arena.execute([&] {
    for (auto _ : state) work();
  });
}

void BM_Planner(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(plan::GraspPlanner(arm()));
}
BENCHMARK(BM_Planner)->Unit(benchmark::kMillisecond);

void BM_SetCloud(benchmark::State& state) {
  const Input& in = input(state.range(0));
  plan::GraspPlanner planner = planner_for(in, false);
  on_one_thread(state, [&] { planner.obstacles().set_cloud(in.cloud.view(), in.T_base_camera); });
  state.counters["points"] = static_cast<double>(planner.obstacles().points());
}
BENCHMARK(BM_SetCloud)->Arg(0)->Unit(benchmark::kMillisecond);

void time_plan(benchmark::State& state, bool all) {
  const Input& in = input(state.range(0));
  const plan::GraspPlanner planner = planner_for(in, all);
  plan::Plan plan;
  on_one_thread(state, [&] { plan = planner.plan(in.handles, in.T_base_camera); });
  state.counters["handles"] = static_cast<double>(in.handles.size());
  state.counters["grasps"] = static_cast<double>(plan.grasps.size());
  state.counters["rejected"] = static_cast<double>(plan.rejected.size());
  if (all) state.counters["candidates"] = static_cast<double>(plan.candidates.size());
}
void BM_FirstGrasp(benchmark::State& state) {
  time_plan(state, false);
}
void BM_EveryCandidate(benchmark::State& state) {
  time_plan(state, true);
}
BENCHMARK(BM_FirstGrasp)->DenseRange(0, kScenes - 1)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_EveryCandidate)->DenseRange(0, kScenes - 1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace handhold::bench

BENCHMARK_MAIN();
