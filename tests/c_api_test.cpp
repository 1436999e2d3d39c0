// The interface for C: the numbers are those of C++, and no mistake of a caller is more than a code and a message.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "handhold/handhold.h"
#include "handhold/localizer.h"
#include "handhold/option_text.h"
#include "handhold/sensor.h"

namespace {
/// Allocations that this thread may still make with new; below 0: as many as it likes.
thread_local int allocations_left = -1;
}  // namespace

// Not inlined: the compiler would take malloc and delete, or new and free, for a pair that does not match.
__attribute__((noinline)) void* operator new(std::size_t size) {
  if (allocations_left == 0) throw std::bad_alloc();
  if (allocations_left > 0) --allocations_left;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
__attribute__((noinline)) void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  try {
    return operator new(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
__attribute__((noinline)) void operator delete(void* memory) noexcept {
  std::free(memory);
}
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace handhold {
namespace {

using Options_ = std::unique_ptr<handhold_options, void (*)(handhold_options*)>;
using Localizer_ = std::unique_ptr<handhold_localizer, void (*)(handhold_localizer*)>;

Options_ make_options() {
  handhold_options* options = nullptr;
  EXPECT_EQ(handhold_options_create(&options), HANDHOLD_OK);
  return {options, handhold_options_destroy};
}
Localizer_ make_localizer(handhold_options* options = nullptr) {
  handhold_localizer* localizer = nullptr;
  EXPECT_EQ(handhold_localizer_create(options, &localizer), HANDHOLD_OK);
  return {localizer, handhold_localizer_destroy};
}

const Cloud& table_scene() {
  static const Cloud cloud = [] {
    const sensor::DepthCamera camera(sensor::table_scene_camera_options());
    return camera.capture(sensor::table_scene(), sensor::table_scene_camera()).cloud;
  }();
  return cloud;
}
handhold_cloud c_view(const Cloud& cloud) {
  handhold_cloud view = {};
  view.data = cloud.xyz.data();
  view.width = cloud.width;
  view.height = cloud.height;
  view.no_viewpoint = !cloud.viewpoint;
  for (std::size_t k = 0; k < 3 && cloud.viewpoint; ++k) view.viewpoint[k] = (*cloud.viewpoint)[k];
  return view;
}

handhold_frame frame_of(const handhold_localizer* localizer) {
  handhold_frame frame = {};
  EXPECT_EQ(handhold_get_frame(localizer, &frame, sizeof frame), HANDHOLD_OK);
  return frame;
}
template <class T, class Get>
std::vector<T> list(const handhold_localizer* localizer, std::size_t count, Get get) {
  std::vector<T> values(count);
  EXPECT_EQ(get(localizer, 0, count, values.data(), sizeof(T)), HANDHOLD_OK);
  return values;
}
std::vector<handhold_handle> handles_of(const handhold_localizer* localizer) {
  return list<handhold_handle>(localizer, frame_of(localizer).handles, handhold_get_handles);
}
std::vector<handhold_affordance> affordances_of(const handhold_localizer* localizer) {
  return list<handhold_affordance>(localizer, frame_of(localizer).affordances, handhold_get_affordances);
}

Vector3 vector(const double (&v)[3]) {
  return {v[0], v[1], v[2]};
}

void expect_same(const handhold_localizer* c, const Result& cpp) {
  const handhold_frame frame = frame_of(c);
  EXPECT_STREQ(handhold_status_text(frame.status), to_string(cpp.status).data());
  EXPECT_EQ(frame.points, cpp.points);
  EXPECT_EQ(frame.finite_points, cpp.finite_points);
  ASSERT_EQ(frame.handles, cpp.handles.size());
  ASSERT_EQ(frame.affordances, cpp.affordances.size());
  const std::vector<handhold_handle> handles = handles_of(c);
  for (std::size_t i = 0; i < handles.size(); ++i) {
    const handhold_handle& a = handles[i];
    const Handle& b = cpp.handles[i];
    EXPECT_EQ(vector(a.center), b.center);
    EXPECT_EQ(vector(a.axis), b.axis);
    EXPECT_EQ(vector(a.approach), b.approach);
    EXPECT_EQ(a.radius, b.radius);
    EXPECT_EQ(a.length, b.length);
    EXPECT_EQ(a.confidence, b.confidence);
    EXPECT_EQ(a.arc, b.arc);
    EXPECT_EQ(a.residual, b.residual);
    EXPECT_EQ(a.observed_free, b.observed_free);
    EXPECT_EQ(a.normal_error, b.normal_error);
    EXPECT_EQ(a.path == nullptr, b.path.empty());
    ASSERT_EQ(a.path_points, b.path.size());
    for (std::size_t k = 0; k < b.path.size(); ++k) {
      EXPECT_EQ((Vector3{a.path[3 * k], a.path[3 * k + 1], a.path[3 * k + 2]}), b.path[k]);
    }
    EXPECT_EQ(std::vector<std::uint32_t>(a.affordances, a.affordances + a.affordance_count), b.affordances);
  }
  const std::vector<handhold_affordance> affordances = affordances_of(c);
  for (std::size_t i = 0; i < affordances.size(); ++i) {
    const handhold_affordance& a = affordances[i];
    const Affordance& b = cpp.affordances[i];
    EXPECT_EQ(vector(a.center), b.center);
    EXPECT_EQ(vector(a.axis), b.axis);
    EXPECT_EQ(vector(a.normal), b.normal);
    EXPECT_EQ((std::vector<double>{a.radius, a.shell_radius, a.gap, a.curvature, a.observed_free, a.quality,
                                   a.neighbourhood}),
              (std::vector<double>{b.radius, b.shell_radius, b.gap, b.curvature, b.observed_free, b.quality,
                                   b.neighbourhood}));
    EXPECT_EQ(a.sample, b.sample);
    EXPECT_EQ(a.reserved, 0u);
  }
  handhold_funnel a;
  ASSERT_EQ(handhold_get_funnel(c, &a, sizeof a), HANDHOLD_OK);
  const Funnel& b = cpp.funnel;
  const std::int64_t counts_c[] = {
      a.samples,       a.too_few_points, a.flat,      a.curvature_low,  a.concave,     a.circle_wide,
      a.circle_narrow, a.poor_fit,       a.no_gap,    a.shell_empty,    a.affordances, a.cut,
      a.not_aligned,   a.unconfirmed,    a.too_short, a.low_confidence, a.in_handles};
  const std::int64_t counts_cpp[] = {
      b.samples,       b.too_few_points, b.flat,      b.curvature_low,  b.concave,     b.circle_wide,
      b.circle_narrow, b.poor_fit,       b.no_gap,    b.shell_empty,    b.affordances, b.cut,
      b.not_aligned,   b.unconfirmed,    b.too_short, b.low_confidence, b.in_handles};
  for (std::size_t i = 0; i < std::size(counts_c); ++i) EXPECT_EQ(counts_c[i], counts_cpp[i]) << "count " << i;
}

// ---- Library -------------------------------------------------------------------------------------------------------

TEST(CLibrary, NamesItsVersion) {
  EXPECT_STREQ(handhold_version(), HANDHOLD_VERSION_STRING);
  EXPECT_EQ(std::string(HANDHOLD_VERSION_STRING), std::to_string(HANDHOLD_VERSION_MAJOR) + "." +
                                                      std::to_string(HANDHOLD_VERSION_MINOR) + "." +
                                                      std::to_string(HANDHOLD_VERSION_PATCH));
  EXPECT_EQ(handhold_abi(), static_cast<std::uint32_t>(HANDHOLD_ABI));
  EXPECT_STREQ(handhold_isa(), Localizer::isa());
}

TEST(CLibrary, NumbersNeverChange) {
  const int codes[] = {HANDHOLD_OK,        HANDHOLD_NULL_ARGUMENT, HANDHOLD_BAD_OBJECT, HANDHOLD_BAD_SIZE,
                       HANDHOLD_BAD_INDEX, HANDHOLD_BAD_OPTION,    HANDHOLD_BAD_CLOUD,  HANDHOLD_NO_FRAME,
                       HANDHOLD_BUSY,      HANDHOLD_NO_MEMORY,     HANDHOLD_FAILED};
  for (int i = 0; i < static_cast<int>(std::size(codes)); ++i) {
    EXPECT_EQ(codes[i], i);
    EXPECT_STRNE(handhold_code_text(i), handhold_code_text(-1)) << i;
  }
  EXPECT_STREQ(handhold_code_text(-1), "unknown code");
  const std::pair<int, Status> statuses[] = {
      {0, Status::kOk},           {1, Status::kEmpty},           {2, Status::kNoFinitePoints},
      {3, Status::kTooFewPoints}, {4, Status::kSuspiciousUnits}, {5, Status::kDeadline},
      {6, Status::kCancelled}};
  for (const auto& [number, status] : statuses) EXPECT_STREQ(handhold_status_text(number), to_string(status).data());
  EXPECT_STREQ(handhold_status_text(-1), "unknown");
  EXPECT_STREQ(handhold_status_text(1000), "unknown");
}

// ---- Options -------------------------------------------------------------------------------------------------------

TEST(COptions, AreThoseOfTheLibraryByName) {
  const std::vector<std::string> names = option_names();
  ASSERT_EQ(handhold_option_count(), names.size());
  const Options_ options = make_options();
  const Options defaults;
  std::size_t i = 0;
  visit_options(defaults, [&](const auto&, const OptionInfo& info) {
    EXPECT_STREQ(handhold_option_name(i), info.name);
    EXPECT_STREQ(handhold_option_unit(i), info.unit);
    EXPECT_STREQ(handhold_option_help(i), info.help);
    const char* text = nullptr;
    EXPECT_EQ(handhold_get(options.get(), info.name, &text), HANDHOLD_OK);
    EXPECT_EQ(text, get_option(defaults, info.name));
    ++i;
  });
  for (const std::size_t beyond : {i, std::numeric_limits<std::size_t>::max()}) {
    EXPECT_EQ(handhold_option_name(beyond), nullptr);
    EXPECT_EQ(handhold_option_unit(beyond), nullptr);
    EXPECT_EQ(handhold_option_help(beyond), nullptr);
  }
}

TEST(COptions, AreSetAndReadBack) {
  const Options_ options = make_options();
  const char* text = nullptr;
  EXPECT_EQ(handhold_set(options.get(), "hand_aperture", "0.1"), HANDHOLD_OK);
  EXPECT_EQ(handhold_set(options.get(), "radius", "0.01, 0.025"), HANDHOLD_OK);
  EXPECT_EQ(handhold_get(options.get(), "radius", &text), HANDHOLD_OK);
  EXPECT_STREQ(text, "0.01 0.025");
  EXPECT_EQ(handhold_get(options.get(), "hand_aperture", &text), HANDHOLD_OK);
  EXPECT_STREQ(text, "0.1");
}

TEST(COptions, OfAKnownHandReplaceAll) {
  const Options_ options = make_options();
  const char* text = nullptr;
  EXPECT_EQ(handhold_set(options.get(), "samples", "7"), HANDHOLD_OK);
  EXPECT_EQ(handhold_options_reset(options.get(), "baxter"), HANDHOLD_OK);
  for (const std::string& name : option_names()) {
    EXPECT_EQ(handhold_get(options.get(), name.c_str(), &text), HANDHOLD_OK);
    EXPECT_EQ(text, get_option(Options::baxter(), name)) << name;
  }
  EXPECT_EQ(handhold_options_reset(options.get(), "three fingers"), HANDHOLD_BAD_OPTION);
  EXPECT_STREQ(handhold_options_message(options.get()), "unknown hand 'three fingers'; must be 'baxter'");
  EXPECT_EQ(handhold_options_reset(options.get(), nullptr), HANDHOLD_OK);
  EXPECT_EQ(handhold_get(options.get(), "finger_width", &text), HANDHOLD_OK);
  EXPECT_EQ(text, get_option(Options(), "finger_width"));
}

TEST(COptions, RefuseWhatIsNoValueAndSayWhy) {
  const Options_ options = make_options();
  const char* text = "untouched";
  EXPECT_EQ(handhold_set(options.get(), "hand_apperture", "0.1"), HANDHOLD_BAD_OPTION);
  EXPECT_STREQ(handhold_options_message(options.get()),
               "unknown option 'hand_apperture'; did you mean 'hand_aperture'?");
  EXPECT_EQ(handhold_get(options.get(), "hand_apperture", &text), HANDHOLD_BAD_OPTION);
  EXPECT_EQ(text, nullptr);
  EXPECT_EQ(handhold_set(options.get(), "samples", "ma\nny"), HANDHOLD_BAD_OPTION);
  EXPECT_STREQ(handhold_options_message(options.get()), "samples = 'ma ny': must be a whole number");
  EXPECT_EQ(handhold_set(options.get(), "samples", "10"), HANDHOLD_OK);
  EXPECT_STREQ(handhold_options_message(options.get()), "");

  const std::string endless(100'000, 'x');
  EXPECT_EQ(handhold_set(options.get(), "samples", endless.c_str()), HANDHOLD_BAD_OPTION);
  EXPECT_EQ(std::string(handhold_options_message(options.get())).size(), 1023u);
}

TEST(COptions, OutOfRangeAreNamedWhenTheLocalizerIsMade) {
  const Options_ options = make_options();
  ASSERT_EQ(handhold_set(options.get(), "min_free", "1.5"), HANDHOLD_OK);
  handhold_localizer* localizer = reinterpret_cast<handhold_localizer*>(options.get());
  EXPECT_EQ(handhold_localizer_create(options.get(), &localizer), HANDHOLD_BAD_OPTION);
  EXPECT_EQ(localizer, nullptr);
  EXPECT_STREQ(handhold_options_message(options.get()), "min_free = 1.5: must be between 0 and 1");
}

// ---- Numbers -------------------------------------------------------------------------------------------------------

TEST(CLocalizer, GivesTheNumbersOfCpp) {
  for (const char* method : {"default", "paper"}) {
    const Options_ options = make_options();
    ASSERT_EQ(handhold_set(options.get(), "method", method), HANDHOLD_OK);
    const Localizer_ localizer = make_localizer(options.get());
    const handhold_cloud cloud = c_view(table_scene());
    ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
    EXPECT_STREQ(handhold_localizer_message(localizer.get()), "");

    Options same;
    set_option(same, "method", method);
    const Result result = Localizer(same).localize(table_scene().view());
    EXPECT_FALSE(result.handles.empty());
    expect_same(localizer.get(), result);

    handhold_times t;
    ASSERT_EQ(handhold_get_times(localizer.get(), &t, sizeof t), HANDHOLD_OK);
    EXPECT_GT(t.total, 0);
    EXPECT_NEAR(t.total, t.index + t.samples + t.neighbours + t.moments + t.fit + t.shell + t.visibility + t.handles,
                0.01 * t.total);
  }
}

TEST(CLocalizer, TakesPointsWithOtherFieldsBetween) {
  const Cloud& packed = table_scene();
  std::vector<float> spread(5 * packed.size(), 77);
  for (std::size_t i = 0; i < packed.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) spread[5 * i + k] = packed.xyz[3 * i + k];
  }
  const Localizer_ localizer = make_localizer();
  handhold_cloud cloud = c_view(packed);
  cloud.data = spread.data();
  cloud.point_step = 20;
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  expect_same(localizer.get(), Localizer().localize(packed.view()));
}

TEST(CLocalizer, KnowsViewpointsAndTheirAbsence) {
  const Localizer_ localizer = make_localizer();
  CloudView view = table_scene().view();
  handhold_cloud cloud = c_view(table_scene());
  cloud.no_viewpoint = 1;
  cloud.viewpoint[0] = std::numeric_limits<double>::quiet_NaN();  // is not looked at
  view.viewpoint.reset();
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  expect_same(localizer.get(), Localizer().localize(view));

  // The points in another frame, so that the sensor stands elsewhere.
  Cloud moved = table_scene();
  for (std::size_t i = 0; i < moved.xyz.size(); i += 3) moved.xyz[i] += 1;
  moved.viewpoint = Vector3{1, 0, 0};
  cloud = c_view(moved);
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  expect_same(localizer.get(), Localizer().localize(moved.view()));
}

TEST(CLocalizer, OptionsAreCopied) {
  Options_ options = make_options();
  ASSERT_EQ(handhold_set(options.get(), "samples", "100"), HANDHOLD_OK);
  const Localizer_ localizer = make_localizer(options.get());
  options.reset();
  const handhold_cloud cloud = c_view(table_scene());
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  handhold_funnel funnel;
  ASSERT_EQ(handhold_get_funnel(localizer.get(), &funnel, sizeof funnel), HANDHOLD_OK);
  EXPECT_EQ(funnel.samples, 100);
}

TEST(CLocalizer, StatusSaysWhyACloudWasNotSearched) {
  const Localizer_ localizer = make_localizer();
  std::vector<float> points(300, std::numeric_limits<float>::quiet_NaN());
  handhold_cloud cloud = {};
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  EXPECT_EQ(frame_of(localizer.get()).status, HANDHOLD_STATUS_EMPTY);
  cloud.data = points.data();
  cloud.width = 100;
  cloud.height = 1;
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  EXPECT_EQ(frame_of(localizer.get()).status, HANDHOLD_STATUS_NO_FINITE_POINTS);
  points[0] = points[1] = points[2] = 1;
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  EXPECT_EQ(frame_of(localizer.get()).status, HANDHOLD_STATUS_TOO_FEW_POINTS);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = static_cast<float>(i % 97) * 10;
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  EXPECT_EQ(frame_of(localizer.get()).status, HANDHOLD_STATUS_SUSPICIOUS_UNITS);
  EXPECT_EQ(frame_of(localizer.get()).points, 100u);
}

TEST(CLocalizer, EndsAtItsDeadline) {
  const Options_ options = make_options();
  ASSERT_EQ(handhold_set(options.get(), "deadline_ms", "1e-6"), HANDHOLD_OK);
  const Localizer_ localizer = make_localizer(options.get());
  const handhold_cloud cloud = c_view(table_scene());
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  EXPECT_EQ(frame_of(localizer.get()).status, HANDHOLD_STATUS_DEADLINE);
  EXPECT_EQ(frame_of(localizer.get()).handles, 0u);
}

// ---- Mistakes ------------------------------------------------------------------------------------------------------

TEST(CMistakes, NullIsACode) {
  EXPECT_EQ(handhold_options_create(nullptr), HANDHOLD_NULL_ARGUMENT);
  handhold_options_destroy(nullptr);
  handhold_localizer_destroy(nullptr);
  const char* text = "untouched";
  EXPECT_EQ(handhold_options_reset(nullptr, nullptr), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_set(nullptr, "samples", "1"), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get(nullptr, "samples", &text), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(text, nullptr);
  EXPECT_STREQ(handhold_options_message(nullptr), handhold_code_text(HANDHOLD_NULL_ARGUMENT));
  EXPECT_STREQ(handhold_localizer_message(nullptr), handhold_code_text(HANDHOLD_NULL_ARGUMENT));

  const Options_ options = make_options();
  EXPECT_EQ(handhold_set(options.get(), nullptr, "1"), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_set(options.get(), "samples", nullptr), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get(options.get(), nullptr, &text), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get(options.get(), "samples", nullptr), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_localizer_create(options.get(), nullptr), HANDHOLD_NULL_ARGUMENT);
  EXPECT_STREQ(handhold_options_message(options.get()), handhold_code_text(HANDHOLD_NULL_ARGUMENT));
  EXPECT_EQ(handhold_localizer_create(nullptr, nullptr), HANDHOLD_NULL_ARGUMENT);

  const handhold_cloud cloud = c_view(table_scene());
  handhold_frame frame;
  EXPECT_EQ(handhold_localize(nullptr, &cloud, sizeof cloud), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get_frame(nullptr, &frame, sizeof frame), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get_funnel(nullptr, nullptr, 0), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get_times(nullptr, nullptr, 0), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get_handles(nullptr, 0, 0, nullptr, 0), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get_affordances(nullptr, 0, 0, nullptr, 0), HANDHOLD_NULL_ARGUMENT);

  const Localizer_ localizer = make_localizer();
  EXPECT_EQ(handhold_localize(localizer.get(), nullptr, sizeof cloud), HANDHOLD_NULL_ARGUMENT);
  EXPECT_STREQ(handhold_localizer_message(localizer.get()), handhold_code_text(HANDHOLD_NULL_ARGUMENT));
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  EXPECT_EQ(handhold_get_frame(localizer.get(), nullptr, sizeof frame), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get_funnel(localizer.get(), nullptr, sizeof(handhold_funnel)), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get_times(localizer.get(), nullptr, sizeof(handhold_times)), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get_handles(localizer.get(), 0, 1, nullptr, sizeof(handhold_handle)), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_get_handles(localizer.get(), 0, 0, nullptr, sizeof(handhold_handle)), HANDHOLD_OK);
  EXPECT_EQ(handhold_get_affordances(localizer.get(), 0, 1, nullptr, sizeof(handhold_affordance)),
            HANDHOLD_NULL_ARGUMENT);
}

TEST(CMistakes, AnotherObjectIsACode) {
  const Options_ options = make_options();
  const Localizer_ localizer = make_localizer();
  auto* no_localizer = reinterpret_cast<handhold_localizer*>(options.get());
  auto* no_options = reinterpret_cast<handhold_options*>(localizer.get());
  const handhold_cloud cloud = c_view(table_scene());
  handhold_localizer* made = nullptr;
  handhold_frame frame;
  EXPECT_EQ(handhold_localize(no_localizer, &cloud, sizeof cloud), HANDHOLD_BAD_OBJECT);
  EXPECT_EQ(handhold_get_frame(no_localizer, &frame, sizeof frame), HANDHOLD_BAD_OBJECT);
  EXPECT_STREQ(handhold_localizer_message(no_localizer), handhold_code_text(HANDHOLD_BAD_OBJECT));
  EXPECT_EQ(handhold_set(no_options, "samples", "1"), HANDHOLD_BAD_OBJECT);
  EXPECT_EQ(handhold_options_reset(no_options, nullptr), HANDHOLD_BAD_OBJECT);
  EXPECT_STREQ(handhold_options_message(no_options), handhold_code_text(HANDHOLD_BAD_OBJECT));
  EXPECT_EQ(handhold_localizer_create(no_options, &made), HANDHOLD_BAD_OBJECT);
  EXPECT_EQ(made, nullptr);
  handhold_localizer_destroy(no_localizer);  // does nothing
  handhold_options_destroy(no_options);
  EXPECT_EQ(handhold_set(options.get(), "samples", "1"), HANDHOLD_OK);
  EXPECT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
}

TEST(CMistakes, CloudsThatContradictThemselvesLeaveNoResult) {
  const Localizer_ localizer = make_localizer();
  const handhold_cloud good = c_view(table_scene());
  handhold_frame frame;
  EXPECT_EQ(handhold_get_frame(localizer.get(), &frame, sizeof frame), HANDHOLD_NO_FRAME);
  const auto refused = [&](const char* message, auto&& spoil) {
    ASSERT_EQ(handhold_localize(localizer.get(), &good, sizeof good), HANDHOLD_OK);
    handhold_cloud cloud = good;
    spoil(cloud);
    EXPECT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_BAD_CLOUD);
    EXPECT_NE(std::string(handhold_localizer_message(localizer.get())).find(message), std::string::npos)
        << handhold_localizer_message(localizer.get());
    EXPECT_EQ(handhold_get_frame(localizer.get(), &frame, sizeof frame), HANDHOLD_NO_FRAME);
    EXPECT_EQ(handhold_get_handles(localizer.get(), 0, 0, nullptr, sizeof(handhold_handle)), HANDHOLD_NO_FRAME);
  };
  refused("data is null", [](handhold_cloud& c) { c.data = nullptr; });
  refused("point_step = 10", [](handhold_cloud& c) { c.point_step = 10; });
  refused("aligned", [](handhold_cloud& c) {
    c.data = reinterpret_cast<const float*>(reinterpret_cast<const char*>(c.data) + 2);
  });
  refused("no_viewpoint = 2", [](handhold_cloud& c) { c.no_viewpoint = 2; });
  refused("viewpoint", [](handhold_cloud& c) { c.viewpoint[1] = std::numeric_limits<double>::infinity(); });
  refused("fewer than 2^31", [](handhold_cloud& c) { c.width = c.height = 1u << 20; });
  // The localizer is as good as new.
  ASSERT_EQ(handhold_localize(localizer.get(), &good, sizeof good), HANDHOLD_OK);
  EXPECT_STREQ(handhold_localizer_message(localizer.get()), "");
  expect_same(localizer.get(), Localizer().localize(table_scene().view()));
}

TEST(CMistakes, IndicesBeyondTheLastAreACode) {
  const Localizer_ localizer = make_localizer();
  const handhold_cloud cloud = c_view(table_scene());
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  const std::size_t n = frame_of(localizer.get()).handles, all = std::numeric_limits<std::size_t>::max();
  std::vector<handhold_handle> handles(n + 1);
  const auto get = [&](std::size_t first, std::size_t count) {
    return handhold_get_handles(localizer.get(), first, count, handles.data(), sizeof(handhold_handle));
  };
  ASSERT_GT(n, 1u);
  EXPECT_EQ(get(0, n), HANDHOLD_OK);
  EXPECT_EQ(get(n, 0), HANDHOLD_OK);
  EXPECT_EQ(get(1, n - 1), HANDHOLD_OK);
  EXPECT_EQ(get(0, n + 1), HANDHOLD_BAD_INDEX);
  EXPECT_EQ(get(n, 1), HANDHOLD_BAD_INDEX);
  EXPECT_EQ(get(n + 1, 0), HANDHOLD_BAD_INDEX);
  EXPECT_EQ(get(1, all), HANDHOLD_BAD_INDEX);
  EXPECT_EQ(get(all, 1), HANDHOLD_BAD_INDEX);
  handhold_affordance affordance;
  EXPECT_EQ(handhold_get_affordances(localizer.get(), frame_of(localizer.get()).affordances, 1, &affordance,
                                     sizeof affordance),
            HANDHOLD_BAD_INDEX);
}

TEST(CMistakes, MissingMemoryIsACode) {
  // Of every call, each allocation fails once.
  const auto failures = [](auto&& call) {
    int n = 0;
    for (handhold_code code = HANDHOLD_NO_MEMORY; code != HANDHOLD_OK; ++n) {
      allocations_left = n;
      code = call();
      allocations_left = -1;
      if (code != HANDHOLD_OK) {
        EXPECT_EQ(code, HANDHOLD_NO_MEMORY) << "allocation " << n;
      }
      if (n > 100'000) break;
    }
    return n - 1;
  };
  handhold_options* made = nullptr;
  EXPECT_GE(failures([&] { return handhold_options_create(&made); }), 1);
  const Options_ options(made, handhold_options_destroy);
  const char* text = nullptr;
  EXPECT_GE(failures([&] { return handhold_set(options.get(), "radius", "0.01 0.02 0.03 0.04 0.05"); }), 1);
  EXPECT_GE(failures([&] { return handhold_get(options.get(), "radius", &text); }), 1);
  EXPECT_STREQ(text, "0.01 0.02 0.03 0.04 0.05");
  // Embree leaks a few bytes when memory ends inside of it.
  EXPECT_EQ(handhold_set(options.get(), "index", "grid"), HANDHOLD_OK);
  handhold_localizer* localizer = nullptr;
  EXPECT_GE(failures([&] { return handhold_localizer_create(options.get(), &localizer); }), 1);
  handhold_localizer_destroy(localizer);
}

TEST(CMistakes, MissingMemoryInAFrameIsACode) {
  const Options_ options = make_options();
  // One thread, because allocations are counted on this one; the grid, because Embree leaks a few bytes.
  for (const auto& [name, value] : {std::pair{"threads", "1"}, {"index", "grid"}, {"samples", "300"}}) {
    ASSERT_EQ(handhold_set(options.get(), name, value), HANDHOLD_OK);
  }
  const handhold_cloud cloud = c_view(table_scene());
  handhold_frame frame;
  int failures = 0;
  for (handhold_code code = HANDHOLD_NO_MEMORY; code != HANDHOLD_OK; ++failures) {
    const Localizer_ localizer = make_localizer(options.get());
    allocations_left = 37 * failures;
    code = handhold_localize(localizer.get(), &cloud, sizeof cloud);
    allocations_left = -1;
    if (code == HANDHOLD_OK) break;
    ASSERT_EQ(code, HANDHOLD_NO_MEMORY);
    EXPECT_STREQ(handhold_localizer_message(localizer.get()), "out of memory");
    EXPECT_EQ(handhold_get_frame(localizer.get(), &frame, sizeof frame), HANDHOLD_NO_FRAME);
  }
  EXPECT_GE(failures, 1);
}

// ---- Growth --------------------------------------------------------------------------------------------------------

TEST(CGrowth, StructsOfOtherVersionsAreRead) {
  struct Newer {
    handhold_cloud cloud;
    double added;
  };
  const Localizer_ localizer = make_localizer();
  Newer newer = {c_view(table_scene()), 0};
  EXPECT_EQ(handhold_localize(localizer.get(), &newer.cloud, sizeof newer), HANDHOLD_OK);
  expect_same(localizer.get(), Localizer().localize(table_scene().view()));
  newer.added = 1;  // means something that this library does not know
  EXPECT_EQ(handhold_localize(localizer.get(), &newer.cloud, sizeof newer), HANDHOLD_BAD_SIZE);
  EXPECT_STREQ(handhold_localizer_message(localizer.get()), handhold_code_text(HANDHOLD_BAD_SIZE));
  for (const std::size_t size : {std::size_t{0}, std::size_t{8}, sizeof(handhold_cloud) - 1, ~std::size_t{0}}) {
    EXPECT_EQ(handhold_localize(localizer.get(), &newer.cloud, size), HANDHOLD_BAD_SIZE) << size;
  }
}

TEST(CGrowth, StructsOfOtherVersionsAreWritten) {
  struct Newer {
    handhold_handle handle;
    double added = -1;
  };
  const Localizer_ localizer = make_localizer();
  const handhold_cloud cloud = c_view(table_scene());
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  const std::vector<handhold_handle> handles = handles_of(localizer.get());
  std::vector<Newer> newer(handles.size());
  ASSERT_EQ(handhold_get_handles(localizer.get(), 0, newer.size(), &newer.data()->handle, sizeof(Newer)), HANDHOLD_OK);
  for (std::size_t i = 0; i < handles.size(); ++i) {
    EXPECT_EQ(vector(newer[i].handle.center), vector(handles[i].center));
    EXPECT_EQ(newer[i].handle.affordances, handles[i].affordances);
    EXPECT_EQ(newer[i].added, 0) << "what the library does not know is zero";
  }

  const auto refused = [&](auto value, auto&& get) {
    for (const std::size_t size : {std::size_t{0}, sizeof value - 1, std::size_t{5000}, ~std::size_t{0}}) {
      EXPECT_EQ(get(&value, size), HANDHOLD_BAD_SIZE) << size;
    }
  };
  const handhold_localizer* l = localizer.get();
  refused(handhold_frame{}, [l](auto* to, std::size_t size) { return handhold_get_frame(l, to, size); });
  refused(handhold_funnel{}, [l](auto* to, std::size_t size) { return handhold_get_funnel(l, to, size); });
  refused(handhold_times{}, [l](auto* to, std::size_t size) { return handhold_get_times(l, to, size); });
  refused(handhold_handle{}, [l](auto* to, std::size_t size) { return handhold_get_handles(l, 0, 1, to, size); });
  refused(handhold_affordance{},
          [l](auto* to, std::size_t size) { return handhold_get_affordances(l, 0, 1, to, size); });
}

// ---- Threads -------------------------------------------------------------------------------------------------------

TEST(CThreads, TwoLocalizersAtOnce) {
  std::vector<Result> expected;
  for (const std::uint64_t seed : {1, 2}) {
    Options options;
    options.seed = seed;
    options.samples = 1000;
    expected.push_back(Localizer(options).localize(table_scene().view()));
  }
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < 2; ++i) {
    threads.emplace_back([&expected, i] {
      const Options_ options = make_options();
      EXPECT_EQ(handhold_set(options.get(), "seed", i == 0 ? "1" : "2"), HANDHOLD_OK);
      EXPECT_EQ(handhold_set(options.get(), "samples", "1000"), HANDHOLD_OK);
      EXPECT_EQ(handhold_set(options.get(), "threads", "2"), HANDHOLD_OK);
      const Localizer_ localizer = make_localizer(options.get());
      const handhold_cloud cloud = c_view(table_scene());
      for (int frame = 0; frame < 3; ++frame) {
        EXPECT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
        expect_same(localizer.get(), expected[i]);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(CThreads, OneLocalizerTwiceAtOnceIsACode) {
  const Localizer_ localizer = make_localizer();
  const handhold_cloud cloud = c_view(table_scene());
  std::atomic<bool> refused{false};
  const auto search = [&] {
    while (!refused) {
      const handhold_code code = handhold_localize(localizer.get(), &cloud, sizeof cloud);
      if (code == HANDHOLD_BUSY) refused = true;
      EXPECT_TRUE(code == HANDHOLD_OK || code == HANDHOLD_BUSY) << handhold_code_text(code);
    }
  };
  std::thread other(search);
  search();
  other.join();
  expect_same(localizer.get(), Localizer().localize(table_scene().view()));
}

TEST(CThreads, AResultThatIsBeingMadeIsACode) {
  const Localizer_ localizer = make_localizer();
  const handhold_cloud cloud = c_view(table_scene());
  std::atomic<bool> seen{false};
  std::thread other([&] {
    while (!seen) EXPECT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  });
  handhold_frame frame;
  while (handhold_get_frame(localizer.get(), &frame, sizeof frame) != HANDHOLD_BUSY) std::this_thread::yield();
  seen = true;
  other.join();
  EXPECT_EQ(handhold_get_frame(localizer.get(), &frame, sizeof frame), HANDHOLD_OK);
}

TEST(CThreads, AnotherMayCancel) {
  const Options_ options = make_options();
  ASSERT_EQ(handhold_set(options.get(), "samples", "20000"), HANDHOLD_OK);  // long enough to be met
  const Localizer_ localizer = make_localizer(options.get());
  const handhold_cloud cloud = c_view(table_scene());
  EXPECT_EQ(handhold_cancel(nullptr), HANDHOLD_NULL_ARGUMENT);
  EXPECT_EQ(handhold_cancel(reinterpret_cast<handhold_localizer*>(options.get())), HANDHOLD_BAD_OBJECT);
  EXPECT_EQ(handhold_cancel(localizer.get()), HANDHOLD_OK);
  std::atomic<bool> over{false};
  std::thread other([&] {
    while (!over) EXPECT_EQ(handhold_cancel(localizer.get()), HANDHOLD_OK), std::this_thread::yield();
  });
  EXPECT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  over = true;
  other.join();
  EXPECT_EQ(frame_of(localizer.get()).status, HANDHOLD_STATUS_CANCELLED);
  EXPECT_EQ(frame_of(localizer.get()).handles, 0u);
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  EXPECT_EQ(frame_of(localizer.get()).status, HANDHOLD_STATUS_OK);
}

TEST(CThreads, SeveralReadOneResult) {
  const Localizer_ localizer = make_localizer();
  const handhold_cloud cloud = c_view(table_scene());
  ASSERT_EQ(handhold_localize(localizer.get(), &cloud, sizeof cloud), HANDHOLD_OK);
  const Result expected = Localizer().localize(table_scene().view());
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) threads.emplace_back([&] { expect_same(localizer.get(), expected); });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace handhold
