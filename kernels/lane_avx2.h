// Native packs of AVX2 with FMA: 8 floats, 4 doubles. Included by lane.h.
#pragma once
#include <immintrin.h>

namespace handhold::HANDHOLD_LANE {

template <>
struct Mask<float, 8> {
  __m256 m;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {_mm256_and_ps(a.m, b.m)}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {_mm256_or_ps(a.m, b.m)}; }
  friend LANE_FN Mask operator~(Mask a) { return {_mm256_xor_ps(a.m, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))}; }
  friend LANE_FN std::uint32_t bits(Mask a) { return static_cast<std::uint32_t>(_mm256_movemask_ps(a.m)); }
  friend LANE_FN bool any(Mask a) { return _mm256_movemask_ps(a.m) != 0; }
};
template <>
struct Mask<double, 4> {
  __m256d m;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {_mm256_and_pd(a.m, b.m)}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {_mm256_or_pd(a.m, b.m)}; }
  friend LANE_FN Mask operator~(Mask a) { return {_mm256_xor_pd(a.m, _mm256_castsi256_pd(_mm256_set1_epi32(-1)))}; }
  friend LANE_FN std::uint32_t bits(Mask a) { return static_cast<std::uint32_t>(_mm256_movemask_pd(a.m)); }
  friend LANE_FN bool any(Mask a) { return _mm256_movemask_pd(a.m) != 0; }
};

/// Numbers of the set bits of eight, ascending, and numbers without meaning behind them.
LANE_FN __m256i set_bits(std::uint32_t b) {
  // The index of the n-th set bit, as eight bytes, comes from two bit instructions instead of a table.
  const std::uint64_t spread = _pdep_u64(b, 0x0101010101010101ull) * 0xff;
  const std::uint64_t index = _pext_u64(0x0706050403020100ull, spread);
  return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(index)));
}

template <>
struct Vec<float, 8> {
  using M = Mask<float, 8>;
  __m256 v;
  Vec() = default;
  LANE_FN Vec(float s) : v(_mm256_set1_ps(s)) {}
  LANE_FN Vec(__m256 x) : v(x) {}
  static LANE_FN Vec load(const float* p) { return _mm256_load_ps(p); }
  static LANE_FN Vec loadu(const float* p) { return _mm256_loadu_ps(p); }
  LANE_FN void store(float* p) const { _mm256_store_ps(p, v); }
  LANE_FN void storeu(float* p) const { _mm256_storeu_ps(p, v); }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return _mm256_add_ps(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return _mm256_sub_ps(a.v, b.v); }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return _mm256_mul_ps(a.v, b.v); }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return _mm256_div_ps(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a) { return _mm256_xor_ps(a.v, _mm256_set1_ps(-0.0f)); }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return _mm256_fmadd_ps(a.v, b.v, c.v); }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return _mm256_fnmadd_ps(a.v, b.v, c.v); }
  friend LANE_FN Vec sqrt(Vec a) { return _mm256_sqrt_ps(a.v); }
  friend LANE_FN Vec abs(Vec a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v); }
  friend LANE_FN Vec min(Vec a, Vec b) { return _mm256_min_ps(a.v, b.v); }
  friend LANE_FN Vec max(Vec a, Vec b) { return _mm256_max_ps(a.v, b.v); }
  friend LANE_FN M operator<(Vec a, Vec b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_GT_OQ)}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return _mm256_blendv_ps(b.v, a.v, m.m); }
  friend LANE_FN float reduce_add(Vec a) {
    const __m128 c = _mm_add_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    const __m128 d = _mm_add_ps(c, _mm_movehl_ps(c, c));
    return _mm_cvtss_f32(_mm_add_ss(d, _mm_shuffle_ps(d, d, 1)));
  }
  friend LANE_FN float reduce_min(Vec a) {
    const __m128 c = _mm_min_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    const __m128 d = _mm_min_ps(c, _mm_movehl_ps(c, c));
    return _mm_cvtss_f32(_mm_min_ss(d, _mm_shuffle_ps(d, d, 1)));
  }
  friend LANE_FN float reduce_max(Vec a) {
    const __m128 c = _mm_max_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    const __m128 d = _mm_max_ps(c, _mm_movehl_ps(c, c));
    return _mm_cvtss_f32(_mm_max_ss(d, _mm_shuffle_ps(d, d, 1)));
  }
  friend LANE_FN Vec gather(const float* p, Vec column, Vec row, std::int32_t width) {
    const __m256i index = _mm256_add_epi32(_mm256_mullo_epi32(_mm256_cvttps_epi32(row.v), _mm256_set1_epi32(width)),
                                           _mm256_cvttps_epi32(column.v));
    return _mm256_i32gather_ps(p, index, 4);
  }
  friend LANE_FN int compress_store(float* p, M m, Vec a) {
    const std::uint32_t b = bits(m);
    _mm256_storeu_ps(p, _mm256_permutevar8x32_ps(a.v, set_bits(b)));
    return __builtin_popcount(b);
  }
};

