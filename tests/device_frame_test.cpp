// A search on a device is the CPU's to the bit. Twice: with the stages of a GPU's frame gone through on the CPU, and,
// where there is one, on the GPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "demo_cloud.h"
#include "handhold/device.h"
#include "handhold/localizer.h"
#include "host_frame.h"
#include "localizer_detail.h"
#include "paper_options.h"
#include "same_result.h"
#include "test_clouds.h"

namespace handhold {
namespace {

using test::expect_same;
using test::FloatPoints;
using test::HostFrame;
using test::kInfinity;
using test::kNan;
using test::Random;

CloudView view_of(const FloatPoints& points, std::uint32_t height = 1) {
  CloudView view;
  view.data = points.empty() ? nullptr : points.front().data();
  view.width = static_cast<std::uint32_t>(points.size()) / height;
  view.height = height;
  return view;
}

FloatPoints image(std::uint64_t seed, int width = 160, int height = 120) {
  Random random(seed);
  return test::depth_image(random, width, height);
}

/// A rod, a jug's body and a ball over a table, seen from everywhere: not organized.
FloatPoints heap(std::uint64_t seed, int scale = 1) {
  Random random(seed);
  const auto at = [&](const FloatPoints& points, const test::Vector3d& t) {
    return test::transformed(points, random.rotation(), t);
  };
  FloatPoints all =
      test::transformed(test::plane(random, 12'000 * scale, 0.5, 5e-4), Eigen::Matrix3d::Identity(), {0, 0, 0.8});
  all = test::joined(all, at(test::cylinder(random, 2500 * scale, 0.012, 0.14, 3e-4), {0.1, 0.05, 0.68}));
  all = test::joined(all, at(test::cylinder(random, 5000 * scale, 0.055, 0.12, 3e-4), {-0.12, 0.1, 0.65}));
  all = test::joined(all, at(test::sphere(random, 2500 * scale, 0.03, 3e-4), {0, -0.15, 0.7}));
  random.shuffle(all);
  return all;
}

class DeviceFrameTest : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (on_gpu()) {
      const CudaDevice gpu = cuda_device();
      if (!gpu.available) GTEST_SKIP() << gpu.reason;
    }
    if (!HostFrame::same_rounding())
      GTEST_SKIP() << "the kernels in use (" << Localizer::isa() << ") do not fuse, as those of a device do";
  }
  static bool on_gpu() { return GetParam() == std::string("cuda"); }
  static std::unique_ptr<DeviceFrame> frame() {
    if (on_gpu()) return make_cuda_frame();
    return std::make_unique<HostFrame>();
  }
  static Options options() {
    Options o = test::paper_options();
    o.samples = 1500;
    o.strategy = Strategy::kUniform;
    return o;
  }
  static void expect_same_on_device(const CloudView& cloud, const Options& options) {
    Localizer cpu(options), device = LocalizerInside::on_device(options, frame());
    EXPECT_EQ(device.backend(), Backend::kCuda);
    const Result expected = cpu.localize(cloud), found = device.localize(cloud);
    expect_same(found, expected);
    const std::vector<Sample> a = device.samples(), b = cpu.samples();
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].step, b[i].step) << "sample " << i << ": " << to_string(a[i].step) << ", " << to_string(b[i].step);
      ASSERT_EQ(a[i].position, b[i].position) << "sample " << i;
    }
  }
};

TEST_P(DeviceFrameTest, TheDemosCloudGivesTheCpusResult) {
  Options o = options();
  o.samples = 5000;
  expect_same_on_device(test::demo_cloud().view(), o);
  Localizer cpu(o);
  EXPECT_GT(cpu.localize(test::demo_cloud().view()).handles.size(), 0u) << "otherwise this shows little";
}

