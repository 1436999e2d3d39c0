// Packs points into the kernels' tiles in plain code, without an index: what a kernel is called with in tests.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "kernels.h"
#include "test_clouds.h"

namespace handhold::test {

/// 64 bytes where a kernel may load a whole vector.
struct alignas(64) Line {
  float v[16];
};
using Lines = std::vector<Line>;
inline float* floats(Lines& lines) {
  return lines.empty() ? nullptr : lines.front().v;
}
inline const float* floats(const Lines& lines) {
  return lines.empty() ? nullptr : lines.front().v;
}

/// Every table of kernels that this machine runs.
inline std::vector<const kernels::Kernels*> all_kernels() {
  int count = 0;
  const char* const* names = kernels::available(&count);
  std::vector<const kernels::Kernels*> tables;
  for (int i = 0; i < count; ++i) tables.push_back(kernels::kernels(names[i]));
  return tables;
}

/// The tables whose results must agree to the bit; a machine that runs none of them compares "scalar" with itself.
inline std::vector<const kernels::Kernels*> bitwise_kernels() {
  std::vector<const kernels::Kernels*> tables;
  for (const kernels::Kernels* table : all_kernels())
    if (std::string(table->name) != "scalar") tables.push_back(table);
  if (tables.empty()) tables = all_kernels();
  return tables;
}

/// A tile of 16 points with a corner of its box at `corner`: one point there, the others between it and `other`.
inline FloatPoints tile_with_corner(Random& random, const Vector3d& corner, const Vector3d& other) {
  FloatPoints tile = {corner.cast<float>(), other.cast<float>()};
  while (tile.size() < 16) {
    Vector3d p;
    for (int i = 0; i < 3; ++i) p[i] = corner[i] + random.uniform(0.05, 1) * (other[i] - corner[i]);
    tile.push_back(p.cast<float>());
  }
  random.shuffle(tile);
  return tile;
}

/// Whether two plain structs or arrays hold the same bits.
template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}
template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// How points come into tiles.
struct Packing {
  int fill = kernels::kTilePoints;  ///< points of a tile: fewer leaves the rest of it missing
  bool ordered =
      false;  ///< sort along x, then y and z within slabs, so that tiles are compact and some lie wholly in a ball
};

/// Tiles of a cloud, finished by one table's finish_block, and the candidate list of all their blocks.
class PackedCloud {
 public:
  PackedCloud(const kernels::Kernels& table, FloatPoints points, const Packing& packing = {});

  kernels::Tiles tiles() const;
  kernels::Candidates candidates() const;
  /// Scratch with a watched border behind it; see `scratch_border_intact`.
  void* scratch() { return scratch_.data(); }
  bool scratch_border_intact() const;

  std::int32_t blocks() const { return blocks_; }
  std::int32_t finite() const { return finite_; }  ///< as finish_block counted
  /// Everything that finish_block wrote.
  const Lines& points() const { return points_; }
  const Lines& boxes() const { return boxes_; }
  const Lines& sums() const { return sums_; }
  const std::vector<std::uint16_t>& full() const { return full_; }

 private:
  static constexpr int kTile = kernels::kTilePoints;
  static constexpr int kTiles = kernels::kBlockTiles;
  static constexpr int kBorder = 16;  // lines
  static constexpr unsigned char kMark = 0xA5;

  void list_candidates();

  std::int32_t blocks_ = 0, finite_ = 0, padded_ = 0;
  Lines points_, boxes_, sums_;      // 3 lines a tile; 6 and 10 a block
  std::vector<std::uint16_t> full_;  // a block
  Lines candidate_boxes_[6];
  std::vector<std::uint32_t> candidate_block_;
  Lines scratch_;
};

/// Sorts points so that 16 in a row are near each other: slabs along x, rows along y, then z. Points that are not
/// finite come last.
inline void sort_compactly(FloatPoints& points, float cell = 0.008f) {
  const auto key = [cell](float v) { return std::isfinite(v) && std::abs(v) < 1e6f ? std::floor(v / cell) : 1e9f; };
  std::stable_sort(points.begin(), points.end(), [&key](const Vector3f& a, const Vector3f& b) {
    for (int i = 0; i < 3; ++i)
      if (key(a[i]) != key(b[i])) return key(a[i]) < key(b[i]);
    return false;
  });
}

inline PackedCloud::PackedCloud(const kernels::Kernels& table, FloatPoints points, const Packing& packing) {
  if (packing.ordered) sort_compactly(points);
  const int count = static_cast<int>(points.size());
  const int tiles = (count + packing.fill - 1) / packing.fill;
  blocks_ = (tiles + kTiles - 1) / kTiles;
  Line missing;
  std::fill(std::begin(missing.v), std::end(missing.v), kernels::kFar);
  points_.assign(static_cast<std::size_t>(blocks_) * kTiles * 3, missing);
  boxes_.resize(static_cast<std::size_t>(blocks_) * 6);
  sums_.resize(static_cast<std::size_t>(blocks_) * 10);
  full_.resize(blocks_);
  for (int i = 0; i < count; ++i) {
    const std::size_t tile = i / packing.fill;
    for (int axis = 0; axis < 3; ++axis) points_[3 * tile + axis].v[i % packing.fill] = points[i][axis];
  }
  for (int b = 0; b < blocks_; ++b) {
    finite_ += table.finish_block(points_[static_cast<std::size_t>(b) * kTiles * 3].v,
                                  boxes_[static_cast<std::size_t>(b) * 6].v, &full_[b],
                                  sums_[static_cast<std::size_t>(b) * 10].v);
  }
  list_candidates();
  scratch_.resize((kernels::scratch_bytes(blocks_) + 63) / 64 + kBorder);
  std::memset(scratch_.data(), kMark, scratch_.size() * sizeof(Line));
}

inline void PackedCloud::list_candidates() {
  padded_ = (blocks_ + 15) / 16 * 16;
  candidate_block_.assign(
      padded_, 0);  // padding names block 0, so that a kernel which looks behind an empty box counts it twice
  for (int side = 0; side < 6; ++side) {
    candidate_boxes_[side].resize(padded_ / 16);
    for (int i = 0; i < padded_; ++i) {
      float bound = side < 3 ? kernels::kFar : -kernels::kFar;
      for (int t = 0; i < blocks_ && t < kTiles; ++t) {
        const float tile = boxes_[static_cast<std::size_t>(i) * 6 + side].v[t];
        bound = side < 3 ? std::min(bound, tile) : std::max(bound, tile);
      }
      candidate_boxes_[side][i / 16].v[i % 16] = bound;
    }
  }
  for (int i = 0; i < blocks_; ++i) candidate_block_[i] = static_cast<std::uint32_t>(i);
}

inline kernels::Tiles PackedCloud::tiles() const {
  return {floats(points_), floats(boxes_), full_.data(), floats(sums_), blocks_};
}

inline kernels::Candidates PackedCloud::candidates() const {
  kernels::Candidates list{};
  for (int side = 0; side < 6; ++side) list.boxes[side] = floats(candidate_boxes_[side]);
  list.block = candidate_block_.data();
  list.padded = padded_;
  return list;
}

inline bool PackedCloud::scratch_border_intact() const {
  const auto* bytes = reinterpret_cast<const unsigned char*>(scratch_.data());
  const std::size_t used = kernels::scratch_bytes(blocks_), all = scratch_.size() * sizeof(Line);
  return std::all_of(bytes + used, bytes + all, [](unsigned char b) { return b == kMark; });
}

}  // namespace handhold::test
