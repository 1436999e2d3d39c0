// Packs for any machine, in the compiler's own vectors of 16 bytes: 4 floats, 2 doubles, baseline instructions only.
// There is no fused multiply-add here: emulating one would cost a library call a number. Included by lane.h.
#pragma once

namespace handhold::HANDHOLD_LANE {

typedef float Float4 __attribute__((vector_size(16), may_alias));
typedef double Double2 __attribute__((vector_size(16), may_alias));
typedef std::int32_t Int4 __attribute__((vector_size(16)));
typedef std::int64_t Long2 __attribute__((vector_size(16)));

template <>
struct Mask<float, 4> {
  Int4 m;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {a.m & b.m}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {a.m | b.m}; }
  friend LANE_FN Mask operator~(Mask a) { return {~a.m}; }
  friend LANE_FN std::uint32_t bits(Mask a) {
    return static_cast<std::uint32_t>((a.m[0] & 1) | (a.m[1] & 2) | (a.m[2] & 4) | (a.m[3] & 8));
  }
  friend LANE_FN bool any(Mask a) { return (a.m[0] | a.m[1] | a.m[2] | a.m[3]) != 0; }
};
template <>
struct Mask<double, 2> {
  Long2 m;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {a.m & b.m}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {a.m | b.m}; }
  friend LANE_FN Mask operator~(Mask a) { return {~a.m}; }
  friend LANE_FN std::uint32_t bits(Mask a) { return static_cast<std::uint32_t>((a.m[0] & 1) | (a.m[1] & 2)); }
  friend LANE_FN bool any(Mask a) { return (a.m[0] | a.m[1]) != 0; }
};

template <>
struct Vec<float, 4> {
  using M = Mask<float, 4>;
  Float4 v;
  Vec() = default;
  LANE_FN Vec(float s) : v{s, s, s, s} {}
  LANE_FN Vec(Float4 x) : v(x) {}
  static LANE_FN Vec load(const float* p) { return *reinterpret_cast<const Float4*>(p); }
  static LANE_FN Vec loadu(const float* p) { return Float4{p[0], p[1], p[2], p[3]}; }
  LANE_FN void store(float* p) const { *reinterpret_cast<Float4*>(p) = v; }
  LANE_FN void storeu(float* p) const { p[0] = v[0], p[1] = v[1], p[2] = v[2], p[3] = v[3]; }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return a.v + b.v; }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return a.v - b.v; }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return a.v * b.v; }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return a.v / b.v; }
  friend LANE_FN Vec operator-(Vec a) { return -a.v; }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return a.v * b.v + c.v; }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return c.v - a.v * b.v; }
  friend LANE_FN Vec sqrt(Vec a) {
    return Float4{__builtin_sqrtf(a.v[0]), __builtin_sqrtf(a.v[1]), __builtin_sqrtf(a.v[2]), __builtin_sqrtf(a.v[3])};
  }
  friend LANE_FN Vec abs(Vec a) { return (Float4)((Int4)a.v & Int4{0x7fffffff, 0x7fffffff, 0x7fffffff, 0x7fffffff}); }
  friend LANE_FN Vec min(Vec a, Vec b) { return a.v < b.v ? a.v : b.v; }
  friend LANE_FN Vec max(Vec a, Vec b) { return a.v > b.v ? a.v : b.v; }
  friend LANE_FN M operator<(Vec a, Vec b) { return {a.v < b.v}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {a.v <= b.v}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {a.v > b.v}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {a.v >= b.v}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return m.m ? a.v : b.v; }
  friend LANE_FN float reduce_add(Vec a) { return (a.v[0] + a.v[2]) + (a.v[1] + a.v[3]); }
  friend LANE_FN float reduce_min(Vec a) {
    const float x = a.v[0] < a.v[1] ? a.v[0] : a.v[1], y = a.v[2] < a.v[3] ? a.v[2] : a.v[3];
    return x < y ? x : y;
  }
  friend LANE_FN float reduce_max(Vec a) {
    const float x = a.v[0] > a.v[1] ? a.v[0] : a.v[1], y = a.v[2] > a.v[3] ? a.v[2] : a.v[3];
    return x > y ? x : y;
  }
  friend LANE_FN Vec gather(const float* p, Vec column, Vec row, std::int32_t width) {
    const auto pixel = [&](int i) LANE_INLINE {
      return p[static_cast<std::int32_t>(row.v[i]) * width + static_cast<std::int32_t>(column.v[i])];
    };
    return Float4{pixel(0), pixel(1), pixel(2), pixel(3)};
  }
  friend LANE_FN int compress_store(float* p, M m, Vec a) {
    int n = 0;
    p[n] = a.v[0], n += m.m[0] & 1;
    p[n] = a.v[1], n += m.m[1] & 1;
    p[n] = a.v[2], n += m.m[2] & 1;
    p[n] = a.v[3], n += m.m[3] & 1;
    return n;
  }
};

template <>
struct Vec<double, 2> {
  using M = Mask<double, 2>;
  Double2 v;
  Vec() = default;
  LANE_FN Vec(double s) : v{s, s} {}
  LANE_FN Vec(Double2 x) : v(x) {}
  static LANE_FN Vec load(const double* p) { return *reinterpret_cast<const Double2*>(p); }
  static LANE_FN Vec loadu(const double* p) { return Double2{p[0], p[1]}; }
  LANE_FN void store(double* p) const { *reinterpret_cast<Double2*>(p) = v; }
  LANE_FN void storeu(double* p) const { p[0] = v[0], p[1] = v[1]; }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return a.v + b.v; }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return a.v - b.v; }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return a.v * b.v; }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return a.v / b.v; }
  friend LANE_FN Vec operator-(Vec a) { return -a.v; }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return a.v * b.v + c.v; }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return c.v - a.v * b.v; }
  friend LANE_FN Vec sqrt(Vec a) { return Double2{__builtin_sqrt(a.v[0]), __builtin_sqrt(a.v[1])}; }
  friend LANE_FN Vec abs(Vec a) { return (Double2)((Long2)a.v & Long2{0x7fffffffffffffff, 0x7fffffffffffffff}); }
  friend LANE_FN Vec min(Vec a, Vec b) { return a.v < b.v ? a.v : b.v; }
  friend LANE_FN Vec max(Vec a, Vec b) { return a.v > b.v ? a.v : b.v; }
  friend LANE_FN M operator<(Vec a, Vec b) { return {a.v < b.v}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {a.v <= b.v}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {a.v > b.v}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {a.v >= b.v}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return m.m ? a.v : b.v; }
};

}  // namespace handhold::HANDHOLD_LANE