TEST_P(DeviceFrameTest, EveryStrategyAndOptionGivesTheCpusResult) {
  const FloatPoints points = image(51);
  const CloudView cloud = view_of(points, 120);
  const auto same = [&](const char* what, const std::function<void(Options&)>& change) {
    SCOPED_TRACE(what);
    Options o = options();
    change(o);
    expect_same_on_device(cloud, o);
  };
  same("uniform", [](Options&) {});
  same("max", [](Options& o) { o.strategy = Strategy::kMax; });
  same("sum", [](Options& o) { o.strategy = Strategy::kSum; });
  same("workspace", [](Options& o) { o.workspace = {-0.1, 0.1, -0.2, 0.2, 0.3, 1.5}; });
  same("an empty workspace", [](Options& o) { o.workspace = {5, 6, 5, 6, 5, 6}; });
  same("a small ball", [](Options& o) { o.radius = {0.008}; });
  same("a large ball", [](Options& o) { o.radius = {0.08}; });
  same("a ball about everything", [](Options& o) { o.radius = {1.0}, o.samples = 40; });
  same("many neighbours", [](Options& o) { o.min_neighbours = 60; });
  same("a hand that does not close", [](Options& o) { o.hand_minimum = 0.03; });
  same("a large hand", [](Options& o) { o.hand_aperture = 0.2; });
  same("no point in the gap", [](Options& o) { o.shell_gap_area_mm2 = 0; });
  same("anything in the gap", [](Options& o) { o.shell_gap_area_mm2 = 1e6; });
  same("nothing within", [](Options& o) { o.shell_inner_area_mm2 = 0; });
  same("much within", [](Options& o) { o.shell_inner_area_mm2 = 3000; });
  same("another seed", [](Options& o) { o.seed = 7; });
  same("one sample", [](Options& o) { o.samples = 1; });
  same("one sample more than fits", [](Options& o) { o.samples = 65; });
  same("a grid", [](Options& o) { o.index = IndexKind::kGrid, o.strategy = Strategy::kMax; });
}

TEST_P(DeviceFrameTest, EveryShapeOfCloudGivesTheCpusResult) {
  const auto same = [&](const char* what, const CloudView& cloud) {
    SCOPED_TRACE(what);
    expect_same_on_device(cloud, options());
  };
  const FloatPoints odd = image(52, 157, 93), scattered = heap(53);
  same("an image whose sides are no multiples of anything", view_of(odd, 93));
  same("an unorganized cloud", view_of(scattered));
  FloatPoints holes = image(54);
  Random random(55);
  for (auto& p : holes) {
    if (random.uniform(0, 1) < 0.3) p[static_cast<int>(random.index(3))] = random.index(2) ? kNan : kInfinity;
  }
  same("an image with holes", view_of(holes, 120));
  same("an unorganized cloud with holes", view_of(holes));
  CloudView blind = view_of(odd, 93);
  blind.viewpoint.reset();
  same("no viewpoint", blind);
  blind.viewpoint = Vector3{0.5, -2, 1};
  same("another viewpoint", blind);

  std::vector<float> sixteen;  // bytes a point, as PCL has them
  for (const auto& p : odd) sixteen.insert(sixteen.end(), {p[0], p[1], p[2], 1.0f});
  CloudView of_pcl = view_of(odd, 93);
  of_pcl.data = sixteen.data(), of_pcl.point_step = 16;
  same("16 bytes a point", of_pcl);
  {
    // A GPU reads these where they are.
    const PinnedMemory packed(odd.front().data(), odd.size() * sizeof odd.front());
    const PinnedMemory padded(sixteen.data(), sixteen.size() * sizeof(float));
    EXPECT_EQ(packed.pinned() && padded.pinned(), cuda_device().available);
    same("pinned", view_of(odd, 93));
    same("pinned, unorganized", view_of(odd));
    same("pinned, 16 bytes a point", of_pcl);
  }
  std::vector<float> forty_eight;
  for (const auto& p : odd) {
    forty_eight.insert(forty_eight.end(), {p[0], p[1], p[2]});
    forty_eight.resize(forty_eight.size() + 9, kNan);
  }
  of_pcl.data = forty_eight.data(), of_pcl.point_step = 48;
  same("48 bytes a point", of_pcl);
  FloatPoints row(odd.begin(), odd.begin() + 157 * 3);
  same("three rows are no image", view_of(row, 3));
}

