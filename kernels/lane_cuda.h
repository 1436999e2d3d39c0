// Packs on a GPU: sixteen threads, half a warp, are a pack of sixteen floats, and each of them holds one lane. What is
// the same for all lanes (a bit mask, a sum over the lanes) every thread has in full. Threads are numbered along x, and
// the sixteen of a pack go through the same code together; memory that a pack writes and reads must belong to the pack.
// Included by lane.h.
#pragma once

namespace handhold::HANDHOLD_LANE {

LANE_FN unsigned pack_lane() {
  return threadIdx.x & 15;
}
/// The threads of this pack among those of its warp.
LANE_FN unsigned pack_threads() {
  return 0xffffu << (threadIdx.x & 16);
}
LANE_FN void pack_sync() {
  __syncwarp(pack_threads());
}
LANE_FN float from_lane_across(float a, int distance) {
  return __shfl_xor_sync(pack_threads(), a, distance, 16);
}

template <>
struct Mask<float, 16> {
  bool m;
  friend LANE_FN Mask operator&(Mask a, Mask b) { return {a.m && b.m}; }
  friend LANE_FN Mask operator|(Mask a, Mask b) { return {a.m || b.m}; }
  friend LANE_FN Mask operator~(Mask a) { return {!a.m}; }
  friend LANE_FN std::uint32_t bits(Mask a) {
    return __ballot_sync(pack_threads(), a.m) >> (threadIdx.x & 16) & 0xffffu;
  }
  friend LANE_FN bool any(Mask a) { return bits(a) != 0; }
};

template <>
struct Vec<float, 16> {
  using M = Mask<float, 16>;
  float v;
  Vec() = default;
  LANE_FN Vec(float s) : v(s) {}
  static LANE_FN Vec load(const float* p) { return p[pack_lane()]; }
  static LANE_FN Vec loadu(const float* p) { return p[pack_lane()]; }
  LANE_FN void store(float* p) const {
    pack_sync();
    p[pack_lane()] = v;
    pack_sync();
  }
  LANE_FN void storeu(float* p) const { store(p); }
  friend LANE_FN Vec operator+(Vec a, Vec b) { return a.v + b.v; }
  friend LANE_FN Vec operator-(Vec a, Vec b) { return a.v - b.v; }
  friend LANE_FN Vec operator*(Vec a, Vec b) { return a.v * b.v; }
  friend LANE_FN Vec operator/(Vec a, Vec b) { return __fdiv_rn(a.v, b.v); }
  friend LANE_FN Vec operator-(Vec a) { return -a.v; }
  friend LANE_FN Vec fma(Vec a, Vec b, Vec c) { return __fmaf_rn(a.v, b.v, c.v); }
  friend LANE_FN Vec fnma(Vec a, Vec b, Vec c) { return __fmaf_rn(-a.v, b.v, c.v); }
  friend LANE_FN Vec sqrt(Vec a) { return __fsqrt_rn(a.v); }
  friend LANE_FN Vec abs(Vec a) { return ::fabsf(a.v); }
  friend LANE_FN Vec min(Vec a, Vec b) { return a.v < b.v ? a.v : b.v; }
  friend LANE_FN Vec max(Vec a, Vec b) { return a.v > b.v ? a.v : b.v; }
  friend LANE_FN M operator<(Vec a, Vec b) { return {a.v < b.v}; }
  friend LANE_FN M operator<=(Vec a, Vec b) { return {a.v <= b.v}; }
  friend LANE_FN M operator>(Vec a, Vec b) { return {a.v > b.v}; }
  friend LANE_FN M operator>=(Vec a, Vec b) { return {a.v >= b.v}; }
  friend LANE_FN Vec select(M m, Vec a, Vec b) { return m.m ? a.v : b.v; }
  friend LANE_FN float reduce_add(Vec a) {
    a.v += from_lane_across(a.v, 8), a.v += from_lane_across(a.v, 4);
    a.v += from_lane_across(a.v, 2), a.v += from_lane_across(a.v, 1);
    return a.v;
  }
  friend LANE_FN float reduce_min(Vec a) {
    a.v = ::fminf(a.v, from_lane_across(a.v, 8)), a.v = ::fminf(a.v, from_lane_across(a.v, 4));
    a.v = ::fminf(a.v, from_lane_across(a.v, 2)), a.v = ::fminf(a.v, from_lane_across(a.v, 1));
    return a.v;
  }
  friend LANE_FN float reduce_max(Vec a) {
    a.v = ::fmaxf(a.v, from_lane_across(a.v, 8)), a.v = ::fmaxf(a.v, from_lane_across(a.v, 4));
    a.v = ::fmaxf(a.v, from_lane_across(a.v, 2)), a.v = ::fmaxf(a.v, from_lane_across(a.v, 1));
    return a.v;
  }
  friend LANE_FN int compress_store(float* p, M m, Vec a) {
    const std::uint32_t all = bits(m);
    pack_sync();
    if (m.m) p[count_bits(all & ((1u << pack_lane()) - 1))] = a.v;
    pack_sync();
    return count_bits(all);
  }
  friend LANE_FN Vec gather(const float* p, Vec column, Vec row, std::int32_t width) {
    return p[static_cast<std::int32_t>(row.v) * width + static_cast<std::int32_t>(column.v)];
  }
};

LANE_FN Vec<float, 16> lane_numbers() {
  return static_cast<float>(pack_lane());
}

// As on a CPU (lane.h).
template <class F>
LANE_FN Vec<float, 16> by_lane(F&& f) {
  return f(pack_lane());
}
template <class F>
LANE_FN std::uint32_t bits_by_lane(F&& f) {
  return bits(Mask<float, 16>{f(pack_lane())});
}
LANE_FN float lane_value(Vec<float, 16> a, std::uint32_t lane) {
  return __shfl_sync(pack_threads(), a.v, static_cast<int>(lane), 16);
}
LANE_FN bool first_lane() {
  return pack_lane() == 0;
}
LANE_FN std::uint32_t add_one(std::uint32_t* number) {
  return atomicAdd(number, 1u);
}
LANE_FN void raise(std::uint32_t* number, std::uint32_t to) {
  atomicMax(number, to);
}
/// What the first lane got, for all of them.
LANE_FN std::uint32_t from_first_lane(std::uint32_t a) {
  return __shfl_sync(pack_threads(), a, 0, 16);
}
struct LaneWords {
  std::uint32_t word;
};
LANE_FN void set_lane(LaneWords& words, int lane, std::uint32_t to) {
  if (static_cast<int>(pack_lane()) == lane) words.word = to;
}
LANE_FN std::uint32_t get_lane(const LaneWords& words, int lane) {
  return __shfl_sync(pack_threads(), words.word, lane, 16);
}
LANE_FN void store_lanes(std::uint32_t* to, const LaneWords& words) {
  to[pack_lane()] = words.word;
}
LANE_FN void load_lanes(const std::uint32_t* from, LaneWords& words) {
  words.word = from[pack_lane()];
}
/// Whoever reads the ring synchronizes the pack first, and again before more is stored.
template <std::uint32_t size>
LANE_FN std::uint32_t ring_store(float* rx, float* ry, float* rz, std::uint32_t tail, Mask<float, 16> m,
                                 Vec<float, 16> x, Vec<float, 16> y, Vec<float, 16> z) {
  const std::uint32_t all = bits(m);
  if (m.m) {
    const std::uint32_t at = (tail + static_cast<std::uint32_t>(count_bits(all & ((1u << pack_lane()) - 1)))) % size;
    rx[at] = x.v, ry[at] = y.v, rz[at] = z.v;
  }
  return static_cast<std::uint32_t>(count_bits(all));
}
template <std::uint32_t size>
LANE_FN Vec<float, 16> ring_load(const float* ring, std::uint32_t head) {
  return ring[(head + pack_lane()) % size];
}

/// Appends base + t for every set bit t of a 16-bit mask. Returns the number of bits.
LANE_FN int append_bits(std::uint32_t* list, std::uint32_t mask, std::uint32_t base) {
  const std::uint32_t t = pack_lane();
  pack_sync();
  if (mask >> t & 1) list[count_bits(mask & ((1u << t) - 1))] = base + t;
  pack_sync();
  return count_bits(mask);
}

/// Appends ids[t] for every set bit t of a 16-bit mask. Returns the number of bits.
LANE_FN int append_selected(std::uint32_t* list, std::uint32_t mask, const std::uint32_t* ids) {
  const std::uint32_t t = pack_lane();
  pack_sync();
  if (mask >> t & 1) list[count_bits(mask & ((1u << t) - 1))] = ids[t];
  pack_sync();
  return count_bits(mask);
}

/// The sum of each pack over its lanes, in the tree of reduce_add.
template <int N>
LANE_FN void reduce_each(const Vec<float, 16> (&packs)[N], float* sums) {
  LANE_UNROLL(16)
  for (int k = 0; k < N; ++k) sums[k] = reduce_add(packs[k]);
}

/// From 2 * half packs to half of them: each lane adds up the ones it keeps and gives the others away.
template <int half>
LANE_FN void halve(Vec<float, 16>* packs) {
  const bool upper = pack_lane() & half;
  LANE_UNROLL(8)
  for (int k = 0; k < half; ++k) {
    const float keep = upper ? packs[k + half].v : packs[k].v, give = upper ? packs[k].v : packs[k + half].v;
    packs[k].v = keep + from_lane_across(give, half);
  }
}
/// The same of sixteen, of which each lane gets the one of its own number, by a quarter of the exchanges.
LANE_FN float reduce_sixteen(Vec<float, 16>* packs) {
  halve<8>(packs), halve<4>(packs), halve<2>(packs), halve<1>(packs);
  return packs[0].v;
}

}  // namespace handhold::HANDHOLD_LANE
