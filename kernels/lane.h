// The number types that the mathematics is written on: one lane (`float`, `double`) or a pack of W of them.
//
// Every kernel is written once on this vocabulary:
//   + - * / unary-   fma(a,b,c) = a*b + c   fnma(a,b,c) = c - a*b   sqrt abs min max
//   < <= > >=        & | on masks           invert(m) any(m) bits(m) select(m, a, b) = m ? a : b
//   load store (aligned) loadu storeu       reduce_add reduce_min reduce_max (a fixed tree)
//   gather(image, column, row, width): pixels of a row-major image; coordinates are not negative, and cut off
//   compress_store(p, m, v): writes the lanes of v where m is set, one after the other; returns their number
// A pack wider than the machine's registers is two packs of half the width, so a kernel's logical width, its partial
// sums and therefore its bits do not depend on the instruction set. min and max return the second operand when the
// comparison fails, also for NaN. A comparison with NaN is false.
//
// All of it lives in a namespace of its own for each instruction set and is force-inlined: a shared inline symbol would
// let the linker pick one instruction set's copy for everyone.
#pragma once

#ifndef HANDHOLD_LANE
#error "define HANDHOLD_LANE as the namespace of this instruction set before including lane.h"
#endif

#include <cstddef>
#include <cstdint>

// Before a loop: at most n rounds, all written out, or a loop that is to stay one.
#define LANE_PRAGMA(text) _Pragma(#text)
#if defined(HANDHOLD_ISA_CUDA)
// Lambdas of device functions are inlined without being asked.
#define LANE_FN __device__ __forceinline__
#define LANE_INLINE
#define LANE_UNROLL(n) LANE_PRAGMA(unroll)
#define LANE_ROLLED LANE_PRAGMA(unroll 1)
#define LANE_SIDE_BY_SIDE LANE_PRAGMA(unroll 4)  ///< so that several rounds' loads are under way at once
#else
#define LANE_FN inline __attribute__((always_inline))
#define LANE_INLINE __attribute__((always_inline))  ///< behind a lambda's parameters
#define LANE_UNROLL(n) LANE_PRAGMA(GCC unroll n)
#define LANE_ROLLED LANE_PRAGMA(GCC unroll 1)
#define LANE_SIDE_BY_SIDE
#endif

