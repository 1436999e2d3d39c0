// State between calls: a race, even when nobody outside can see it.
namespace handhold::lane_avx2 {
int count() {
  static int calls = 0;
  return ++calls;
}
}  // namespace handhold::lane_avx2
