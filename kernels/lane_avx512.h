// Native packs of AVX-512: 16 floats, 8 doubles. Included by lane.h.
#pragma once
#include <immintrin.h>

namespace handhold::HANDHOLD_LANE {

template <>
struct Mask<float, 16> {
  __mmask16 m;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {static_cast<__mmask16>(a.m & b.m)}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {static_cast<__mmask16>(a.m | b.m)}; }
  friend LANE_FN Mask operator~(Mask a) { return {static_cast<__mmask16>(~a.m)}; }
  friend LANE_FN std::uint32_t bits(Mask a) { return a.m; }
  friend LANE_FN bool any(Mask a) { return a.m != 0; }
};
template <>
struct Mask<double, 8> {
  __mmask8 m;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {static_cast<__mmask8>(a.m & b.m)}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {static_cast<__mmask8>(a.m | b.m)}; }
  friend LANE_FN Mask operator~(Mask a) { return {static_cast<__mmask8>(~a.m)}; }
  friend LANE_FN std::uint32_t bits(Mask a) { return a.m; }
  friend LANE_FN bool any(Mask a) { return a.m != 0; }
};

template <>
struct Vec<float, 16> {
  using M = Mask<float, 16>;
  __m512 v;
  Vec() = default;
  LANE_FN Vec(float s) : v(_mm512_set1_ps(s)) {}
  LANE_FN Vec(__m512 x) : v(x) {}
  static LANE_FN Vec load(const float* p) { return _mm512_load_ps(p); }
  static LANE_FN Vec loadu(const float* p) { return _mm512_loadu_ps(p); }
  LANE_FN void store(float* p) const { _mm512_store_ps(p, v); }
  LANE_FN void storeu(float* p) const { _mm512_storeu_ps(p, v); }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return _mm512_add_ps(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return _mm512_sub_ps(a.v, b.v); }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return _mm512_mul_ps(a.v, b.v); }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return _mm512_div_ps(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a) { return _mm512_xor_ps(a.v, _mm512_set1_ps(-0.0f)); }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return _mm512_fmadd_ps(a.v, b.v, c.v); }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return _mm512_fnmadd_ps(a.v, b.v, c.v); }
  friend LANE_FN Vec sqrt(Vec a) { return _mm512_sqrt_ps(a.v); }
  friend LANE_FN Vec abs(Vec a) { return _mm512_abs_ps(a.v); }
  friend LANE_FN Vec min(Vec a, Vec b) { return _mm512_min_ps(a.v, b.v); }
  friend LANE_FN Vec max(Vec a, Vec b) { return _mm512_max_ps(a.v, b.v); }
  friend LANE_FN M operator<(Vec a, Vec b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ)}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_GT_OQ)}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_GE_OQ)}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return _mm512_mask_mov_ps(b.v, m.m, a.v); }
  friend LANE_FN Vec add_where(M m, Vec a, Vec b) { return _mm512_mask_add_ps(a.v, m.m, a.v, b.v); }
  friend LANE_FN float reduce_add(Vec a) {
    const __m256 b = _mm256_add_ps(_mm512_castps512_ps256(a.v), _mm512_extractf32x8_ps(a.v, 1));
    const __m128 c = _mm_add_ps(_mm256_castps256_ps128(b), _mm256_extractf128_ps(b, 1));
    const __m128 d = _mm_add_ps(c, _mm_movehl_ps(c, c));
    return _mm_cvtss_f32(_mm_add_ss(d, _mm_shuffle_ps(d, d, 1)));
  }
  friend LANE_FN float reduce_min(Vec a) { return _mm512_reduce_min_ps(a.v); }
  friend LANE_FN float reduce_max(Vec a) { return _mm512_reduce_max_ps(a.v); }
  friend LANE_FN Vec gather(const float* p, Vec column, Vec row, std::int32_t width) {
    const __m512i index = _mm512_add_epi32(_mm512_mullo_epi32(_mm512_cvttps_epi32(row.v), _mm512_set1_epi32(width)),
                                           _mm512_cvttps_epi32(column.v));
    return _mm512_i32gather_ps(index, p, 4);
  }
  friend LANE_FN int compress_store(float* p, M m, Vec a) {
    // A full-width store of the compressed register is far cheaper than a masked one.
    _mm512_storeu_ps(p, _mm512_maskz_compress_ps(m.m, a.v));
    return __builtin_popcount(m.m);
  }
};

