// The steps of one frame's search as a GPU takes them: for a pack of lanes, or for one thread, at a time, on the same
// headers as the CPU. What they find is the CPU's to the bit where its packs round as a GPU does (fused operations);
// only the order in which they find it differs.
//
// The tiles stand under an implicit tree of boxes, sixteen to a node. Nothing has to be built but boxes of boxes, and a
// ball finds its blocks in about eight tests of sixteen boxes.
#pragma once

#include "../align.h"
#include "../circle.h"
#include "../curvature.h"
#include "../finish_block.h"
#include "../moment_sums.h"
#include "../neighbours.h"
#include "../proposals.h"
#include "../ranks.h"
#include "../rough_plane.h"
#include "../shell.h"
#include "../taubin.h"
#include "frame.h"
#include "totals.h"

namespace handhold::HANDHOLD_LANE {

using kernels::FrameQuery;
using kernels::FrameView;

// ---- Tiles and boxes ----------------------------------------------------------------------------------------------

/// Takes the points of tile `t` of a block, one pack.
LANE_FN void build_tile(const FrameView& f, std::uint32_t block, std::uint32_t t) {
  const std::uint32_t across = (f.width + 15) / 16;
  const auto point = [&](std::uint32_t lane) LANE_INLINE -> const float* {
    std::size_t i = 0;
    if (f.order) {
      const std::uint32_t at = f.order[block];
      const std::uint32_t u = at % across * 16 + 4 * ((t & 1) | (t >> 1 & 2)) + (lane & 3);
      const std::uint32_t v = at / across * 16 + 4 * ((t >> 1 & 1) | (t >> 2 & 2)) + (lane >> 2);
      if (u >= f.width || v >= f.height) return nullptr;
      i = static_cast<std::size_t>(v) * f.width + u;
    } else {
      const std::uint32_t at = 256 * block + 16 * t + lane;
      if (at >= f.counts->finite) return nullptr;
      i = f.sorted[at];
    }
    return f.source + i * f.source_step;
  };
  const auto coordinate = [&](int k) LANE_INLINE {
    return by_lane([&](std::uint32_t lane) LANE_INLINE {
      const float* p = point(lane);
      return p ? p[k] : kernels::kFar;
    });
  };
  F16 x = coordinate(0), y = coordinate(1), z = coordinate(2);
  const TileSummary s = finish_tile(x, y, z);
  float* p = f.points + 768 * static_cast<std::size_t>(block) + 48 * t;
  x.store(p), y.store(p + 16), z.store(p + 32);
  if (!first_lane()) return;
  float *box = f.boxes + 96 * static_cast<std::size_t>(block), *sums = f.sums + 160 * static_cast<std::size_t>(block);
  LANE_UNROLL(6)
  for (int k = 0; k < 6; ++k) box[16 * k + t] = s.box[k];
  LANE_UNROLL(10)
  for (int k = 0; k < 10; ++k) sums[16 * k + t] = s.sum[k];
}

/// The box of sixteen boxes, and where it stands among its own fifteen neighbours; one pack.
LANE_FN void join_boxes(const float* rows, float* above, std::uint32_t at) {
  float low[3], high[3];
  LANE_UNROLL(3)
  for (int k = 0; k < 3; ++k) {
    low[k] = reduce_min(F16::load(rows + 16 * k)), high[k] = reduce_max(F16::load(rows + 48 + 16 * k));
  }
  if (!first_lane()) return;
  float* to = above + 96 * static_cast<std::size_t>(at / 16) + at % 16;
  LANE_UNROLL(3)
  for (int k = 0; k < 3; ++k) to[16 * k] = low[k], to[48 + 16 * k] = high[k];
}

/// What a block knows of its tiles, once they are there; one pack.
LANE_FN void finish_tiles_of(const FrameView& f, std::uint32_t block) {
  const std::size_t b = block;
  join_boxes(f.boxes + 96 * b, f.block_boxes, block);
  const float* points = f.sums + 160 * b;
  const F16 n = F16::load(points);
  const std::uint32_t full = bits(n >= F16(static_cast<float>(kernels::kTilePoints)));
  const float all = reduce_add(n);
  if (!first_lane()) return;
  f.full[b] = static_cast<std::uint16_t>(full);
  f.block_points[b] = static_cast<std::uint32_t>(all);
  std::uint32_t before = 0;
  for (std::uint32_t t = 0; t < kernels::kBlockTiles; ++t) {
    f.before[16 * b + t] = static_cast<std::uint16_t>(before);
    before += static_cast<std::uint32_t>(points[t]);
  }
}

/// The box over a group's blocks, with empty ones where there are none; one pack.
LANE_FN void build_group(const FrameView& f, std::uint32_t group) {
  float* rows = f.block_boxes + 96 * static_cast<std::size_t>(group);
  LANE_UNROLL(6)
  for (int k = 0; k < 6; ++k) {
    by_lane([&](std::uint32_t lane) LANE_INLINE {
      return 16 * group + lane < f.blocks ? rows[16 * k + lane] : k < 3 ? kernels::kFar : -kernels::kFar;
    }).store(rows + 16 * k);
  }
  join_boxes(rows, f.group_boxes, group);
}

/// The box over a region's groups; one pack.
LANE_FN void build_region(const FrameView& f, std::uint32_t region) {
  join_boxes(f.group_boxes + 96 * static_cast<std::size_t>(region), f.region_boxes, region);
}

/// Visits the blocks that a query touches, in ascending order. `near(rows)`: which of sixteen boxes it may touch;
/// `touch(rows)`: which blocks it does.
template <class Near, class Touch, class Visit>
LANE_FN void for_each_block(const FrameView& f, Near&& near, Touch&& touch, Visit&& visit) {
  for (std::uint32_t top = 0; 16 * top < f.regions; ++top) {
    std::uint32_t regions = near(f.region_boxes + 96 * static_cast<std::size_t>(top));
    for (; regions; regions &= regions - 1) {
      const std::uint32_t region = 16 * top + static_cast<std::uint32_t>(lowest_bit(regions));
      std::uint32_t groups = near(f.group_boxes + 96 * static_cast<std::size_t>(region));
      for (; groups; groups &= groups - 1) {
        const std::uint32_t group = 16 * region + static_cast<std::uint32_t>(lowest_bit(groups));
        std::uint32_t blocks = touch(f.block_boxes + 96 * static_cast<std::size_t>(group));
        for (; blocks; blocks &= blocks - 1) visit(16 * group + static_cast<std::uint32_t>(lowest_bit(blocks)));
      }
    }
  }
}
LANE_FN std::uint32_t touched_boxes(const float* b, const Ball& ball) {
  const float* const rows[6] = {b, b + 16, b + 32, b + 48, b + 64, b + 80};
  return test_boxes(rows, 0, ball).touched;
}
template <class Visit>
LANE_FN void for_each_block(const FrameView& f, const Ball& ball, Visit&& visit) {
  const auto near = [&](const float* b) LANE_INLINE { return touched_boxes(b, ball); };
  for_each_block(f, near, near, visit);
}

// ---- Neighbourhoods -----------------------------------------------------------------------------------------------

/// Where an attempt of a sample (of the round) goes, and whether it is accepted; one pack. There must be a centre.
LANE_FN bool propose(const FrameView& f, const FrameQuery& q, std::uint32_t sample, std::uint32_t attempt, double* x) {
  const std::uint32_t n = f.counts->found;
  const kernels::Draw draw = kernels::draw_attempt(q.proposals, sample, attempt, n);
  const double* centre = f.centres + 3 * draw.centre;
  double d[3];
  LANE_UNROLL(3)
  for (int k = 0; k < 3; ++k) {
    x[k] = centre[k] + q.sigma * static_cast<double>(draw.normal[k]);
    d[k] = x[k] - centre[k];
  }
  if (!q.only_nearest) return true;
  // All Gaussians have the same covariance, so the largest one at x belongs to the nearest centre; of equally near ones
  // the first counts.
  const double d2 = kernels::dot3(d, d);
  LANE_SIDE_BY_SIDE
  for (std::uint32_t j = 0; j < n; j += 16) {
    const std::uint32_t beaten = bits_by_lane([&](std::uint32_t lane) LANE_INLINE {
      const std::uint32_t i = j + lane;
      if (i >= n) return false;
      const double* other = f.centres + 3 * static_cast<std::size_t>(i);
      const double e[3] = {x[0] - other[0], x[1] - other[1], x[2] - other[2]};
      const double e2 = kernels::dot3(e, e);
      return e2 < d2 || (e2 == d2 && i < draw.centre);
    });
    if (beaten) return false;
  }
  return true;
}

/// The point nearest to a place within a radius; one pack. As nearest_point.
LANE_FN bool nearest_in(const FrameView& f, const float* place, float radius, float* xyz) {
  Ball ball(place, radius);
  const kernels::Tiles tiles = f.tiles();
  const F16 zero(0.0f);
  float limit = radius * radius;
  F16 best(2 * limit), x = zero, y = zero, z = zero;
  for_each_block(f, ball, [&](std::uint32_t block) LANE_INLINE {
    const TileHits hits = touched_tiles(tiles, block, ball);
    for (std::uint32_t rest = hits.boundary | hits.inside; rest; rest &= rest - 1) {
      const float* p = tile_points(tiles, 16 * block + static_cast<std::uint32_t>(lowest_bit(rest)));
      const F16 dx = F16::load(p) - ball.x, dy = F16::load(p + 16) - ball.y, dz = F16::load(p + 32) - ball.z;
      const F16 d2 = squared_norm(dx, dy, dz);
      const M16 nearer = d2 < best;
      best = select(nearer, d2, best), x = select(nearer, dx, x), y = select(nearer, dy, y), z = select(nearer, dz, z);
    }
    // What is farther than the best one need not be looked at.
    const float least = reduce_min(best);
    if (least < limit) limit = least, ball.r2_outside = F16(limit * kOutside), ball.r2_inside = zero;
  });
  const float least = reduce_min(best);
  if (!(least <= radius * radius)) return false;
  // Of equally near ones in several lanes the first.
  const auto lane = static_cast<std::uint32_t>(lowest_bit(bits(best <= F16(least))));
  xyz[0] = place[0] + lane_value(x, lane), xyz[1] = place[1] + lane_value(y, lane);
  xyz[2] = place[2] + lane_value(z, lane);
  return true;
}

/// Brings an accepted draw to the cloud; one pack. False: it is too far from it.
LANE_FN bool snap(const FrameView& f, const FrameQuery& q, const double* x, float* xyz) {
  const float place[3] = {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
  const float shares[2] = {kernels::kNearShare, 1.0f};
  LANE_ROLLED
  for (int i = 0; i < 2; ++i) {
    if (nearest_in(f, place, shares[i] * q.snap_radius, xyz)) return true;
  }
  return false;
}

/// Puts the centre of shell i, one of those that are not yet in order, in its place; one pack.
LANE_FN void order_centre(const FrameView& f, std::uint32_t i) {
  const std::uint32_t before = f.counts->ordered, n = f.counts->found, sample = f.found[i].sample;
  std::uint32_t rank = before;
  for (std::uint32_t j = before; j < n; j += 16)
    rank += static_cast<std::uint32_t>(count_bits(bits_by_lane(
        [&](std::uint32_t lane) LANE_INLINE { return j + lane < n && f.found[j + lane].sample < sample; })));
  if (!first_lane()) return;
  LANE_UNROLL(3)
  for (int k = 0; k < 3; ++k) f.centres[3 * static_cast<std::size_t>(rank) + k] = f.found[i].place.center[k];
}

/// The first blocks of a neighbourhood, so that they need not be looked for again.
class BlockList {
 public:
  static constexpr int kWords = 17;
  LANE_FN void add(std::uint32_t block) {
    set_lane(first_, n_, block);
    ++n_;
  }
  LANE_FN int n() const { return n_; }
  LANE_FN bool complete() const { return n_ <= 16; }
  LANE_FN std::uint32_t at(int i) const { return get_lane(first_, i); }
  LANE_FN void store(std::uint32_t* to) const {
    store_lanes(to, first_);
    if (first_lane()) to[16] = static_cast<std::uint32_t>(n_);
  }
  LANE_FN void load(const std::uint32_t* from) {
    load_lanes(from, first_);
    n_ = static_cast<int>(from[16]);
  }

 private:
  LaneWords first_ = {};
  int n_ = 0;
};

/// Draws a sample (of the round) uniformly over the points; one thread. There must be a point.
LANE_FN void draw_sample(const FrameView& f, const FrameQuery& q, std::uint32_t i, float* xyz) {
  CounterRandom random(q.seed, q.stream, i);
  const auto rank = static_cast<std::uint32_t>(random.below(f.counts->finite));
  // The block b with first_rank[b] <= rank < first_rank[b + 1].
  std::uint32_t b = 0;
  for (std::uint32_t end = f.blocks; end - b > 1;) {
    const std::uint32_t middle = b + (end - b) / 2;
    if (f.first_rank[middle] <= rank) {
      b = middle;
    } else {
      end = middle;
    }
  }
  kernels::point_of_rank(f.points + 768 * static_cast<std::size_t>(b), f.before + 16 * static_cast<std::size_t>(b),
                         f.full[b], rank - f.first_rank[b], xyz);
}

/// Rough plane of a neighbourhood, and its blocks; one pack. False: it is flat, and ends here.
LANE_FN bool look_at(const FrameView& f, const FrameQuery& q, std::uint32_t sample, const float* centre,
                     RoughPlane<float>& plane, BlockList& blocks) {
  const Ball ball(centre, q.radius);
  F16 s[kLowSums];
  LANE_UNROLL(10)
  for (int k = 0; k < kLowSums; ++k) s[k] = F16(0.0f);
  const kernels::Tiles tiles = f.tiles();
  for_each_block(f, ball, [&](std::uint32_t block) LANE_INLINE {
    blocks.add(block);
    add_block_sums(tiles, block, ball, s);
  });
  float sums[kLowSums];
  reduce_each(s, sums);
  plane = rough_plane(sums, q.radius);
  if (!is_flat(sums[0], plane.residual2, plane.narrow2, q.radius, q.flat_rms, q.flat_slope)) return true;
  if (first_lane()) {
    f.end[sample] =
        static_cast<std::int32_t>(sums[0]) < q.min_points ? kernels::kEndTooFewPoints : kernels::kEndCurvatureLow;
  }
  return false;
}

/// A neighbourhood goes on in this slot; one pack.
LANE_FN void keep_slot(const FrameView& f, std::uint32_t slot, std::uint32_t sample, const RoughPlane<float>& plane,
                       const BlockList& blocks) {
  blocks.store(f.listed + BlockList::kWords * static_cast<std::size_t>(slot));
  if (!first_lane()) return;
  f.summed[slot] = sample;
  f.plane[slot] = plane.up, f.plane[f.capacity + slot] = plane.a;
  f.plane[2 * static_cast<std::size_t>(f.capacity) + slot] = plane.b;
}

/// What a pack remembers while it sums up: tiles that wait for it, and a ring of points.
struct VisitMemory {
  static constexpr int kTiles = 48, kRing = 128;
  std::uint32_t tile[kTiles + 16];
  float ring[3][kRing];
};

/// Sums of a neighbourhood over heights; one pack. The order of the points is that of neighbourhood_moments, so that
/// the sums are its, too.
LANE_FN void sum_points(const FrameView& f, const FrameQuery& q, std::uint32_t slot, VisitMemory& m) {
  const kernels::Tiles tiles = f.tiles();
  const std::uint32_t sample = f.summed[slot];
  const float* centre = f.position + 3 * static_cast<std::size_t>(sample);
  const Ball ball(centre, q.radius);
  const int w = static_cast<int>(f.plane[slot]), u = (w + 1) % 3, v = (w + 2) % 3;
  const F16 a(f.plane[f.capacity + slot]), b(f.plane[2 * static_cast<std::size_t>(f.capacity) + slot]);
  const F16 cu(centre[u]), cv(centre[v]), cw(centre[w]);
  BlockList blocks;
  blocks.load(f.listed + BlockList::kWords * static_cast<std::size_t>(slot));
  const auto for_each = [&](auto&& visit) LANE_INLINE {
    if (blocks.complete()) {
      for (int i = 0; i < blocks.n(); ++i) visit(blocks.at(i));
    } else {
      for_each_block(f, ball, visit);
    }
  };
  Totals totals;
  std::int32_t count = 0;
  int listed = 0;
  constexpr int kAtOnce = 4;  // tiles that are on their way from memory side by side

  const auto sum_inside = [&]() LANE_INLINE {
    LANE_ROLLED
    for (int i = 0; i < listed; i += kAtOnce) {
      F16 pu[kAtOnce], pv[kAtOnce], pw[kAtOnce];
      LANE_UNROLL(4)
      for (int j = 0; j < kAtOnce; ++j) {
        const float* p = tile_points(tiles, m.tile[i + j < listed ? i + j : i]);
        pu[j] = F16::load(p + 16 * u), pv[j] = F16::load(p + 16 * v), pw[j] = F16::load(p + 16 * w);
      }
      LANE_UNROLL(4)
      for (int j = 0; j < kAtOnce; ++j) {
        if (i + j >= listed) break;
        const F16 x = pu[j] - cu, y = pv[j] - cv;
        totals.add(x, y, fnma(a, x, fnma(b, y, pw[j] - cw)));
      }
    }
    listed = 0;
  };
  for_each([&](std::uint32_t block) LANE_INLINE {
    const int more = append_bits(m.tile + listed, touched_tiles(tiles, block, ball).inside, 16 * block);
    listed += more, count += 16 * more;
    if (listed >= VisitMemory::kTiles) sum_inside();
  });
  sum_inside();

  // Tiles on the ball's surface, point by point, through the ring.
  std::uint32_t head = 0, tail = 0;
  const auto sum_boundary = [&]() LANE_INLINE {
    LANE_ROLLED
    for (int i = 0; i < listed; i += kAtOnce) {
      F16 x[kAtOnce], y[kAtOnce], z[kAtOnce];
      LANE_UNROLL(4)
      for (int j = 0; j < kAtOnce; ++j) {
        const float* p = tile_points(tiles, m.tile[i + j < listed ? i + j : i]);
        x[j] = F16::load(p) - ball.x, y[j] = F16::load(p + 16) - ball.y, z[j] = F16::load(p + 32) - ball.z;
      }
      LANE_UNROLL(4)
      for (int j = 0; j < kAtOnce; ++j) {
        if (i + j >= listed) break;
        const M16 in = squared_norm(x[j], y[j], z[j]) <= ball.r2;
        tail += ring_store<VisitMemory::kRing>(m.ring[0], m.ring[1], m.ring[2], tail, in, x[j], y[j], z[j]);
      }
      pack_sync();
      LANE_ROLLED
      for (; tail - head >= 16; head += 16) {
        const F16 x0 = ring_load<VisitMemory::kRing>(m.ring[u], head),
                  y0 = ring_load<VisitMemory::kRing>(m.ring[v], head);
        totals.add(x0, y0, fnma(a, x0, fnma(b, y0, ring_load<VisitMemory::kRing>(m.ring[w], head))));
      }
      pack_sync();
    }
    listed = 0;
  };
  for_each([&](std::uint32_t block) LANE_INLINE {
    listed += append_bits(m.tile + listed, touched_tiles(tiles, block, ball).boundary, 16 * block);
    if (listed >= VisitMemory::kTiles) sum_boundary();
  });
  sum_boundary();
  count += static_cast<std::int32_t>(tail);
  if (tail != head) {
    // Zeros add nothing to any sum: the last vector is filled up with them.
    const M16 in = lane_numbers() < F16(static_cast<float>(tail - head));
    const F16 zero(0.0f);
    const F16 x0 = select(in, ring_load<VisitMemory::kRing>(m.ring[u], head), zero);
    const F16 y0 = select(in, ring_load<VisitMemory::kRing>(m.ring[v], head), zero);
    const F16 z0 = select(in, ring_load<VisitMemory::kRing>(m.ring[w], head), zero);
    totals.add(x0, y0, fnma(a, x0, fnma(b, y0, z0)));
  }
  totals.store(f.total + slot, f.capacity);
  if (first_lane()) f.total[slot] = static_cast<double>(count);
}

// ---- Fits: one thread each ----------------------------------------------------------------------------------------

/// Moments of a slot's neighbourhood. False: it has too few points.
LANE_FN bool load_moments(const FrameView& f, const FrameQuery& q, std::uint32_t slot, double* m) {
  LANE_UNROLL(35)
  for (int k = 0; k < kernels::kMoments; ++k) m[k] = f.total[static_cast<std::size_t>(k) * f.capacity + slot];
  if (m[0] < static_cast<double>(q.min_points)) return false;
  moments_from_sums(m, q.radius, static_cast<double>(f.plane[f.capacity + slot]),
                    static_cast<double>(f.plane[2 * static_cast<std::size_t>(f.capacity) + slot]));
  return true;
}

/// Taubin's fit. A slot whose neighbourhood ends here gets its sample's end.
LANE_FN void fit_quadric(const FrameView& f, const FrameQuery& q, std::uint32_t slot) {
  double m[kernels::kMoments], c[10], lambda;
  std::uint8_t& end = f.end[f.summed[slot]];
  end = kernels::kEndAffordance;  // so far
  if (!load_moments(f, q, slot, m)) {
    end = kernels::kEndTooFewPoints;
    return;
  }
  if (taubin_fit(m, c, lambda)) {
    end = kernels::kEndFlat;
    return;
  }
  LANE_UNROLL(10)
  for (int k = 0; k < 10; ++k) f.quadric[static_cast<std::size_t>(k) * f.capacity + slot] = c[k];
}

/// Curvature, axis and circle. False: the neighbourhood is no candidate, and its sample has got its end.
LANE_FN bool fit_circle(const FrameView& f, const FrameQuery& q, std::uint32_t slot, kernels::FrameCandidate& out) {
  const std::uint32_t sample = f.summed[slot];
  if (f.end[sample] != kernels::kEndAffordance) return false;
  double m[kernels::kMoments], c[10];
  load_moments(f, q, slot, m);
  LANE_UNROLL(10)
  for (int k = 0; k < 10; ++k) c[k] = f.quadric[static_cast<std::size_t>(k) * f.capacity + slot];
  const Quadric<double> quadric(c);
  const Vec3<double> foot = quadric.foot({0.0, 0.0, 0.0});
  const Principal<double> p = principal_at(quadric, foot);
  const double kappa = median_curvature(quadric, m, foot, p);
  Vec3<double> centre;
  double radius;
  circle_fit(m, p.minor_axis, centre, radius);
  const double circle_radius = radius * q.fit.radius;
  const kernels::End end = kernels::judge_fit(q.fit, false, kappa, circle_radius);
  if (end != kernels::kEndAffordance) {
    f.end[sample] = end;
    return false;
  }
  LANE_UNROLL(3)
  for (int k = 0; k < 3; ++k)
    out.position[k] = static_cast<double>(f.position[3 * static_cast<std::size_t>(sample) + k]);
  const int w = static_cast<int>(f.plane[slot]), u = (w + 1) % 3, v = (w + 2) % 3;
  double R[9];
  LANE_UNROLL(3)
  for (int k = 0; k < 3; ++k) {
    R[k] = k == u ? 1.0 : 0.0, R[3 + k] = k == v ? 1.0 : 0.0, R[6 + k] = k == w ? 1.0 : 0.0;
  }
  const double across[3] = {centre.x, centre.y, centre.z};
  const double axis[3] = {p.minor_axis.x, p.minor_axis.y, p.minor_axis.z};
  const double normal[3] = {p.normal.x, p.normal.y, p.normal.z};
  out.place = kernels::place_fit(q.fit, out.position, R, across, axis, normal);
  out.radius = circle_radius;
  out.curvature = kappa / q.fit.radius;
  out.density = kernels::ball_density(static_cast<std::int32_t>(m[0]), q.fit.radius);
  out.sample = sample;
  return true;
}

// ---- Shells -------------------------------------------------------------------------------------------------------

/// The shell of a candidate; one pack. scratch: f.scratch_words, near: kNear + 16 floats, both of the pack. False: it
/// has none, and its sample has got its end; where the scratch was too small it is counted, and there will be another
/// look.
LANE_FN bool find_shell_of(const FrameView& f, const FrameQuery& q, const kernels::FrameCandidate& c,
                           std::uint32_t* scratch, float* near, kernels::ShellResult& r) {
  const kernels::ShellQuery query = kernels::shell_query(q.shell, q.fit, c.position, c.place, c.radius, c.density);
  const ShellPlace place(query);
  const kernels::Tiles tiles = f.tiles();
  const auto in_ball = [&](const float* b) LANE_INLINE { return touched_boxes(b, place.ball); };
  const auto in_slab = [&](const float* b) LANE_INLINE {
    const float* const rows[6] = {b, b + 16, b + 32, b + 48, b + 64, b + 80};
    return test_slab(rows, 0, place.ball, place.ax, place.ay, place.az, place.width);
  };
  std::int32_t n = 0;
  for_each_block(f, in_ball, in_slab,
                 [&](std::uint32_t block) LANE_INLINE { n += count_bits(shell_tiles(tiles, block, place)); });
  // Numbers of tiles, then squared distances.
  const std::uint32_t list_words = static_cast<std::uint32_t>(n + 16 + 15) / 16 * 16;
  const std::uint32_t words = list_words + 16 * static_cast<std::uint32_t>(n) + 32;
  if (words > f.scratch_words) {
    if (first_lane()) add_one(&f.counts->lost), raise(&f.counts->wanted, words);
    return false;
  }
  std::int32_t listed = 0;
  for_each_block(f, in_ball, in_slab, [&](std::uint32_t block) LANE_INLINE {
    listed += append_bits(scratch + listed, shell_tiles(tiles, block, place), 16 * block);
  });
  shell_among(tiles, scratch, n, query, place, reinterpret_cast<float*>(scratch + list_words), near, r);
  const kernels::End end = kernels::end_of_shell(r);
  if (first_lane()) f.end[c.sample] = end;
  return end == kernels::kEndAffordance;
}

/// Keeps a candidate's shell in a slot; one thread.
LANE_FN void keep_shell(const FrameView& f, std::uint32_t slot, const kernels::FrameCandidate& c,
                        const kernels::ShellResult& r) {
  f.found[slot] = {c.place, c.radius, c.curvature, r.radius, r.free_to, c.sample, 0};
  LANE_UNROLL(3)
  for (int k = 0; k < 3; ++k) {
    f.shell_row(k)[slot] = static_cast<float>(c.place.center[k]);
    f.shell_row(3 + k)[slot] = static_cast<float>(c.place.axis[k]);
  }
  f.shell_row(6)[slot] = static_cast<float>(c.radius);
}

LANE_FN bool same_place(const kernels::Place& a, const kernels::Place& b) {
  bool same = true;
  LANE_UNROLL(3)
  for (int k = 0; k < 3; ++k) same = same && a.center[k] == b.center[k] && a.axis[k] == b.axis[k];
  return same;
}

/// Whether shell i counts, or stands for a place from which an earlier sample has one, too; one pack. i up to the end
/// of the padding.
LANE_FN void mark_copy(const FrameView& f, std::uint32_t i) {
  const std::uint32_t n = f.counts->found;
  const float nan = static_cast<float>(infinity() - infinity());
  bool counts = i < n;
  if (counts) {
    const float *x = f.shell_row(0), *y = f.shell_row(1), *z = f.shell_row(2);
    const F16 xi(x[i]), yi(y[i]), zi(z[i]);
    LANE_SIDE_BY_SIDE
    for (std::uint32_t j = 0; j < n; j += 16) {
      const auto lane = [&](const float* row) LANE_INLINE {
        return by_lane([&](std::uint32_t k) LANE_INLINE { return j + k < n ? row[j + k] : nan; });
      };
      const F16 dx = abs(lane(x) - xi), dy = abs(lane(y) - yi), dz = abs(lane(z) - zi);
      std::uint32_t same = bits((dx <= F16(0.0f)) & (dy <= F16(0.0f)) & (dz <= F16(0.0f)));
      for (; same; same &= same - 1) {
        const std::uint32_t other = j + static_cast<std::uint32_t>(lowest_bit(same));
        if (f.found[other].sample < f.found[i].sample && same_place(f.found[other].place, f.found[i].place))
          counts = false;
      }
    }
  }
  if (first_lane()) f.shell_row(7)[i] = counts ? f.shell_row(0)[i] : nan;
}

/// With how many shells shell i is aligned; one pack.
LANE_FN void count_aligned(const FrameView& f, const FrameQuery& q, std::uint32_t i) {
  const kernels::AffordanceArrays arrays = f.shell_arrays(f.counts->found);
  const std::int32_t n = count_row(arrays, static_cast<std::int32_t>(i), q.align);
  if (first_lane()) f.found[i].aligned = static_cast<std::uint32_t>(n);
}

}  // namespace handhold::HANDHOLD_LANE