TEST_P(DeviceFrameTest, DegenerateCloudsGiveTheCpusResult) {
  const auto same = [&](const char* what, const FloatPoints& points, std::uint32_t height = 1) {
    SCOPED_TRACE(what);
    expect_same_on_device(view_of(points, height), options());
  };
  Random random(56);
  same("no points", {});
  same("one point", {{0.1f, 0.2f, 0.5f}});
  same("nine points", FloatPoints(9, {0.1f, 0.2f, 0.5f}));
  same("one place", FloatPoints(500, {0.1f, 0.2f, 0.5f}));
  same("all NaN", FloatPoints(500, {kNan, kNan, kNan}));
  same("all NaN, an image", FloatPoints(500, {kNan, 0, 1}), 20);
  same("nine of 500", [] {
    FloatPoints points(500, {kNan, kNan, kNan});
    for (int i = 0; i < 9; ++i) points[40 + i] = {0.01f * static_cast<float>(i), 0, 1};
    return points;
  }());
  FloatPoints line, exact;
  for (int i = 0; i < 2000; ++i) line.push_back({0.0005f * static_cast<float>(i), 0.1f, 0.7f});
  for (int i = 0; i < 4096; ++i)
    exact.push_back({0.001f * static_cast<float>(i % 64), 0.001f * static_cast<float>(i / 64), 0.75f});
  same("a line", line);
  same("an exact plane", exact);
  same("an exact plane, an image", exact, 64);
  FloatPoints twice = image(57);
  twice.insert(twice.end(), twice.begin(), twice.end());
  same("each point twice", twice);
  FloatPoints far = image(58);
  for (auto& p : far) p[0] += 1000.0f;
  same("a kilometre away", far, 120);
  FloatPoints stray = image(59);
  stray[7] = {9e5f, -9e5f, 9e5f}, stray[8] = {3e6f, 0, 0};
  same("stray points", stray, 120);
  same("stray points, unorganized", stray);
  FloatPoints millimetres = image(60);
  for (auto& p : millimetres) p *= 1000.0f;
  same("millimetres", millimetres, 120);
}

TEST_P(DeviceFrameTest, NothingStaysFromOneFrameToTheNext) {
  Options o = options();
  o.samples = 800;
  for (const Strategy strategy : {Strategy::kUniform, Strategy::kMax}) {
    o.strategy = strategy;
    Localizer device = LocalizerInside::on_device(o, frame());
    const FloatPoints small = image(61, 64, 48), large = image(62, 200, 150), scattered = heap(63), none;
    const CloudView clouds[] = {view_of(large, 150), view_of(small, 48), view_of(scattered), view_of(none),
                                view_of(large, 150), view_of(small),     view_of(large)};
    for (int round = 0; round < 2; ++round) {
      for (const CloudView& cloud : clouds) {
        Localizer cpu(o);
        cpu.set_seed(40 + round), device.set_seed(40 + round);
        expect_same(device.localize(cloud), cpu.localize(cloud));
      }
    }
  }
}

TEST_P(DeviceFrameTest, ADenseCloudGetsRoomForItsShells) {
  const FloatPoints dense = heap(64, 12);
  Options o = options();
  o.samples = 300;
  expect_same_on_device(view_of(dense), o);
  if (on_gpu()) return;
  auto little = std::make_unique<HostFrame>(64);
  const HostFrame& grown = *little;
  Localizer device = LocalizerInside::on_device(o, std::move(little)), cpu(o);
  expect_same(device.localize(view_of(dense)), cpu.localize(view_of(dense)));
  EXPECT_EQ(grown.times_grown, 1);
  expect_same(device.localize(view_of(dense)), cpu.localize(view_of(dense)));
  EXPECT_EQ(grown.times_grown, 1) << "the room stays";
}

TEST_P(DeviceFrameTest, WhereEverySampleIsAnAffordanceAllOfThemComeBack) {
  Random random(65);
  const FloatPoints rod = test::cylinder(random, 20'000, 0.015, 0.8, 1e-4);
  Options o = options();
  o.samples = 4000;
  Localizer cpu(o);
  CloudView cloud = view_of(rod);
  cloud.viewpoint.reset();
  EXPECT_GT(cpu.localize(cloud).affordances.size(), 3000u);
  expect_same_on_device(cloud, o);
}

TEST_P(DeviceFrameTest, GuessesAreDrawnAbout) {
  const FloatPoints points = image(66);
  const CloudView cloud = view_of(points, 120);
  Localizer cpu(options()), device = LocalizerInside::on_device(options(), frame());
  const std::vector<Vector3> guesses = {{points[5000][0], points[5000][1], points[5000][2]}};
  Result a, b;
  device.localize(cloud, a, guesses), cpu.localize(cloud, b, guesses);
  expect_same(a, b);
}

TEST_P(DeviceFrameTest, ManySamples) {
  const FloatPoints points = image(67, 320, 240);
  Options o = options();
  o.samples = 60'000;
  expect_same_on_device(view_of(points, 240), o);
}

INSTANTIATE_TEST_SUITE_P(, DeviceFrameTest, testing::Values("host", "cuda"),
                         [](const auto& where) { return std::string(where.param); });

}  // namespace
}  // namespace handhold
