// In the namespace of another instruction set.
namespace handhold::lane_avx512 {
float half(float x) {
  return x / 2;
}
}  // namespace handhold::lane_avx512
