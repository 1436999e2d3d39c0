// What frames run on: the CPU, a GPU, or whichever is there. The same tests hold with a GPU and without, in builds with
// CUDA and without; what needs one or the other says so.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "device.h"
#include "handhold/device.h"
#include "handhold/localizer.h"
#include "localizer_detail.h"
#include "test_clouds.h"

namespace handhold {
namespace {

Options with(Backend backend, Method method = Method::kDefault) {
  Options options;
  options.backend = backend, options.method = method, options.samples = 1000;
  return options;
}

/// What making one with these options says; empty: it was made.
template <class Make>
std::string refusal(Make make) {
  try {
    make();
  } catch (const OptionError& error) {
    return error.what();
  }
  return {};
}

/// A rod before a wall, as a camera sees it.
Cloud rod() {
  test::Random random(1);
  Cloud cloud;
  cloud.width = 320, cloud.height = 240;
  for (const test::Vector3f& p : test::depth_image(random, 320, 240)) {
    cloud.xyz.insert(cloud.xyz.end(), {p.x(), p.y(), p.z()});
  }
  return cloud;
}

/// All that was found, bit for bit, without the times.
std::vector<double> numbers(const Result& result) {
  std::vector<double> all = {static_cast<double>(result.status), static_cast<double>(result.finite_points)};
  const auto add = [&all](const Vector3& v) { all.insert(all.end(), v.begin(), v.end()); };
  for (const Handle& h : result.handles) {
    add(h.center), add(h.axis), add(h.approach);
    all.insert(all.end(), {h.radius, h.length, h.confidence, h.arc, h.residual, h.observed_free, h.normal_error});
    for (const Vector3& p : h.path) add(p);
    all.insert(all.end(), h.affordances.begin(), h.affordances.end());
  }
  for (const Affordance& a : result.affordances) {
    add(a.center), add(a.axis), add(a.normal);
    all.insert(all.end(), {a.radius, a.gap, a.curvature, a.observed_free, a.quality, static_cast<double>(a.sample)});
  }
  return all;
}

TEST(CudaDevice, IsNamedOrSaysWhyThereIsNone) {
  const CudaDevice device = cuda_device();
  EXPECT_EQ(device.available, device.reason.empty()) << device.reason;
  EXPECT_EQ(device.available, !device.name.empty()) << device.name;
  for (const std::string& text : {device.name, device.reason, why_not_on_device({})}) {
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
  if (!device.available) {
    EXPECT_EQ(why_not_on_device({}), device.reason);
  }
}

TEST(Backend, IsTheCpuUnlessAskedOtherwise) {
  EXPECT_EQ(Options().backend, Backend::kCpu);
  const Localizer localizer;
  EXPECT_EQ(localizer.backend(), Backend::kCpu);
  EXPECT_EQ(localizer.backend_reason(), "");
}

TEST(Backend, CudaIsUsedOrRefusedWithTheReason) {
  for (const Method method : {Method::kDefault, Method::kPaper}) {
    const Options options = with(Backend::kCuda, method);
    const std::string reason = why_not_on_device(options);
    const std::string said = refusal([&] {
      const Localizer localizer(options);
      EXPECT_EQ(localizer.backend(), Backend::kCuda) << "never anything else in silence";
      EXPECT_EQ(localizer.backend_reason(), "");
    });
    const std::string inside = refusal([&] { LocalizerInside::make(options, {}); });
    const std::string expected =
        reason.empty() ? "" : "backend = cuda: " + reason + "; use 'cpu', or 'auto' to fall back";
    EXPECT_EQ(said, expected);
    EXPECT_EQ(inside, expected);
  }
}

TEST(Backend, OptionsOutOfRangeAreNamedFirst) {
  Options options = with(Backend::kCuda);
  options.samples = 0;
  EXPECT_EQ(refusal([&] { Localizer localizer(options); }).rfind("samples = 0: ", 0), 0u);
}

TEST(Backend, AutoTakesTheGpuOrTheCpuAndSaysWhy) {
  for (const Method method : {Method::kDefault, Method::kPaper}) {
    const Options options = with(Backend::kAuto, method);
    const std::string reason = why_not_on_device(options);
    const Localizer localizer(options), inside = LocalizerInside::make(options, {});
    for (const Localizer* one : {&localizer, &inside}) {
      EXPECT_EQ(one->backend(), reason.empty() ? Backend::kCuda : Backend::kCpu);
      EXPECT_EQ(one->backend_reason(), reason);
      EXPECT_EQ(one->options().backend, Backend::kAuto) << "what was asked for stays to be seen";
    }
  }
}

TEST(Backend, AutoOnTheCpuGivesWhatTheCpuGives) {
  const Cloud cloud = rod();
  bool looked = false;
  for (const Method method : {Method::kDefault, Method::kPaper}) {
    Localizer chosen(with(Backend::kAuto, method)), cpu(with(Backend::kCpu, method));
    if (chosen.backend() != Backend::kCpu) continue;
    looked = true;
    const Result expected = cpu.localize(cloud.view());
    ASSERT_FALSE(expected.affordances.empty()) << "a test of nothing";
    EXPECT_EQ(numbers(chosen.localize(cloud.view())), numbers(expected));
  }
  if (!looked) GTEST_SKIP() << "'auto' is a GPU here: " << cuda_device().name;
}

TEST(Backend, MovesWithTheLocalizer) {
  Localizer first(with(Backend::kAuto));
  const Backend backend = first.backend();
  const std::string reason = first.backend_reason();
  Localizer second = std::move(first);
  EXPECT_EQ(second.backend(), backend);
  EXPECT_EQ(second.backend_reason(), reason);
}

}  // namespace
}  // namespace handhold
