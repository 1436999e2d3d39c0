// The benchmark of the CUDA backend without a GPU: what it says then, its dry run, and what it computes on the CPU.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "floors.h"
#include "handhold/device.h"
#include "handhold/localizer.h"
#include "host_frame.h"
#include "process.h"
#include "result_difference.h"
#include "search.h"
#include "table.h"
#include "test_clouds.h"

namespace handhold::bench {
namespace {

using test::Folder;
using test::run_program;

TEST(CudaBench, WithoutAGpuItSaysSoInOneLine) {
  const CudaDevice device = cuda_device();
  if (device.available) GTEST_SKIP() << "there is a GPU here: " << device.name;
  const Folder folder;
  const test::Outcome done = run_program({"--json", "times.json"}, folder.path());
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_EQ(done.out, "");
  EXPECT_EQ(done.err, "handhold_cuda_bench: " + device.reason + "\n");
  EXPECT_TRUE(folder.entries().empty());
}

class DryRun : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::HostFrame::same_rounding())
      GTEST_SKIP() << "the kernels in use (" << Localizer::isa() << ") do not fuse, as those of a device do";
  }
  test::Outcome run(std::vector<std::string> words, const test::Surroundings& around = {}) const {
    words.insert(words.end(), {"--dry", "--threads", "2", "--json", "times.json"});
    return run_program(words, folder_.path(), around);
  }
  Json json() const { return Json::parse(folder_.read("times.json")); }
  const Folder folder_;
};

TEST_F(DryRun, GoesThroughEverything) {
  const test::Outcome done = run({});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(done.err, "");
  const Json all = json();
  EXPECT_EQ(all["same"], true);
  EXPECT_FALSE(all.contains("error"));
  EXPECT_EQ(all["stages"].size(), 2 * (kStages + 3));
  for (const Json& row : all["stages"]) EXPECT_TRUE(row["median_us"].is_null()) << "nothing was timed: " << row;
  ASSERT_EQ(all["floors"].size(), 2 * (kStages + 2));
  for (const Json& row : all["floors"]) {
    EXPECT_GT(row["floor_us"].get<double>(), 0) << row;
    EXPECT_NE(row["floor_by"], "-") << row;
  }
  for (const Json& counts : all["counts"]) {
    EXPECT_EQ(counts["operations_a_point"], 45.0);
    EXPECT_GT(counts["operations_a_quadric"], 1000.0);
    EXPECT_GT(counts["A"], 10);
    EXPECT_GT(counts["N"].get<double>(), 20 * counts["K"].get<double>());
  }
  ASSERT_EQ(all["frames"].size(), all["results"].size());
  for (const Json& row : all["frames"]) EXPECT_GT(row["pageable_ms"].get<double>(), 0) << row;
  std::int64_t handles = 0;
  for (const Json& row : all["results"]) {
    EXPECT_GT(row["affordances"], 10) << row;
    EXPECT_EQ(row["steps_differ"], 0) << row;
    EXPECT_EQ(row["affordances_differ"], 0) << row;
    handles += row["handles"].get<std::int64_t>();
  }
  EXPECT_GT(handles, 0);
  EXPECT_EQ(all["frames_a_second"].size(), 6u);
  for (const Json& row : all["frames_a_second"]) {
    EXPECT_EQ(row["wrong"], 0) << row;
    EXPECT_GT(row["frames"], 0) << row;
  }
  // What is printed is what is written.
  EXPECT_NE(done.out.find("frame + upload"), std::string::npos);
  EXPECT_NE(done.out.find("GPU and CPU find the same to the bit"), std::string::npos);
}

// Kernels that do not fuse find something else by a hair: this must be seen.
TEST_F(DryRun, DifferencesAreSeen) {
  test::Surroundings scalar;
  scalar.environment = {{"HANDHOLD_ISA", "scalar"}};
  const test::Outcome done = run({}, scalar);
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_NE(done.out.find("DO NOT FIND THE SAME"), std::string::npos);
  const Json all = json();
  EXPECT_EQ(all["same"], false);
  std::int64_t differ = 0, wrong = 0;
  for (const Json& row : all["results"]) {
    differ += row["affordances_differ"].get<std::int64_t>();
    EXPECT_LT(row["centre_m"].get<double>(), 1e-3) << "by a hair only: " << row;
  }
  for (const Json& row : all["frames_a_second"]) wrong += row["wrong"].get<std::int64_t>();
  EXPECT_GT(differ, 0);
  EXPECT_GT(wrong, 0);
}

