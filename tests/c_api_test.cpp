// The interface for C gives what C++ gives: names, options, numbers, threads.
#include "c_api.h"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "handhold/handhold.h"
#include "handhold/localizer.h"
#include "handhold/option_text.h"

namespace handhold::test {
namespace {

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

TEST(COptions, ABackendIsHadOrRefusedAsInCpp) {
  const Options_ options = make_options();
  EXPECT_EQ(handhold_set(options.get(), "backend", "gpu"), HANDHOLD_BAD_OPTION);
  EXPECT_STREQ(handhold_options_message(options.get()), "backend = 'gpu': must be one of 'cpu', 'cuda', 'auto'");
  for (const char* name : {"cpu", "auto", "cuda"}) {
    ASSERT_EQ(handhold_set(options.get(), "backend", name), HANDHOLD_OK);
    Options same;
    set_option(same, "backend", name);
    handhold_localizer* made = nullptr;
    const handhold_code code = handhold_localizer_create(options.get(), &made);
    const Localizer_ localizer(made, handhold_localizer_destroy);
    try {
      const Localizer expected(same);
      ASSERT_EQ(code, HANDHOLD_OK) << name;
      EXPECT_EQ(handhold_localizer_backend(made), to_string(expected.backend()));
      EXPECT_EQ(handhold_localizer_backend_reason(made), expected.backend_reason());
    } catch (const OptionError& error) {
      EXPECT_STREQ(name, "cuda");
      EXPECT_EQ(code, HANDHOLD_BAD_OPTION);
      EXPECT_EQ(made, nullptr);
      EXPECT_STREQ(handhold_options_message(options.get()), error.what());
    }
  }
  const Localizer_ standard = make_localizer();
  EXPECT_STREQ(handhold_localizer_backend(standard.get()), "cpu");
  EXPECT_STREQ(handhold_localizer_backend_reason(standard.get()), "");
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
    handhold_code code = HANDHOLD_OK;
    while (!seen || code != HANDHOLD_OK) {
      code = handhold_localize(localizer.get(), &cloud, sizeof cloud);
      // Busy: the other thread was reading just then.
      EXPECT_TRUE(code == HANDHOLD_OK || code == HANDHOLD_BUSY) << handhold_code_text(code);
    }
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
}  // namespace handhold::test
