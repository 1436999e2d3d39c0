// Weak although inside the namespace: two files of one instruction set with different flags would share one copy.
namespace handhold::lane_avx2 {
template <class T>
[[gnu::noinline]] T half(T x) {
  return x / 2;
}
float quarter(float x) {
  return half(half(x));
}
}  // namespace handhold::lane_avx2
