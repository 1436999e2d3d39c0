// The interface for C: no mistake of a caller is more than a code and a message, and callers may be older or newer.
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "c_api.h"
#include "handhold/handhold.h"
#include "handhold/localizer.h"

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

namespace handhold::test {
namespace {

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
  EXPECT_STREQ(handhold_localizer_backend(nullptr), handhold_code_text(HANDHOLD_NULL_ARGUMENT));
  EXPECT_STREQ(handhold_localizer_backend_reason(nullptr), handhold_code_text(HANDHOLD_NULL_ARGUMENT));

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
  EXPECT_STREQ(handhold_localizer_backend(no_localizer), handhold_code_text(HANDHOLD_BAD_OBJECT));
  EXPECT_STREQ(handhold_localizer_backend_reason(no_localizer), handhold_code_text(HANDHOLD_BAD_OBJECT));
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
  // TBB waits for ever when memory ends while it starts: it has started before.
  const Localizer_ first = make_localizer();
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

}  // namespace
}  // namespace handhold::test
