// Native packs of NEON (AArch64): 4 floats, 2 doubles. Included by lane.h.
#pragma once
#include <arm_neon.h>

namespace handhold::HANDHOLD_LANE {

template <>
struct Mask<float, 4> {
  uint32x4_t m;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {vandq_u32(a.m, b.m)}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {vorrq_u32(a.m, b.m)}; }
  friend LANE_FN Mask operator~(Mask a) { return {vmvnq_u32(a.m)}; }
  friend LANE_FN std::uint32_t bits(Mask a) {
    const uint32x4_t weight = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(a.m, weight));
  }
  friend LANE_FN bool any(Mask a) { return vmaxvq_u32(a.m) != 0; }
};
template <>
struct Mask<double, 2> {
  uint64x2_t m;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {vandq_u64(a.m, b.m)}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {vorrq_u64(a.m, b.m)}; }
  friend LANE_FN Mask operator~(Mask a) { return {vreinterpretq_u64_u32(vmvnq_u32(vreinterpretq_u32_u64(a.m)))}; }
  friend LANE_FN std::uint32_t bits(Mask a) {
    return static_cast<std::uint32_t>((vgetq_lane_u64(a.m, 0) & 1) | (vgetq_lane_u64(a.m, 1) & 2));
  }
  friend LANE_FN bool any(Mask a) { return (vgetq_lane_u64(a.m, 0) | vgetq_lane_u64(a.m, 1)) != 0; }
};

template <>
struct Vec<float, 4> {
  using M = Mask<float, 4>;
  float32x4_t v;
  Vec() = default;
  LANE_FN Vec(float s) : v(vdupq_n_f32(s)) {}
  LANE_FN Vec(float32x4_t x) : v(x) {}
  static LANE_FN Vec load(const float* p) { return vld1q_f32(p); }
  static LANE_FN Vec loadu(const float* p) { return vld1q_f32(p); }
  LANE_FN void store(float* p) const { vst1q_f32(p, v); }
  LANE_FN void storeu(float* p) const { vst1q_f32(p, v); }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return vaddq_f32(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return vsubq_f32(a.v, b.v); }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return vmulq_f32(a.v, b.v); }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return vdivq_f32(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a) { return vnegq_f32(a.v); }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return vfmaq_f32(c.v, a.v, b.v); }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return vfmsq_f32(c.v, a.v, b.v); }
  friend LANE_FN Vec sqrt(Vec a) { return vsqrtq_f32(a.v); }
  friend LANE_FN Vec abs(Vec a) { return vabsq_f32(a.v); }
  // From a comparison: the machine's own min and max treat NaN differently.
  friend LANE_FN Vec min(Vec a, Vec b) { return vbslq_f32(vcltq_f32(a.v, b.v), a.v, b.v); }
  friend LANE_FN Vec max(Vec a, Vec b) { return vbslq_f32(vcgtq_f32(a.v, b.v), a.v, b.v); }
  friend LANE_FN M operator<(Vec a, Vec b) { return {vcltq_f32(a.v, b.v)}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {vcleq_f32(a.v, b.v)}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {vcgtq_f32(a.v, b.v)}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {vcgeq_f32(a.v, b.v)}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return vbslq_f32(m.m, a.v, b.v); }
  friend LANE_FN float reduce_add(Vec a) {
    const float32x2_t d = vadd_f32(vget_low_f32(a.v), vget_high_f32(a.v));
    return vget_lane_f32(d, 0) + vget_lane_f32(d, 1);
  }
  friend LANE_FN float reduce_min(Vec a) { return vminvq_f32(a.v); }
  friend LANE_FN float reduce_max(Vec a) { return vmaxvq_f32(a.v); }
  friend LANE_FN Vec gather(const float* p, Vec column, Vec row, std::int32_t width) {
    const int32x4_t i = vmlaq_n_s32(vcvtq_s32_f32(column.v), vcvtq_s32_f32(row.v), width);
    return float32x4_t{p[vgetq_lane_s32(i, 0)], p[vgetq_lane_s32(i, 1)], p[vgetq_lane_s32(i, 2)],
                       p[vgetq_lane_s32(i, 3)]};
  }
  friend LANE_FN int compress_store(float* p, M m, Vec a) {
    const std::uint32_t b = bits(m);
    int n = 0;
    p[n] = vgetq_lane_f32(a.v, 0), n += b & 1;
    p[n] = vgetq_lane_f32(a.v, 1), n += b >> 1 & 1;
    p[n] = vgetq_lane_f32(a.v, 2), n += b >> 2 & 1;
    p[n] = vgetq_lane_f32(a.v, 3), n += b >> 3 & 1;
    return n;
  }
};

template <>
struct Vec<double, 2> {
  using M = Mask<double, 2>;
  float64x2_t v;
  Vec() = default;
  LANE_FN Vec(double s) : v(vdupq_n_f64(s)) {}
  LANE_FN Vec(float64x2_t x) : v(x) {}
  static LANE_FN Vec load(const double* p) { return vld1q_f64(p); }
  static LANE_FN Vec loadu(const double* p) { return vld1q_f64(p); }
  LANE_FN void store(double* p) const { vst1q_f64(p, v); }
  LANE_FN void storeu(double* p) const { vst1q_f64(p, v); }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return vaddq_f64(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return vsubq_f64(a.v, b.v); }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return vmulq_f64(a.v, b.v); }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return vdivq_f64(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a) { return vnegq_f64(a.v); }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return vfmaq_f64(c.v, a.v, b.v); }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return vfmsq_f64(c.v, a.v, b.v); }
  friend LANE_FN Vec sqrt(Vec a) { return vsqrtq_f64(a.v); }
  friend LANE_FN Vec abs(Vec a) { return vabsq_f64(a.v); }
  friend LANE_FN Vec min(Vec a, Vec b) { return vbslq_f64(vcltq_f64(a.v, b.v), a.v, b.v); }
  friend LANE_FN Vec max(Vec a, Vec b) { return vbslq_f64(vcgtq_f64(a.v, b.v), a.v, b.v); }
  friend LANE_FN M operator<(Vec a, Vec b) { return {vcltq_f64(a.v, b.v)}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {vcleq_f64(a.v, b.v)}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {vcgtq_f64(a.v, b.v)}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {vcgeq_f64(a.v, b.v)}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return vbslq_f64(m.m, a.v, b.v); }
};

}  // namespace handhold::HANDHOLD_LANE