template <>
struct Vec<double, 8> {
  using M = Mask<double, 8>;
  __m512d v;
  Vec() = default;
  LANE_FN Vec(double s) : v(_mm512_set1_pd(s)) {}
  LANE_FN Vec(__m512d x) : v(x) {}
  static LANE_FN Vec load(const double* p) { return _mm512_load_pd(p); }
  static LANE_FN Vec loadu(const double* p) { return _mm512_loadu_pd(p); }
  LANE_FN void store(double* p) const { _mm512_store_pd(p, v); }
  LANE_FN void storeu(double* p) const { _mm512_storeu_pd(p, v); }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return _mm512_add_pd(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return _mm512_sub_pd(a.v, b.v); }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return _mm512_mul_pd(a.v, b.v); }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return _mm512_div_pd(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a) { return _mm512_xor_pd(a.v, _mm512_set1_pd(-0.0)); }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return _mm512_fmadd_pd(a.v, b.v, c.v); }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return _mm512_fnmadd_pd(a.v, b.v, c.v); }
  friend LANE_FN Vec sqrt(Vec a) { return _mm512_sqrt_pd(a.v); }
  friend LANE_FN Vec abs(Vec a) { return _mm512_abs_pd(a.v); }
  friend LANE_FN Vec min(Vec a, Vec b) { return _mm512_min_pd(a.v, b.v); }
  friend LANE_FN Vec max(Vec a, Vec b) { return _mm512_max_pd(a.v, b.v); }
  friend LANE_FN M operator<(Vec a, Vec b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_LT_OQ)}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_LE_OQ)}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_GT_OQ)}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_GE_OQ)}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return _mm512_mask_mov_pd(b.v, m.m, a.v); }
};

/// The sums of sixteen rows, each over its sixteen lanes in the tree of reduce_add. rows: 64-byte aligned.
LANE_FN Vec<float, 16> reduce_rows(const float (*rows)[16]) {
  __m512 quads[4];
  LANE_UNROLL(4)
  for (int i = 0; i < 4; ++i) {
    const __m512 a = _mm512_load_ps(rows[4 * i]), b = _mm512_load_ps(rows[4 * i + 1]);
    const __m512 c = _mm512_load_ps(rows[4 * i + 2]), d = _mm512_load_ps(rows[4 * i + 3]);
    const __m512 ab = _mm512_add_ps(_mm512_shuffle_f32x4(a, b, 0x44), _mm512_shuffle_f32x4(a, b, 0xee));
    const __m512 cd = _mm512_add_ps(_mm512_shuffle_f32x4(c, d, 0x44), _mm512_shuffle_f32x4(c, d, 0xee));
    // Four lanes of each of the rows a, b, c, d.
    quads[i] = _mm512_add_ps(_mm512_shuffle_f32x4(ab, cd, 0x88), _mm512_shuffle_f32x4(ab, cd, 0xdd));
  }
  // Within the fours: first 0 + 2 and 1 + 3, then their sum. Lane 4 i + j ends up with row 4 j' + ..., put right below.
  const __m512 q01 =
      _mm512_add_ps(_mm512_shuffle_ps(quads[0], quads[1], 0x44), _mm512_shuffle_ps(quads[0], quads[1], 0xee));
  const __m512 q23 =
      _mm512_add_ps(_mm512_shuffle_ps(quads[2], quads[3], 0x44), _mm512_shuffle_ps(quads[2], quads[3], 0xee));
  const __m512 sums = _mm512_add_ps(_mm512_shuffle_ps(q01, q23, 0x88), _mm512_shuffle_ps(q01, q23, 0xdd));
  const __m512i order = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
  return _mm512_permutexvar_ps(order, sums);
}

/// Appends base + t for every set bit t of a 16-bit mask; may write 16 entries. Returns the number of bits.
LANE_FN int append_bits(std::uint32_t* list, std::uint32_t mask, std::uint32_t base) {
  const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i id = _mm512_add_epi32(lanes, _mm512_set1_epi32(static_cast<int>(base)));
  _mm512_storeu_si512(list, _mm512_maskz_compress_epi32(static_cast<__mmask16>(mask), id));
  return __builtin_popcount(mask);
}

/// Appends ids[t] for every set bit t of a 16-bit mask; may write 16 entries. Returns the number of bits.
LANE_FN int append_selected(std::uint32_t* list, std::uint32_t mask, const std::uint32_t* ids) {
  _mm512_storeu_si512(list, _mm512_maskz_compress_epi32(static_cast<__mmask16>(mask), _mm512_loadu_si512(ids)));
  return __builtin_popcount(mask);
}

/// to[0..15] += the lanes of a, in double.
LANE_FN void add_to_doubles(double* to, Vec<float, 16> a) {
  _mm512_store_pd(to, _mm512_add_pd(_mm512_load_pd(to), _mm512_cvtps_pd(_mm512_castps512_ps256(a.v))));
  _mm512_store_pd(to + 8, _mm512_add_pd(_mm512_load_pd(to + 8), _mm512_cvtps_pd(_mm512_extractf32x8_ps(a.v, 1))));
}

}  // namespace handhold::HANDHOLD_LANE
