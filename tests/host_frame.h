// A DeviceFrame without a device: the stages of a GPU's frame on the CPU, so that they, and what calls them, are tested
// where there is no GPU.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <vector>

#include "aligned.h"
#include "device_frame.h"
#include "host_stages.h"
#include "kernels.h"
#include "tiles.h"

namespace handhold::test {

class HostFrame final : public DeviceFrame {
 public:
  /// Its packs must round as the CPU's kernels in use do.
  static bool same_rounding() {
    const std::string isa = kernels::kernels().name;
    return isa == "avx2" || isa == "avx512" || isa == "neon";
  }

  /// scratch: words for a shell, to begin with
  explicit HostFrame(std::uint32_t scratch = 8192) { view_.scratch_words = scratch; }

  void take(const CloudView& cloud, const RobustBounds& bounds) override {
    const std::size_t n = cloud.size();
    source_.resize(3 * n);
    for (std::size_t i = 0; i < n; ++i) std::copy_n(cloud.point(i), 3, &source_[3 * i]);
    const bool organized = is_image(cloud);
    const std::uint32_t across = (cloud.width + 15) / 16, down = (cloud.height + 15) / 16;
    FrameView& f = view_;
    counts_ = {};
    f.source = source_.data(), f.source_step = 3, f.width = cloud.width, f.height = cloud.height;
    f.blocks = organized ? across * down : static_cast<std::uint32_t>((n + 255) / 256);
    f.regions = (f.blocks + 4095) / 4096 * 16;
    order_.resize(f.blocks);
    if (organized) order_blocks(across, down, order_.data());
    f.order = organized ? order_.data() : nullptr;
    sorted_.clear();
    if (!organized) {
      const kernels::MortonCells cells = bounds.cells();
      std::vector<std::uint64_t> key(n);
      for (std::uint32_t i = 0; i < n; ++i) {
        if (!usable(cloud.point(i))) continue;
        key[i] = cells.number(cloud.point(i));
        sorted_.push_back(i);
      }
      std::stable_sort(sorted_.begin(), sorted_.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return key[a] < key[b]; });
      counts_.finite = static_cast<std::uint32_t>(sorted_.size());
    }
    f.sorted = sorted_.data();
    f.points = room(points_, 768, f.blocks), f.boxes = room(boxes_, 96, f.blocks);
    f.sums = room(sums_, 160, f.blocks), f.full = room(full_, 1, f.blocks), f.before = room(before_, 16, f.blocks);
    f.block_boxes = room(block_boxes_, 96 * 16, f.regions), f.group_boxes = room(group_boxes_, 96, f.regions);
    f.region_boxes = room(region_boxes_, 6, f.regions);
    f.block_points = room(block_points_, 1, f.blocks), f.first_rank = room(first_rank_, 1, f.blocks + 1);
    f.counts = &counts_;
    host_tiles(f);
  }
  void draw(const kernels::FrameQuery* rounds, std::uint32_t n) override {
    rounds_.assign(rounds, rounds + n), drawn_ = true;
    make_room();
    host_look(view_, rounds_.data(), n, true);
  }
  void look(const kernels::FrameQuery& q, const float* xyz) override {
    rounds_ = {q}, drawn_ = false;
    make_room();
    std::copy_n(xyz, 3 * static_cast<std::size_t>(q.samples), position_.data());
    host_look(view_, &q, 1, false);
  }
  Found wait() override {
    while (counts_.lost > 0) {
      ++times_grown;
      view_.scratch_words = (counts_.wanted + 15) / 16 * 16;
      view_.scratch = room(scratch_, 1, view_.scratch_words);
      host_look(view_, rounds_.data(), static_cast<std::uint32_t>(rounds_.size()), drawn_);
    }
    return {counts_.finite, end_.data(), found_.data(), counts_.found};
  }
  void positions(float* xyz) override { std::copy_n(position_.data(), 3 * static_cast<std::size_t>(samples()), xyz); }
  void add_times(StageTimes&) const override {}

  int times_grown = 0;

 private:
  using FrameView = kernels::FrameView;

  template <class T>
  static T* room(AlignedArray<T>& array, std::size_t each, std::size_t n) {
    array.require(std::max<std::size_t>(1, each * n));
    // What is read must have been written.
    std::memset(static_cast<void*>(array.data()), 0xA5, each * n * sizeof(T));
    return array.data();
  }
  std::uint32_t samples() const { return rounds_.back().first + rounds_.back().samples; }
  void make_room() {
    FrameView& f = view_;
    const std::size_t n = f.capacity = samples();
    f.centres = room(centres_, 3, n);
    f.position = room(position_, 3, n), f.end = room(end_, 1, n), f.summed = room(summed_, 1, n);
    f.listed = room(listed_, 17, n);
    f.plane = room(plane_, 3, n), f.total = room(total_, kernels::kMoments, n), f.quadric = room(quadric_, 10, n);
    f.candidates = room(candidates_, 1, n), f.found = room(found_, 1, n);
    f.shells = room(shells_, 8, (n + 15) / 16 * 16);
    f.scratch = room(scratch_, 1, f.scratch_words);
  }

  FrameView view_{};
  std::vector<kernels::FrameQuery> rounds_;
  bool drawn_ = false;
  kernels::FrameCounts counts_{};
  std::vector<float> source_;
  std::vector<std::uint32_t> order_, sorted_;
  AlignedArray<float> points_, boxes_, sums_, block_boxes_, group_boxes_, region_boxes_, position_, plane_, shells_;
  AlignedArray<std::uint16_t> full_, before_;
  AlignedArray<std::uint32_t> block_points_, first_rank_, summed_, listed_, scratch_;
  AlignedArray<std::uint8_t> end_;
  AlignedArray<double> total_, quadric_, centres_;
  AlignedArray<kernels::FrameCandidate> candidates_;
  AlignedArray<kernels::FoundShell> found_;
};

}  // namespace handhold::test
