// The stages of a frame on a GPU (kernels/cuda/stages.h), gone through one after the other on the CPU.
#pragma once

#include "cuda/frame.h"

namespace handhold::test {

/// Tiles, ranks and boxes of a cloud; f.counts->finite must be right for an unorganized one.
void host_tiles(const kernels::FrameView& f);
/// Rounds of samples; `draw`: also the first one's are drawn.
void host_look(const kernels::FrameView& f, const kernels::FrameQuery* rounds, std::uint32_t n_rounds, bool draw);

}  // namespace handhold::test