TEST_F(DryRun, ARawCloudIsTheSameCloud) {
  ASSERT_EQ(run({}).exit_code, 0);
  const Json direct = json()["counts"];
  const test::Outcome wrote = run_program({"--write-raw", "cloud.raw"}, folder_.path());
  ASSERT_EQ(wrote.exit_code, 0) << wrote.err;
  EXPECT_EQ(wrote.out, "");
  ASSERT_EQ(run({"cloud.raw"}).exit_code, 0);
  EXPECT_EQ(json()["counts"], direct);
  std::string bytes = folder_.read("cloud.raw");
  bytes.pop_back();
  folder_.write("cloud.raw", bytes);
  const test::Outcome refused = run({"cloud.raw"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_EQ(refused.err.rfind("handhold_cuda_bench: cloud.raw: is not a raw cloud", 0), 0u) << refused.err;
}

TEST(CudaBenchFloors, TheSlowestRateCounts) {
  const Rates rates = {10, 20, 100, 1000, 500};
  EXPECT_EQ(floor_of({}, rates).seconds, 0);
  const Floor memory = floor_of({10, 20, 300, 2000, 900}, rates);
  EXPECT_DOUBLE_EQ(memory.seconds, 3);
  EXPECT_EQ(memory.by, "memory");
  EXPECT_EQ(floor_of({10, 20, 300, 2000, 9000}, rates).by, "FP64");
  EXPECT_EQ(floor_of({50, 0, 0, 0, 0}, rates).by, "upload");
}

TEST(CudaBenchFloors, PointsAreThoseInTheBalls) {
  test::Random random(3);
  const test::FloatPoints points = test::cylinder(random, 4000, 0.02, 0.2, 3e-4);
  CloudView view;
  view.data = points.front().data(), view.width = static_cast<std::uint32_t>(points.size());
  Options o;
  o.method = Method::kPaper, o.strategy = Strategy::kUniform, o.samples = 200;
  Localizer localizer(o);
  localizer.localize(view);
  const std::vector<Sample> samples = localizer.samples();
  const Looked looked = look(o, view, samples);
  EXPECT_EQ(looked.finite, points.size());
  EXPECT_EQ(looked.summed, samples.size()) << "nothing of a thin rod is flat";
  const auto r = static_cast<float>(scales_of(o).front().radius);
  std::uint64_t expected = 0;
  for (const Sample& s : samples) {
    for (const auto& p : points) {
      const float x = p[0] - static_cast<float>(s.position[0]), y = p[1] - static_cast<float>(s.position[1]);
      const float z = p[2] - static_cast<float>(s.position[2]);
      expected += x * x + y * y + z * z <= r * r;
    }
  }
  // Up to points on the very surface of a ball.
  EXPECT_NEAR(static_cast<double>(looked.points), static_cast<double>(expected), 1e-4 * static_cast<double>(expected));
  EXPECT_GE(looked.touched, looked.summed);
  const FitOperations fit = operations_of_fit(looked.moments);
  EXPECT_GT(fit.quadric.slow, 20) << "nine pivots, seven reflections, and an iteration";
  EXPECT_GT(fit.circle.slow, 20);
}

Outcome outcome() {
  Outcome o;
  for (std::uint32_t i : {2u, 5u, 9u}) {
    Affordance& a = o.result.affordances.emplace_back();
    a.center = {0.1, 0.2, 0.3}, a.axis = {1, 0, 0}, a.normal = {0, 0, -1}, a.radius = 0.02, a.sample = i;
  }
  Handle& h = o.result.handles.emplace_back();
  h.center = {0.1, 0.2, 0.3}, h.axis = {1, 0, 0}, h.approach = {0, 0, 1}, h.affordances = {0, 1, 2};
  o.samples.resize(10);
  return o;
}

TEST(CudaBenchDifference, EveryBitCounts) {
  EXPECT_TRUE(difference(outcome(), outcome()).none());
  const auto of = [](auto&& change) {
    Outcome other = outcome();
    change(other);
    const Difference d = difference(outcome(), other), back = difference(other, outcome());
    EXPECT_EQ(d.affordances, back.affordances);
    EXPECT_FALSE(d.none());
    return d;
  };
  Difference d = of([](Outcome& o) { o.result.affordances[1].radius = std::nextafter(0.02, 1.0); });
  EXPECT_EQ(d.affordances, 1);
  EXPECT_EQ(d.centre, 0);
  d = of([](Outcome& o) { o.result.affordances[2].center[0] += 0.01; });
  EXPECT_NEAR(d.centre, 0.01, 1e-12);
  d = of([](Outcome& o) { o.result.affordances[0].axis = {std::cos(0.1), std::sin(0.1), 0}; });
  EXPECT_NEAR(d.axis, 0.1, 1e-12);
  d = of([](Outcome& o) { o.result.affordances.erase(o.result.affordances.begin() + 1); });
  EXPECT_EQ(d.affordances, 1);
  d = of([](Outcome& o) { o.result.affordances[1].sample = 6; });
  EXPECT_EQ(d.affordances, 2) << "one is missing, and one is new";
  d = of([](Outcome& o) { o.samples[3].step = Step::kFlat; });
  EXPECT_EQ(d.steps, 1);
  d = of([](Outcome& o) { o.samples[3].position[2] = -0.0; });
  EXPECT_EQ(d.places, 1);
  d = of([](Outcome& o) { o.samples.pop_back(); });
  EXPECT_EQ(d.steps, 1);
  d = of([](Outcome& o) { o.result.handles[0].affordances.pop_back(); });
  EXPECT_EQ(d.handles, 1);
  d = of([](Outcome& o) { o.result.handles.clear(); });
  EXPECT_EQ(d.handles, 1);
}

TEST(CudaBenchTable, IsAligned) {
  Table t("title", {{"name", "name", 0}, {"ms", "time", 2}, {"n", "n", 0}});
  t.add({"a", 1.0, 12345});
  t.add({"longer", nullptr, 1});
  EXPECT_EQ(t.text(), "\ntitle\nname    time      n\na       1.00  12345\nlonger     -      1\n");
  EXPECT_EQ(t.json().dump(), R"([{"name":"a","ms":1.0,"n":12345},{"name":"longer","ms":null,"n":1}])");
  EXPECT_THROW(t.add({"too few"}), std::logic_error);
}

}  // namespace
}  // namespace handhold::bench