template <>
struct Vec<double, 4> {
  using M = Mask<double, 4>;
  __m256d v;
  Vec() = default;
  LANE_FN Vec(double s) : v(_mm256_set1_pd(s)) {}
  LANE_FN Vec(__m256d x) : v(x) {}
  static LANE_FN Vec load(const double* p) { return _mm256_load_pd(p); }
  static LANE_FN Vec loadu(const double* p) { return _mm256_loadu_pd(p); }
  LANE_FN void store(double* p) const { _mm256_store_pd(p, v); }
  LANE_FN void storeu(double* p) const { _mm256_storeu_pd(p, v); }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return _mm256_add_pd(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return _mm256_sub_pd(a.v, b.v); }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return _mm256_mul_pd(a.v, b.v); }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return _mm256_div_pd(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a) { return _mm256_xor_pd(a.v, _mm256_set1_pd(-0.0)); }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return _mm256_fmadd_pd(a.v, b.v, c.v); }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return _mm256_fnmadd_pd(a.v, b.v, c.v); }
  friend LANE_FN Vec sqrt(Vec a) { return _mm256_sqrt_pd(a.v); }
  friend LANE_FN Vec abs(Vec a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a.v); }
  friend LANE_FN Vec min(Vec a, Vec b) { return _mm256_min_pd(a.v, b.v); }
  friend LANE_FN Vec max(Vec a, Vec b) { return _mm256_max_pd(a.v, b.v); }
  friend LANE_FN M operator<(Vec a, Vec b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LT_OQ)}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LE_OQ)}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_GT_OQ)}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_GE_OQ)}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return _mm256_blendv_pd(b.v, a.v, m.m); }
};

/// Appends base + t for every set bit t of a 16-bit mask; may write 16 entries. Returns the number of bits.
LANE_FN int append_bits(std::uint32_t* list, std::uint32_t mask, std::uint32_t base) {
  const std::uint32_t low = mask & 0xff, high = mask >> 8;
  const int n = __builtin_popcount(low);
  const __m256i first = _mm256_set1_epi32(static_cast<int>(base)),
                second = _mm256_set1_epi32(static_cast<int>(base + 8));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(list), _mm256_add_epi32(first, set_bits(low)));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(list + n), _mm256_add_epi32(second, set_bits(high)));
  return n + __builtin_popcount(high);
}

/// Appends ids[t] for every set bit t of a 16-bit mask; may write 16 entries. Returns the number of bits.
LANE_FN int append_selected(std::uint32_t* list, std::uint32_t mask, const std::uint32_t* ids) {
  const std::uint32_t low = mask & 0xff, high = mask >> 8;
  const int n = __builtin_popcount(low);
  const __m256i first = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(ids));
  const __m256i second = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(ids + 8));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(list), _mm256_permutevar8x32_epi32(first, set_bits(low)));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(list + n), _mm256_permutevar8x32_epi32(second, set_bits(high)));
  return n + __builtin_popcount(high);
}

/// The sums of sixteen rows, each over its sixteen lanes in the tree of reduce_add. rows: 64-byte aligned.
LANE_FN Vec<float, 16> reduce_rows(const float (*rows)[16]) {
  __m128 sums[4];
  LANE_UNROLL(4)
  for (int i = 0; i < 4; ++i) {
    __m128 four[4];
    LANE_UNROLL(4)
    for (int k = 0; k < 4; ++k) {
      const __m256 a = _mm256_add_ps(_mm256_load_ps(rows[4 * i + k]), _mm256_load_ps(rows[4 * i + k] + 8));
      four[k] = _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    }
    _MM_TRANSPOSE4_PS(four[0], four[1], four[2], four[3]);
    sums[i] = _mm_add_ps(_mm_add_ps(four[0], four[2]), _mm_add_ps(four[1], four[3]));
  }
  return {Vec<float, 8>(_mm256_set_m128(sums[1], sums[0])), Vec<float, 8>(_mm256_set_m128(sums[3], sums[2]))};
}

}  // namespace handhold::HANDHOLD_LANE
