// After some frames a frame of the same size allocates nothing: every allocation in this program is counted, and which
// library asked for it. Memory that libraries get past operator new and aligned_alloc (TBB's, Embree's own pools) is
// not seen here.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "demo_cloud.h"
#include "handhold/localizer.h"
#include "handhold/sensor.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HANDHOLD_COUNTS_NOTHING  // the sanitizers count for themselves
#endif

namespace {

std::atomic<bool> counting{false};
std::atomic<long> ours{0}, others{0};

/// `caller`: where the allocation was asked for. What a library on the way - the C++ library, say - asks for counts as
/// another's.
void count(const void* caller) {
  if (!counting.load(std::memory_order_relaxed)) return;
  Dl_info here{}, there{};
  const bool ours_called = ::dladdr(reinterpret_cast<const void*>(&count), &here) && ::dladdr(caller, &there) &&
                           (here.dli_fbase == there.dli_fbase || std::strstr(there.dli_fname, "libhandhold"));
  ++(ours_called ? ours : others);
}

}  // namespace

#ifndef HANDHOLD_COUNTS_NOTHING
void* operator new(std::size_t n) {
  count(__builtin_return_address(0));
  if (void* p = std::malloc(n ? n : 1)) return p;
  throw std::bad_alloc();
}
void* operator new[](std::size_t n) {
  count(__builtin_return_address(0));
  if (void* p = std::malloc(n ? n : 1)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t n, std::align_val_t alignment) {
  count(__builtin_return_address(0));
  void* p = nullptr;
  if (::posix_memalign(&p, static_cast<std::size_t>(alignment), n ? n : 1) == 0) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete[](void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  std::free(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}
/// What the library's aligned arrays use.
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t n) {
  count(__builtin_return_address(0));
  void* p = nullptr;
  return ::posix_memalign(&p, alignment, n) == 0 ? p : nullptr;
}
#endif

namespace handhold {
namespace {

struct Counts {
  long ours, others;
};
Counts frame(Localizer& localizer, const CloudView& cloud, Result& result) {
  ours = others = 0;
  counting = true;
  localizer.localize(cloud, result);
  counting = false;
  return {ours, others};
}

class NoAllocation : public ::testing::Test {
 protected:
  void SetUp() override {
#ifdef HANDHOLD_COUNTS_NOTHING
    GTEST_SKIP() << "sanitizers replace the allocator";
#endif
    // Else the tests below tell nothing.
    counting = true;
    ours = 0;
    delete new int;
    std::free(std::aligned_alloc(64, 128));
    counting = false;
    ASSERT_GE(ours, 1);
  }
};

TEST_F(NoAllocation, InAFrameLikeTheLastOneOnOneThread) {
  const Cloud image = test::demo_cloud();
  Cloud row = image;
  row.width *= row.height, row.height = 1;
  for (const Cloud* cloud : {&image, &static_cast<const Cloud&>(row)})
    for (const Method method : {Method::kDefault, Method::kPaper})
      for (const Strategy strategy : {Strategy::kUniform, Strategy::kMax})
        for (const IndexKind index : {IndexKind::kGrid, IndexKind::kEmbree}) {
          Options options;
          options.method = method, options.strategy = strategy, options.index = index, options.threads = 1;
          options.samples = 2000;
          Localizer localizer(options);
          Result result;
          EXPECT_GT(frame(localizer, cloud->view(), result).ours, 0) << "the first frame takes its memory";
          for (int i = 0; i < 10; ++i) localizer.localize(cloud->view(), result);
          const Counts counts = frame(localizer, cloud->view(), result);
          SCOPED_TRACE(std::string(to_string(method)) + ", " + std::string(to_string(strategy)) + ", " +
                       std::string(to_string(index)) + (cloud == &row ? ", unorganized" : ""));
          EXPECT_EQ(counts.ours, 0);
          if (index == IndexKind::kGrid) {
            EXPECT_EQ(counts.others, 0);
          } else {
            std::printf("Embree allocates %ld times a frame\n", counts.others);
          }
          EXPECT_FALSE(result.affordances.empty());
        }
}

/// Each thread's scratch grows to the largest task that it has met, so it takes more frames until none does.
TEST_F(NoAllocation, InTheLongRunOnSeveralThreads) {
  const Cloud cloud = test::demo_cloud();
  for (const Method method : {Method::kDefault, Method::kPaper}) {
    Options options;
    options.method = method, options.threads = 4, options.samples = 1500;
    Localizer localizer(options);
    Result result;
    int quiet = 0, frames = 0;
    for (; quiet < 5 && frames < 400; ++frames) {
      quiet = frame(localizer, cloud.view(), result).ours == 0 ? quiet + 1 : 0;
    }
    EXPECT_EQ(quiet, 5) << "after " << frames << " frames";
  }
}

}  // namespace
}  // namespace handhold
