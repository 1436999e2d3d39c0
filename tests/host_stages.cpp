// Compiled for the instruction set whose packs round as a GPU does. Nothing here but the kernels' own headers: what a
// standard header defines inline would be this instruction set's for the whole program.
#if defined(__AVX2__)
#define HANDHOLD_ISA_AVX2
#elif defined(__aarch64__)
#define HANDHOLD_ISA_NEON
#endif
#define HANDHOLD_LANE lane_host_stages
#include "host_stages.h"

#include "cuda/stages.h"

namespace handhold::test {

using namespace lane_host_stages;

void host_tiles(const kernels::FrameView& f) {
  for (std::uint32_t b = 0; b < f.blocks; ++b) {
    for (std::uint32_t t = 0; t < kernels::kBlockTiles; ++t) build_tile(f, b, t);
    finish_tiles_of(f, b);
  }
  std::uint32_t before = 0;
  for (std::uint32_t b = 0; b < f.blocks; ++b) f.first_rank[b] = before, before += f.block_points[b];
  f.first_rank[f.blocks] = f.counts->finite = before;
  for (std::uint32_t group = 0; group < 16 * f.regions; ++group) build_group(f, group);
  for (std::uint32_t region = 0; region < f.regions; ++region) build_region(f, region);
}

namespace {

void propose_sample(const kernels::FrameView& f, const kernels::FrameQuery& q, std::uint32_t i, float* xyz) {
  double x[3];
  for (std::uint32_t attempt = 0; f.counts->found > 0 && attempt < kernels::kTries; ++attempt)
    if (propose(f, q, i, attempt, x) && snap(f, q, x, xyz)) return;
  draw_sample(f, q, i, xyz);
}

}  // namespace

void host_look(const kernels::FrameView& f, const kernels::FrameQuery* rounds, std::uint32_t n_rounds, bool draw) {
  kernels::FrameCounts& n = *f.counts;
  n.found = n.ordered = n.lost = n.wanted = 0;
  for (std::uint32_t round = 0; round < n_rounds; ++round) {
    const kernels::FrameQuery& q = rounds[round];
    for (std::uint32_t i = n.ordered; i < n.found; ++i) order_centre(f, i);
    n.ordered = n.found;
    n.summed = n.candidates = 0;
    for (std::uint32_t i = 0; i < q.samples; ++i) {
      const std::uint32_t sample = q.first + i;
      float* place = f.position + 3 * static_cast<std::size_t>(sample);
      if (n.finite == 0) {
        f.end[sample] = kernels::kEndTooFewPoints;
        continue;
      }
      if (round > 0) {
        propose_sample(f, q, i, place);
      } else if (draw) {
        draw_sample(f, q, i, place);
      }
      RoughPlane<float> plane;
      BlockList blocks;
      if (look_at(f, q, sample, place, plane, blocks)) keep_slot(f, add_one(&n.summed), sample, plane, blocks);
    }
    VisitMemory visit;
    for (std::uint32_t slot = 0; slot < n.summed; ++slot) sum_points(f, q, slot, visit);
    for (std::uint32_t slot = 0; slot < n.summed; ++slot) {
      fit_quadric(f, q, slot);
      kernels::FrameCandidate candidate;
      if (fit_circle(f, q, slot, candidate)) f.candidates[add_one(&n.candidates)] = candidate;
    }
    alignas(64) float near[kNear + 16];
    // From the last one on: a device finds them in any order.
    for (std::uint32_t i = n.candidates; i-- > 0;) {
      kernels::ShellResult r;
      if (find_shell_of(f, q, f.candidates[i], f.scratch, near, r))
        keep_shell(f, add_one(&n.found), f.candidates[i], r);
    }
  }
  for (std::uint32_t i = 0; i < (n.found + 15) / 16 * 16; ++i) mark_copy(f, i);
  for (std::uint32_t i = 0; i < n.found; ++i) count_aligned(f, rounds[0], i);
}

}  // namespace handhold::test
