// A header's inline function that was not inlined: the classic way in which one instruction set runs another's code.
inline float half(float x) {
  asm("");
  return x / 2;
}

namespace handhold::lane_avx2 {
float (*pick())(float) {
  return half;
}
}  // namespace handhold::lane_avx2