namespace handhold::HANDHOLD_LANE {

template <class T, int W>
struct Mask;
template <class T, int W>
struct Vec;

// ---- One lane: the scalar itself ----------------------------------------------------------------------------------

#if defined(HANDHOLD_ISA_CUDA)
// The intrinsics round to nearest, whatever the compiler's flags say.
LANE_FN double sqrt(double a) {
  return __dsqrt_rn(a);
}
LANE_FN float sqrt(float a) {
  return __fsqrt_rn(a);
}
LANE_FN double fma(double a, double b, double c) {
  return __fma_rn(a, b, c);
}
LANE_FN float fma(float a, float b, float c) {
  return __fmaf_rn(a, b, c);
}
LANE_FN double abs(double a) {
  return ::fabs(a);
}
LANE_FN float abs(float a) {
  return ::fabsf(a);
}
LANE_FN int lowest_bit(std::uint32_t mask) {
  return __ffs(static_cast<int>(mask)) - 1;
}
LANE_FN int count_bits(std::uint32_t mask) {
  return __popc(mask);
}
LANE_FN float next_above(float a) {
  return ::nextafterf(a, __int_as_float(0x7f800000));
}
LANE_FN double infinity() {
  return __longlong_as_double(0x7ff0000000000000);
}
#else
LANE_FN double sqrt(double a) {
  return __builtin_sqrt(a);
}
LANE_FN float sqrt(float a) {
  return __builtin_sqrtf(a);
}
#if defined(__FMA__) || defined(__aarch64__)
LANE_FN double fma(double a, double b, double c) {
  return __builtin_fma(a, b, c);
}
LANE_FN float fma(float a, float b, float c) {
  return __builtin_fmaf(a, b, c);
}
#else
LANE_FN double fma(double a, double b, double c) {
  return a * b + c;
}
LANE_FN float fma(float a, float b, float c) {
  return a * b + c;
}
#endif
LANE_FN double abs(double a) {
  return __builtin_fabs(a);
}
LANE_FN float abs(float a) {
  return __builtin_fabsf(a);
}
/// Number of the lowest bit that is set; one must be.
LANE_FN int lowest_bit(std::uint32_t mask) {
  return __builtin_ctz(mask);
}
LANE_FN int count_bits(std::uint32_t mask) {
  return __builtin_popcount(mask);
}
LANE_FN float next_above(float a) {
  return __builtin_nextafterf(a, __builtin_inff());
}
LANE_FN double infinity() {
  return __builtin_inf();
}
#endif
LANE_FN double fnma(double a, double b, double c) {
  return fma(-a, b, c);
}
LANE_FN float fnma(float a, float b, float c) {
  return fma(-a, b, c);
}
template <class R>
LANE_FN R select(bool m, R a, R b) {
  return m ? a : b;
}
LANE_FN bool any(bool m) {
  return m;
}
LANE_FN bool invert(bool m) {
  return !m;
}
LANE_FN double min(double a, double b) {
  return a < b ? a : b;
}
LANE_FN float min(float a, float b) {
  return a < b ? a : b;
}
LANE_FN double max(double a, double b) {
  return a > b ? a : b;
}
LANE_FN float max(float a, float b) {
  return a > b ? a : b;
}

// ---- A pack wider than a register: two of half the width ----------------------------------------------------------

template <class T, int W>
struct Mask {
  Mask<T, W / 2> lo, hi;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {a.lo & b.lo, a.hi & b.hi}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {a.lo | b.lo, a.hi | b.hi}; }
  friend LANE_FN Mask operator~(Mask a) { return {~a.lo, ~a.hi}; }
  friend LANE_FN std::uint32_t bits(Mask a) { return bits(a.lo) | bits(a.hi) << (W / 2); }
  friend LANE_FN bool any(Mask a) { return any(a.lo | a.hi); }
};

template <class T, int W>
struct Vec {
  using M = Mask<T, W>;
  Vec<T, W / 2> lo, hi;
  Vec() = default;
  LANE_FN Vec(T s) : lo(s), hi(s) {}
  LANE_FN Vec(Vec<T, W / 2> l, Vec<T, W / 2> h) : lo(l), hi(h) {}
  static LANE_FN Vec load(const T* p) { return {Vec<T, W / 2>::load(p), Vec<T, W / 2>::load(p + W / 2)}; }
  static LANE_FN Vec loadu(const T* p) { return {Vec<T, W / 2>::loadu(p), Vec<T, W / 2>::loadu(p + W / 2)}; }
  LANE_FN void store(T* p) const { lo.store(p), hi.store(p + W / 2); }
  LANE_FN void storeu(T* p) const { lo.storeu(p), hi.storeu(p + W / 2); }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return {a.lo + b.lo, a.hi + b.hi}; }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return {a.lo - b.lo, a.hi - b.hi}; }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return {a.lo * b.lo, a.hi * b.hi}; }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return {a.lo / b.lo, a.hi / b.hi}; }
  friend LANE_FN Vec operator-(Vec a) { return {-a.lo, -a.hi}; }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return {fma(a.lo, b.lo, c.lo), fma(a.hi, b.hi, c.hi)}; }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return {fnma(a.lo, b.lo, c.lo), fnma(a.hi, b.hi, c.hi)}; }
  friend LANE_FN Vec sqrt(Vec a) { return {sqrt(a.lo), sqrt(a.hi)}; }
  friend LANE_FN Vec abs(Vec a) { return {abs(a.lo), abs(a.hi)}; }
  friend LANE_FN Vec min(Vec a, Vec b) { return {min(a.lo, b.lo), min(a.hi, b.hi)}; }
  friend LANE_FN Vec max(Vec a, Vec b) { return {max(a.lo, b.lo), max(a.hi, b.hi)}; }
  friend LANE_FN M operator<(Vec a, Vec b) { return {a.lo < b.lo, a.hi < b.hi}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {a.lo <= b.lo, a.hi <= b.hi}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {a.lo > b.lo, a.hi > b.hi}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {a.lo >= b.lo, a.hi >= b.hi}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return {select(m.lo, a.lo, b.lo), select(m.hi, a.hi, b.hi)}; }
  friend LANE_FN T reduce_add(Vec a) { return reduce_add(a.lo + a.hi); }
  friend LANE_FN T reduce_min(Vec a) { return reduce_min(min(a.lo, a.hi)); }
  friend LANE_FN T reduce_max(Vec a) { return reduce_max(max(a.lo, a.hi)); }
  friend LANE_FN int compress_store(T* p, M m, Vec a) {
    const int n = compress_store(p, m.lo, a.lo);
    return n + compress_store(p + n, m.hi, a.hi);
  }
  friend LANE_FN Vec gather(const T* p, Vec column, Vec row, std::int32_t width) {
    return {gather(p, column.lo, row.lo, width), gather(p, column.hi, row.hi, width)};
  }
};

}  // namespace handhold::HANDHOLD_LANE

