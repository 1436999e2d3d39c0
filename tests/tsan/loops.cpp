// Parallel loops that the thread sanitizer must accept ("ordered") and must refuse ("racy").
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstdio>
#include <string_view>
#include <thread>
#include <vector>

namespace {

constexpr int kValues = 20000;

/// Everything here is ordered by TBB's own guarantees.
bool ordered() {
  bool right = true;
  for (int repeat = 0; repeat < 20; ++repeat) {
    std::vector<int> values(kValues);
    tbb::enumerable_thread_specific<std::vector<int>> seen;
    tbb::task_arena arena(2);
    arena.execute([&] {
      tbb::parallel_for(0, kValues, [&](int i) {
        values[i] = (i * 7919) % kValues;
        seen.local().push_back(i);
      });
      tbb::parallel_sort(values.begin(), values.end());
    });
    std::size_t count = 0;
    for (const std::vector<int>& part : seen) count += part.size();
    using Range = tbb::blocked_range<int>;
    tbb::parallel_for(
        Range(0, kValues),
        [&](const Range& range) {
          for (int i = range.begin(); i < range.end(); ++i) values[i] += 1;
        },
        tbb::static_partitioner());
    const long sum = tbb::parallel_reduce(
        Range(0, kValues), 0L,
        [&](const Range& range, long part) {
          for (int i = range.begin(); i < range.end(); ++i) part += values[i];
          return part;
        },
        [](long a, long b) { return a + b; });
    right = right && count == kValues && sum == static_cast<long>(kValues) * (kValues + 1) / 2;
  }
  return right;
}

/// Two threads add to one number. Each step lasts long enough for a second thread to join in.
void racy() {
  long sum = 0;
  tbb::parallel_for(0, 64, [&](int i) {
    sum += i;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  std::printf("sum %ld\n", sum);
}

}  // namespace

int main(int argc, char** argv) {
  // also on a machine with one core
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 2);
  if (argc == 2 && std::string_view(argv[1]) == "racy") {
    racy();
    return 0;
  }
  return ordered() ? 0 : 1;
}
