// What an object of an instruction set looks like: nothing that check_objects.cmake may refuse.
#include <cstddef>

namespace handhold::lane_avx2 {
namespace {
const float kCoefficients[4] = {1, 2, 3, 4};
}

float sum(const float* values, std::size_t n) {
  float result = kCoefficients[n & 3];
  for (std::size_t i = 0; i < n; ++i) result += values[i];
  return result;
}

struct Table {
  const char* name;
  float (*sum)(const float*, std::size_t);
};
const Table kTable = {"avx2", sum};  // holds addresses: stands in .data.rel.ro
}  // namespace handhold::lane_avx2

namespace handhold::kernels {
const void* table_avx2() {
  return &lane_avx2::kTable;
}
}  // namespace handhold::kernels