#if defined(HANDHOLD_ISA_CUDA)
#include "lane_cuda.h"
#elif defined(HANDHOLD_ISA_AVX512)
#include "lane_avx512.h"
#elif defined(HANDHOLD_ISA_AVX2)
#include "lane_avx2.h"
#elif defined(HANDHOLD_ISA_NEON)
#include "lane_neon.h"
#else
#include "lane_scalar.h"
#endif

namespace handhold::HANDHOLD_LANE {

using F16 = Vec<float, 16>;
using M16 = Mask<float, 16>;

/// Bits of a mask as a count: the number of lanes set.
LANE_FN int count(M16 m) {
  return count_bits(bits(m));
}

#if !defined(HANDHOLD_ISA_CUDA)
using F8 = Vec<float, 8>;
using D8 = Vec<double, 8>;
using D16 = Vec<double, 16>;

alignas(64) constexpr float kLaneNumbers[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
LANE_FN F16 lane_numbers() {
  return F16::load(kLaneNumbers);
}
#endif

#if defined(HANDHOLD_ISA_AVX512) || defined(HANDHOLD_ISA_CUDA)
inline constexpr int kSumLanes = 16;  ///< lanes of one accumulator: what a register holds
#elif defined(HANDHOLD_ISA_AVX2)
inline constexpr int kSumLanes = 8;
#else
inline constexpr int kSumLanes = 4;
#endif
using Sum = Vec<float, kSumLanes>;

#if !defined(HANDHOLD_ISA_AVX512)
/// a + b where m is set, elsewhere a (which must not be -0).
template <class T, int W>
LANE_FN Vec<T, W> add_where(Mask<T, W> m, Vec<T, W> a, Vec<T, W> b) {
  return a + select(m, b, Vec<T, W>(T(0)));
}
#endif

template <class T, int W>
LANE_FN Mask<T, W> invert(Mask<T, W> m) {
  return ~m;
}

#if !defined(HANDHOLD_ISA_AVX512) && !defined(HANDHOLD_ISA_AVX2) && !defined(HANDHOLD_ISA_CUDA)
/// The sums of sixteen rows, each over its sixteen lanes in the tree of reduce_add. rows: 64-byte aligned.
LANE_FN F16 reduce_rows(const float (*rows)[16]) {
  alignas(64) float sums[16];
  for (int i = 0; i < 16; ++i) sums[i] = reduce_add(F16::load(rows[i]));
  return F16::load(sums);
}

/// Appends base + t for every set bit t of a 16-bit mask; may write 16 entries. Returns the number of bits.
LANE_FN int append_bits(std::uint32_t* list, std::uint32_t mask, std::uint32_t base) {
  int n = 0;
  for (std::uint32_t t = 0; t < 16; ++t) {
    list[n] = base + t;
    n += mask >> t & 1;
  }
  return n;
}

/// Appends ids[t] for every set bit t of a 16-bit mask; may write 16 entries. Returns the number of bits.
LANE_FN int append_selected(std::uint32_t* list, std::uint32_t mask, const std::uint32_t* ids) {
  int n = 0;
  for (std::uint32_t t = 0; t < 16; ++t) {
    list[n] = ids[t];
    n += mask >> t & 1;
  }
  return n;
}
#endif

#if !defined(HANDHOLD_ISA_CUDA)
// Where the threads of a GPU are the lanes, some things are done by one of them, or by all together.

/// A pack of f(0) .. f(15).
template <class F>
LANE_FN F16 by_lane(F&& f) {
  alignas(64) float lanes[16];
  for (std::uint32_t i = 0; i < 16; ++i) lanes[i] = f(i);
  return F16::load(lanes);
}
/// The lanes for which f(lane) holds.
template <class F>
LANE_FN std::uint32_t bits_by_lane(F&& f) {
  std::uint32_t all = 0;
  for (std::uint32_t i = 0; i < 16; ++i) all |= (f(i) ? 1u : 0u) << i;
  return all;
}
/// What one of the lanes holds.
LANE_FN float lane_value(F16 a, std::uint32_t lane) {
  alignas(64) float lanes[16];
  a.store(lanes);
  return lanes[lane];
}
/// Whether this is the one that does what is to be done once.
LANE_FN bool first_lane() {
  return true;
}
/// What a lane has written the others may read.
LANE_FN void pack_sync() {}
/// Adds one to a number that others add to, too; returns what it was.
LANE_FN std::uint32_t add_one(std::uint32_t* number) {
  return (*number)++;
}
LANE_FN void raise(std::uint32_t* number, std::uint32_t to) {
  if (*number < to) *number = to;
}
/// Sixteen numbers, one a lane.
struct LaneWords {
  std::uint32_t word[16];
};
/// Lanes beyond the last are left out.
LANE_FN void set_lane(LaneWords& words, int lane, std::uint32_t to) {
  if (lane < 16) words.word[lane] = to;
}
LANE_FN std::uint32_t get_lane(const LaneWords& words, int lane) {
  return words.word[lane];
}
LANE_FN void store_lanes(std::uint32_t* to, const LaneWords& words) {
  for (int i = 0; i < 16; ++i) to[i] = words.word[i];
}
LANE_FN void load_lanes(const std::uint32_t* from, LaneWords& words) {
  for (int i = 0; i < 16; ++i) words.word[i] = from[i];
}
/// Appends the lanes of x, y and z where m is set to rings of `size` numbers, a power of two, whose end is `tail`;
/// returns their number.
template <std::uint32_t size>
LANE_FN std::uint32_t ring_store(float* rx, float* ry, float* rz, std::uint32_t tail, M16 m, F16 x, F16 y, F16 z) {
  alignas(64) float lanes[3][16];
  x.store(lanes[0]), y.store(lanes[1]), z.store(lanes[2]);
  std::uint32_t n = 0;
  for (std::uint32_t rest = bits(m); rest; rest &= rest - 1, ++n) {
    const int i = lowest_bit(rest);
    const std::uint32_t at = (tail + n) % size;
    rx[at] = lanes[0][i], ry[at] = lanes[1][i], rz[at] = lanes[2][i];
  }
  return n;
}
/// Sixteen numbers of a ring.
template <std::uint32_t size>
LANE_FN F16 ring_load(const float* ring, std::uint32_t head) {
  return by_lane([&](std::uint32_t lane) LANE_INLINE { return ring[(head + lane) % size]; });
}

/// The sum of each of up to sixteen packs over its lanes, in the tree of reduce_add.
template <int N>
LANE_FN void reduce_each(const F16 (&packs)[N], float* sums) {
  static_assert(N <= 16);
  alignas(64) float rows[16][16], all[16];
  LANE_UNROLL(16)
  for (int k = 0; k < 16; ++k) (k < N ? packs[k < N ? k : 0] : F16(0.0f)).store(rows[k]);
  reduce_rows(rows).store(all);
  LANE_UNROLL(16)
  for (int k = 0; k < N; ++k) sums[k] = all[k];
}

#if !defined(HANDHOLD_ISA_AVX512)
/// to[0..15] += the lanes of a, in double.
LANE_FN void add_to_doubles(double* to, F16 a) {
  alignas(64) float lanes[16];
  a.store(lanes);
  for (int i = 0; i < 16; ++i) to[i] += static_cast<double>(lanes[i]);
}
#endif
#endif

}  // namespace handhold::HANDHOLD_LANE
