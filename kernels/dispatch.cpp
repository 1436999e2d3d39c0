// Picks the instruction set, once.
#include <cstdlib>
#include <cstring>

#include "kernels.h"

namespace handhold {

namespace lane_scalar {
void fill_table(kernels::Kernels&);
}
namespace lane_avx2 {
void fill_table(kernels::Kernels&);
}
namespace lane_avx512 {
void fill_table(kernels::Kernels&);
}
namespace lane_neon {
void fill_table(kernels::Kernels&);
}

namespace kernels {
namespace {

struct Choice {
  Kernels tables[4] = {};
  const char* names[4] = {};
  int count = 0;
  const Kernels* chosen = nullptr;
  char error[160] = {};

  void add(void (*fill)(Kernels&)) {
    fill(tables[count]);
    names[count] = tables[count].name;
    ++count;
  }
  const Kernels* find(const char* name) const {
    for (int i = 0; i < count; ++i) {
      if (std::strcmp(names[i], name) == 0) return &tables[i];
    }
    return nullptr;
  }
  void append(const char* text) { std::strncat(error, text, sizeof error - std::strlen(error) - 1); }

  Choice() {
#if defined(HANDHOLD_HAVE_AVX512)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) {
      add(lane_avx512::fill_table);
    }
#endif
#if defined(HANDHOLD_HAVE_AVX2)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
        __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt")) {
      add(lane_avx2::fill_table);
    }
#endif
#if defined(HANDHOLD_HAVE_NEON)
    add(lane_neon::fill_table);
#endif
    add(lane_scalar::fill_table);
    chosen = &tables[0];
    const char* wanted = std::getenv("HANDHOLD_ISA");
    if (!wanted || !*wanted) return;
    if (const Kernels* table = find(wanted)) {
      chosen = table;
      return;
    }
    append("HANDHOLD_ISA=");
    std::strncat(error, wanted, 40);
    append(" is not available on this machine; it runs");
    for (int i = 0; i < count; ++i) append(i ? ", " : " "), append(names[i]);
  }
};

const Choice& choice() {
  static const Choice c;
  return c;
}

constexpr std::size_t padded(std::size_t bytes) {
  return (bytes + 63) / 64 * 64;
}

}  // namespace

const Kernels& kernels() {
  return *choice().chosen;
}
const Kernels* kernels(const char* name) {
  return choice().find(name);
}
const char* const* available(int* count) {
  *count = choice().count;
  return choice().names;
}
const char* isa_error() {
  return choice().error[0] ? choice().error : nullptr;
}

std::size_t scratch_bytes(std::int32_t blocks) {
  const std::size_t n = static_cast<std::size_t>(blocks < 1 ? 1 : blocks);
  // Moments: a fixed part, then sixteen lists of blocks and two of tiles. Shell: a list of tiles and a float a point.
  // n blocks give at most n + 15 padded candidates, and a list is written 16 entries at a time.
  const std::size_t moments = 64 * 1024 + (16 + 2 * 16) * (n + 31) * sizeof(std::uint32_t);
  const std::size_t shell = (16 * n + 16) * sizeof(std::uint32_t) + (256 * n + 64) * sizeof(float);
  return padded(moments > shell ? moments : shell);
}

}  // namespace kernels
}  // namespace handhold
