// Tells the thread sanitizer what TBB guarantees.
//
// The sanitizer sees only code that was compiled for it. A distribution's libtbb was not, so the order it establishes
// (what is written before a task is spawned is seen by the task; what a task wrote is seen after the wait) stays
// invisible, and every parallel loop looks like a race. This library stands before libtbb in the order in which symbols
// are looked up, passes each call on, and reports that order. Only what parallel algorithms and arenas call is covered:
// not enqueue, not flow graphs.
#include <dlfcn.h>
#include <oneapi/tbb/detail/_small_object_pool.h>
#include <oneapi/tbb/detail/_task.h>
#include <oneapi/tbb/task_arena.h>

#include <cstddef>
#include <cstdint>

extern "C" void __tsan_acquire(void* address);
extern "C" void __tsan_release(void* address);

namespace tbb::detail {
namespace {

template <class Function>
Function* next(const char* mangled_name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, mangled_name));
}

/// Stands in for a task between spawning and running it.
class SpawnedTask final : public d1::task {
 public:
  explicit SpawnedTask(d1::task& inner) : inner_(inner) { __tsan_release(this); }
  d1::task* execute(d1::execution_data& data) override {
    __tsan_acquire(this);
    d1::task* successor = inner_.execute(data);
    delete this;
    return successor;
  }
  d1::task* cancel(d1::execution_data& data) override {
    __tsan_acquire(this);
    d1::task* successor = inner_.cancel(data);
    delete this;
    return successor;
  }

 private:
  d1::task& inner_;
};

/// Work that an arena may hand to another thread.
class ArenaWork final : public d1::delegate_base {
 public:
  explicit ArenaWork(d1::delegate_base& inner) : inner_(inner) { __tsan_release(address()); }
  bool operator()() const override {
    __tsan_acquire(address());
    const bool result = inner_();
    __tsan_release(address());
    return result;
  }
  void* address() const { return const_cast<ArenaWork*>(this); }

 private:
  d1::delegate_base& inner_;
};

/// A task that ends counts down in the header, in code that the sanitizer sees; the wait that reads the counter is
/// libtbb's. The counter follows a word of flags.
void* counter(d1::wait_context& context) {
  return reinterpret_cast<char*>(&context) + sizeof(std::uint64_t);
}
static_assert(sizeof(d1::wait_context) == 2 * sizeof(std::uint64_t), "another TBB: look where its counter is");

}  // namespace

namespace r1 {

void spawn(d1::task& task, d1::task_group_context& context) {
  static const auto real = next<void(d1::task&, d1::task_group_context&)>(
      "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextE");
  real(*new SpawnedTask(task), context);
}
void spawn(d1::task& task, d1::task_group_context& context, d1::slot_id slot) {
  static const auto real = next<void(d1::task&, d1::task_group_context&, d1::slot_id)>(
      "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextEt");
  real(*new SpawnedTask(task), context, slot);
}
void execute_and_wait(d1::task& task, d1::task_group_context& context, d1::wait_context& wait_context,
                      d1::task_group_context& wait_group) {
  static const auto real = next<void(d1::task&, d1::task_group_context&, d1::wait_context&, d1::task_group_context&)>(
      "_ZN3tbb6detail2r116execute_and_waitERNS0_2d14taskERNS2_18task_group_contextERNS2_12wait_contextES6_");
  real(task, context, wait_context, wait_group);
  __tsan_acquire(counter(wait_context));
}
void wait(d1::wait_context& wait_context, d1::task_group_context& group) {
  static const auto real = next<void(d1::wait_context&, d1::task_group_context&)>(
      "_ZN3tbb6detail2r14waitERNS0_2d112wait_contextERNS2_18task_group_contextE");
  real(wait_context, group);
  __tsan_acquire(counter(wait_context));
}
void execute(d1::task_arena_base& arena, d1::delegate_base& delegate) {
  static const auto real = next<void(d1::task_arena_base&, d1::delegate_base&)>(
      "_ZN3tbb6detail2r17executeERNS0_2d115task_arena_baseERNS2_13delegate_baseE");
  ArenaWork work(delegate);
  real(arena, work);
  __tsan_acquire(work.address());
}

// TBB's own pool hands a block from thread to thread: what the last owner did with it is over when the next one gets
// it.
void* allocate(d1::small_object_pool*& pool, std::size_t bytes, const d1::execution_data& data) {
  static const auto real = next<void*(d1::small_object_pool*&, std::size_t, const d1::execution_data&)>(
      "_ZN3tbb6detail2r18allocateERPNS0_2d117small_object_poolEmRKNS2_14execution_dataE");
  void* memory = real(pool, bytes, data);
  __tsan_acquire(memory);
  return memory;
}
void* allocate(d1::small_object_pool*& pool, std::size_t bytes) {
  static const auto real =
      next<void*(d1::small_object_pool*&, std::size_t)>("_ZN3tbb6detail2r18allocateERPNS0_2d117small_object_poolEm");
  void* memory = real(pool, bytes);
  __tsan_acquire(memory);
  return memory;
}
void deallocate(d1::small_object_pool& pool, void* memory, std::size_t bytes, const d1::execution_data& data) {
  static const auto real = next<void(d1::small_object_pool&, void*, std::size_t, const d1::execution_data&)>(
      "_ZN3tbb6detail2r110deallocateERNS0_2d117small_object_poolEPvmRKNS2_14execution_dataE");
  __tsan_release(memory);
  real(pool, memory, bytes, data);
}
void deallocate(d1::small_object_pool& pool, void* memory, std::size_t bytes) {
  static const auto real = next<void(d1::small_object_pool&, void*, std::size_t)>(
      "_ZN3tbb6detail2r110deallocateERNS0_2d117small_object_poolEPvm");
  __tsan_release(memory);
  real(pool, memory, bytes);
}

}  // namespace r1
}  // namespace tbb::detail
