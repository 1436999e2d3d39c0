#include "cuda_frame.h"

#include <cuda_runtime.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <string>

#include <cub/block/block_scan.cuh>
#include <cub/device/device_radix_sort.cuh>

#include "handhold/device.h"
#include "tiles.h"

#define HANDHOLD_ISA_CUDA
#define HANDHOLD_LANE lane_cuda
#include "cuda/block_shell.h"

namespace handhold {
namespace lane_cuda {
namespace {

using kernels::FrameCandidate;
using kernels::FrameCounts;
using kernels::FrameQuery;
using kernels::FrameView;

/// What a frame's time goes to.
enum Part { kIndex, kSamples, kMoments, kFit, kShell, kAlign, kParts };
/// What comes back before the samples' ends and the shells.
struct alignas(64) ReportHead {
  FrameCounts counts;
  int part;                          ///< that is under way
  unsigned long long began, ended;   ///< when it began, and the last one ended (ns)
  unsigned long long spent[kParts];  ///< ns; of those before it
};

constexpr int kPack = 16;           ///< threads of a pack
constexpr int kTileThreads = 256;   ///< of a block of tiles: a pack each
constexpr int kScanThreads = 1024;  ///< of the block that numbers the points
constexpr int kProposeThreads = 256, kLookThreads = 256, kSumThreads = 128, kFitThreads = 64, kAlignThreads = 128;

__device__ unsigned long long now() {
  unsigned long long t;
  asm volatile("mov.u64 %0, %%globaltimer;" : "=l"(t));
  return t;
}
/// A kernel begins a part. Kernels of a frame run one after the other, so this is nobody else's.
__device__ void begin_part(ReportHead* report, Part part) {
  if (blockIdx.x > 0 || threadIdx.x > 0) return;
  const unsigned long long t = now();
  if (report->began != 0) report->spent[report->part] += t - report->began;
  report->began = t, report->part = part;
}
/// The pack's number in its thread block, and in the grid.
__device__ unsigned pack_in_block() {
  return threadIdx.x / kPack;
}
__device__ unsigned pack_in_grid() {
  return blockIdx.x * (blockDim.x / kPack) + pack_in_block();
}
/// The next piece of work, for the pack.
__device__ std::uint32_t take_next(std::uint32_t* next) {
  std::uint32_t i = 0;
  if (first_lane()) i = add_one(next);
  return from_first_lane(i);
}

/// Cells of the points; missing ones come last.
template <class Key>
__global__ void key_kernel(FrameView f, kernels::MortonCells cells, std::uint32_t n, Key* key, std::uint32_t* number) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  bool there = false;
  if (i < n) {
    const float* p = f.source + static_cast<std::size_t>(i) * f.source_step;
    there = ::fabsf(p[0]) <= kLargestCoordinate && ::fabsf(p[1]) <= kLargestCoordinate &&
            ::fabsf(p[2]) <= kLargestCoordinate;
    key[i] = there ? static_cast<Key>(cells.number(p)) : Key{1} << (3 * cells.bits);
    number[i] = i;
  }
  const int points = __syncthreads_count(there);
  if (threadIdx.x == 0 && points > 0) atomicAdd(&f.counts->finite, static_cast<unsigned>(points));
}

__global__ void __launch_bounds__(kTileThreads) tile_kernel(FrameView f, ReportHead* report) {
  begin_part(report, kIndex);
  build_tile(f, blockIdx.x, pack_in_block());
  __syncthreads();
  if (threadIdx.x < kPack) finish_tiles_of(f, blockIdx.x);
}

/// The first thread block numbers the points; each of the others builds the boxes over a region's blocks.
__global__ void __launch_bounds__(kScanThreads) tree_kernel(FrameView f) {
  if (blockIdx.x > 0) {
    const std::uint32_t region = blockIdx.x - 1;
    if (threadIdx.x < kTileThreads) build_group(f, 16 * region + pack_in_block());
    __syncthreads();
    if (threadIdx.x < kPack) build_region(f, region);
    return;
  }
  using Scan = cub::BlockScan<std::uint32_t, kScanThreads>;
  __shared__ typename Scan::TempStorage storage;
  const std::uint32_t each = (f.blocks + kScanThreads - 1) / kScanThreads;
  const std::uint32_t first = ::min(f.blocks, threadIdx.x * each), last = ::min(f.blocks, first + each);
  std::uint32_t sum = 0, before = 0, all = 0;
  for (std::uint32_t b = first; b < last; ++b) sum += f.block_points[b];
  Scan(storage).ExclusiveSum(sum, before, all);
  for (std::uint32_t b = first; b < last; ++b) f.first_rank[b] = before, before += f.block_points[b];
  if (threadIdx.x == 0) f.first_rank[f.blocks] = all, f.counts->finite = all;
}

/// A round's proposals, a block a sample: its packs make as many attempts side by side, and the first that is accepted
/// counts.
__global__ void __launch_bounds__(kProposeThreads, 2) propose_kernel(FrameView f, const FrameQuery* query) {
  constexpr unsigned kAttempts = kProposeThreads / kPack;
  __shared__ unsigned first;
  __shared__ double accepted[3];
  __shared__ bool near;
  const FrameQuery& q = *query;
  const std::uint32_t sample = blockIdx.x;  // of the round
  if (f.counts->finite == 0) return;
  float* place = f.position + 3 * static_cast<std::size_t>(q.first + sample);
  float xyz[3];
  for (unsigned attempt = 0; f.counts->found > 0 && attempt < kernels::kTries;) {
    unsigned chosen = kernels::kTries;
    for (; attempt < kernels::kTries && chosen == kernels::kTries; attempt += kAttempts) {
      __syncthreads();
      if (threadIdx.x == 0) first = kernels::kTries;
      __syncthreads();
      const unsigned own = attempt + pack_in_block();
      double x[3];
      const bool good = own < kernels::kTries && propose(f, q, sample, own, x);
      if (good && first_lane()) atomicMin(&first, own);
      __syncthreads();
      chosen = first;
      if (good && own == chosen && first_lane()) accepted[0] = x[0], accepted[1] = x[1], accepted[2] = x[2];
    }
    if (chosen == kernels::kTries) break;
    __syncthreads();
    if (threadIdx.x < kPack) {
      const double x[3] = {accepted[0], accepted[1], accepted[2]};
      const bool found = snap(f, q, x, xyz);
      if (threadIdx.x == 0) {
        near = found;
        if (found) place[0] = xyz[0], place[1] = xyz[1], place[2] = xyz[2];
      }
    }
    __syncthreads();
    if (near) return;
    attempt = chosen + 1;  // far from the cloud: it is drawn again
  }
  if (threadIdx.x != 0) return;
  draw_sample(f, q, sample, xyz);
  place[0] = xyz[0], place[1] = xyz[1], place[2] = xyz[2];
}

/// A pack a sample. `draw`: it is drawn here.
template <bool draw>
__global__ void __launch_bounds__(kLookThreads) look_kernel(FrameView f, const FrameQuery* query, ReportHead* report) {
  begin_part(report, kMoments);
  const FrameQuery& q = *query;
  if (pack_in_grid() >= q.samples) return;
  const std::uint32_t sample = q.first + pack_in_grid();
  float* place = f.position + 3 * static_cast<std::size_t>(sample);
  float centre[3];
  if (f.counts->finite == 0) {
    if (first_lane()) f.end[sample] = kernels::kEndTooFewPoints, place[0] = place[1] = place[2] = 0.0f;
    return;
  }
  if (draw) {
    draw_sample(f, q, sample - q.first, centre);
    if (first_lane()) place[0] = centre[0], place[1] = centre[1], place[2] = centre[2];
  } else {
    centre[0] = place[0], centre[1] = place[1], centre[2] = place[2];
  }
  RoughPlane<float> plane;
  BlockList blocks;
  if (look_at(f, q, sample, centre, plane, blocks)) keep_slot(f, take_next(&f.counts->summed), sample, plane, blocks);
}

__global__ void __launch_bounds__(kSumThreads) sum_kernel(FrameView f, const FrameQuery* query) {
  __shared__ VisitMemory visit[kSumThreads / kPack];
  const FrameQuery& q = *query;
  for (std::uint32_t slot; (slot = take_next(&f.counts->next_sum)) < f.counts->summed;)
    sum_points(f, q, slot, visit[pack_in_block()]);
}

__global__ void __launch_bounds__(kFitThreads)
    quadric_kernel(FrameView f, const FrameQuery* query, ReportHead* report) {
  begin_part(report, kFit);
  const std::uint32_t slot = blockIdx.x * kFitThreads + threadIdx.x;
  if (slot < f.counts->summed) fit_quadric(f, *query, slot);
}

__global__ void __launch_bounds__(kFitThreads) circle_kernel(FrameView f, const FrameQuery* query) {
  const std::uint32_t slot = blockIdx.x * kFitThreads + threadIdx.x;
  FrameCandidate candidate;
  if (slot < f.counts->summed && fit_circle(f, *query, slot, candidate))
    f.candidates[add_one(&f.counts->candidates)] = candidate;
}

/// A block a candidate.
__global__ void __launch_bounds__(kShellThreads)
    shell_kernel(FrameView f, const FrameQuery* query, ReportHead* report) {
  begin_part(report, kShell);
  __shared__ BlockShell shared;
  __shared__ std::uint32_t next;
  std::uint32_t* scratch = f.scratch + static_cast<std::size_t>(blockIdx.x) * f.scratch_words;
  for (;;) {
    if (threadIdx.x == 0) next = add_one(&f.counts->next_shell);
    __syncthreads();
    const std::uint32_t i = next;
    if (i >= f.counts->candidates) break;
    const FrameCandidate& c = f.candidates[i];
    kernels::ShellResult r;
    if (block_shell_of(f, *query, c, scratch, shared, r) && threadIdx.x == 0)
      keep_shell(f, add_one(&f.counts->found), c, r);
    __syncthreads();
  }
  if (threadIdx.x == 0) atomicMax(&report->ended, now());
}

/// The centres of a round's shells: what the next one draws about.
__global__ void __launch_bounds__(kAlignThreads) order_kernel(FrameView f, ReportHead* report) {
  begin_part(report, kSamples);
  const std::uint32_t packs = gridDim.x * (kAlignThreads / kPack), found = f.counts->found;
  for (std::uint32_t i = f.counts->ordered + pack_in_grid(); i < found; i += packs) order_centre(f, i);
}
/// A round begins.
__global__ void round_kernel(FrameCounts* counts) {
  counts->ordered = counts->found;
  counts->summed = counts->candidates = counts->next_sum = counts->next_shell = 0;
}

/// A pack a shell, again and again: how many there are is known only here.
__global__ void __launch_bounds__(kAlignThreads) copy_kernel(FrameView f, ReportHead* report) {
  begin_part(report, kAlign);
  const std::uint32_t packs = gridDim.x * (kAlignThreads / kPack), padded = (f.counts->found + 15) / 16 * 16;
  for (std::uint32_t i = pack_in_grid(); i < padded; i += packs) mark_copy(f, i);
}
__global__ void __launch_bounds__(kAlignThreads)
    align_kernel(FrameView f, const FrameQuery* query, ReportHead* report) {
  const std::uint32_t packs = gridDim.x * (kAlignThreads / kPack), found = f.counts->found;
  for (std::uint32_t i = pack_in_grid(); i < found; i += packs) count_aligned(f, *query, i);
  if (threadIdx.x == 0) atomicMax(&report->ended, now());
}

}  // namespace
}  // namespace lane_cuda

namespace {

using lane_cuda::ReportHead;

void check(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // so that the next call does not report it again
  throw DeviceError(std::string("CUDA: ") + what + ": " + cudaGetErrorString(error));
}

/// The calling thread's current device is ours while this lives, and afterwards what it was.
class OnDevice {
 public:
  OnDevice() {
    check(cudaGetDevice(&before_), "the current device");
    if (before_ != 0) check(cudaSetDevice(0), "the first device");
  }
  ~OnDevice() {
    if (before_ != 0) cudaSetDevice(before_);
  }
  OnDevice(const OnDevice&) = delete;
  OnDevice& operator=(const OnDevice&) = delete;

 private:
  int before_ = 0;
};

/// Memory of the device, or (pinned) of the host, that grows and is not copied when it does.
template <class T, bool host = false>
class Memory {
 public:
  Memory() = default;
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() { free(); }
  /// True: it is elsewhere now.
  bool require(std::size_t n) {
    if (n <= size_) return false;
    free();
    const std::size_t bytes = n * sizeof(T);
    const std::string what =
        std::to_string((bytes >> 20) + 1) + " MiB of " + (host ? "pinned host" : "device") + " memory";
    check(host ? cudaMallocHost(reinterpret_cast<void**>(&data_), bytes)
               : cudaMalloc(reinterpret_cast<void**>(&data_), bytes),
          what.c_str());
    size_ = n;
    return true;
  }
  T* get() const { return data_; }
  std::size_t size() const { return size_; }

 private:
  void free() {
    if (data_) host ? cudaFreeHost(data_) : cudaFree(data_);
    data_ = nullptr, size_ = 0;
  }
  T* data_ = nullptr;
  std::size_t size_ = 0;
};
template <class T>
using Pinned = Memory<T, true>;

constexpr std::uint32_t kFirstScratch = 16384;  ///< words of a thread block: 1,024 tiles of points

}  // namespace

CudaDevice cuda_device() {
  CudaDevice device;
  int count = 0, version = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  if (error != cudaSuccess || count == 0) {
    cudaGetLastError();
    device.reason =
        cudaDriverGetVersion(&version) != cudaSuccess || version == 0
            ? "there is no NVIDIA driver"
            : std::string("no NVIDIA GPU: ") + cudaGetErrorString(error == cudaSuccess ? cudaErrorNoDevice : error);
    cudaGetLastError();
    return device;
  }
  cudaDeviceProp properties;
  if (const cudaError_t e = cudaGetDeviceProperties(&properties, 0); e != cudaSuccess) {
    cudaGetLastError();
    device.reason = std::string("the NVIDIA GPU does not answer: ") + cudaGetErrorString(e);
    return device;
  }
  // Whether there is code for it, not only a card.
  cudaFuncAttributes attributes;
  if (cudaFuncGetAttributes(&attributes, lane_cuda::tree_kernel) != cudaSuccess) {
    cudaGetLastError();
    device.reason = std::string("the kernels are not built for the ") + properties.name + " (compute capability " +
                    std::to_string(properties.major) + "." + std::to_string(properties.minor) + ")";
    return device;
  }
  device.available = true;
  device.name = properties.name;
  return device;
}

PinnedMemory::PinnedMemory(const void* data, std::size_t bytes) {
  if (data && bytes > 0 && cudaHostRegister(const_cast<void*>(data), bytes, cudaHostRegisterDefault) == cudaSuccess)
    data_ = data;
  cudaGetLastError();
}
PinnedMemory::~PinnedMemory() {
  if (data_) cudaHostUnregister(const_cast<void*>(data_));
  cudaGetLastError();
}

std::unique_ptr<DeviceFrame> make_cuda_frame() {
  return std::make_unique<CudaFrame>();
}

struct CudaFrame::Impl {
  Impl() {
    const OnDevice on;
    check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "a stream");
    for (cudaEvent_t& e : event) check(cudaEventCreate(&e), "an event");
    int multiprocessors = 0, blocks = 0;
    check(cudaDeviceGetAttribute(&multiprocessors, cudaDevAttrMultiProcessorCount, 0), "number of multiprocessors");
    using namespace lane_cuda;
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, sum_kernel, kSumThreads, 0), "occupancy");
    sum_blocks = static_cast<unsigned>(multiprocessors * std::max(1, blocks));
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, shell_kernel, kShellThreads, 0), "occupancy");
    shell_blocks = static_cast<unsigned>(multiprocessors * std::max(1, blocks));
    align_blocks = static_cast<unsigned>(4 * multiprocessors);
    scratch.require(std::size_t{kFirstScratch} * shell_blocks);
    view.scratch = scratch.get(), view.scratch_words = kFirstScratch;
    query.require(1), sent.require(1);
  }
  ~Impl() {
    if (stream) cudaStreamSynchronize(stream);
    forget_graphs();
    for (cudaEvent_t e : event) {
      if (e) cudaEventDestroy(e);
    }
    if (stream) cudaStreamDestroy(stream);
  }

  // ---- Graphs -----------------------------------------------------------------------------------------------------

  enum Part : unsigned { kCloud = 1, kDraw = 2, kLook = 4 };
  struct Graph {
    unsigned parts;
    std::vector<std::uint32_t> samples;  ///< of each round
    cudaGraphExec_t exec;
  };

  void forget_graphs() {
    for (const Graph& g : graphs) cudaGraphExecDestroy(g.exec);
    graphs.clear();
  }

  /// With the rounds of the last draw or look.
  void launch(unsigned parts) {
    for (const Graph& g : graphs) {
      if (g.parts == parts && (parts == kCloud || g.samples == rounds)) {
        check(cudaGraphLaunch(g.exec, stream), "a graph's launch");
        return;
      }
    }
    if (graphs.size() >= 16) forget_graphs();
    // Another thread's allocations must not disturb the capture, nor it them.
    check(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), "a graph's beginning");
    cudaGraph_t graph = nullptr;
    try {
      if (parts & kCloud) run_cloud();
      if (parts & (kDraw | kLook)) run_look(parts & kDraw);
    } catch (...) {
      cudaStreamEndCapture(stream, &graph);
      if (graph) cudaGraphDestroy(graph);
      throw;
    }
    check(cudaStreamEndCapture(stream, &graph), "a graph's end");
    cudaGraphExec_t exec = nullptr;
    const cudaError_t error = cudaGraphInstantiate(&exec, graph, 0);
    cudaGraphDestroy(graph);
    check(error, "a graph");
    graphs.push_back({parts, rounds, exec});
    check(cudaGraphLaunch(exec, stream), "a graph's launch");
  }

  // ---- Stages, in the stream --------------------------------------------------------------------------------------

  ReportHead* head() const { return reinterpret_cast<ReportHead*>(report.get()); }
  void launched() { check(cudaGetLastError(), "a kernel's launch"); }

  template <class Key>
  void sort_points(Key* keys, Key* other_keys) {
    const auto n = static_cast<std::uint32_t>(points);
    lane_cuda::key_kernel<<<(n + 255) / 256, 256, 0, stream>>>(view, cells, n, keys, numbers.get());
    launched();
    std::size_t bytes = sort_memory.size();
    check(cub::DeviceRadixSort::SortPairs(sort_memory.get(), bytes, keys, other_keys, numbers.get(), sorted.get(),
                                          static_cast<int>(n), 0, 3 * cells.bits + 1, stream),
          "sorting");
  }
  bool narrow_keys() const { return 3 * cells.bits + 1 <= 32; }

  void run_tiles() {
    check(cudaMemsetAsync(head(), 0, sizeof(ReportHead), stream), "clearing counts");
    if (!view.order) {
      if (narrow_keys()) {
        sort_points(reinterpret_cast<std::uint32_t*>(keys.get()), reinterpret_cast<std::uint32_t*>(other_keys.get()));
      } else {
        sort_points(keys.get(), other_keys.get());
      }
    }
    lane_cuda::tile_kernel<<<view.blocks, lane_cuda::kTileThreads, 0, stream>>>(view, head());
    launched();
  }
  void run_tree() {
    lane_cuda::tree_kernel<<<1 + view.regions, lane_cuda::kScanThreads, 0, stream>>>(view);
    launched();
  }
  void run_cloud() { run_tiles(), run_tree(); }

  /// What a look counts; the number of points stays.
  void clear_look() {
    static_assert(offsetof(ReportHead, counts) == 0 && offsetof(kernels::FrameCounts, finite) == 0);
    constexpr std::size_t kept = sizeof(kernels::FrameCounts::finite);
    check(cudaMemsetAsync(report.get() + kept, 0, sizeof(ReportHead) - kept, stream), "clearing counts");
  }
  const kernels::FrameQuery* of_round(std::size_t round) const { return query.get() + round; }
  void run_first_look(bool draw, std::size_t round) {
    using namespace lane_cuda;
    constexpr unsigned packs = kLookThreads / kPack;
    const unsigned blocks = (rounds[round] + packs - 1) / packs;
    if (draw) {
      look_kernel<true><<<blocks, kLookThreads, 0, stream>>>(view, of_round(round), head());
    } else {
      look_kernel<false><<<blocks, kLookThreads, 0, stream>>>(view, of_round(round), head());
    }
    launched();
  }
  void run_sum(std::size_t round) {
    lane_cuda::sum_kernel<<<sum_blocks, lane_cuda::kSumThreads, 0, stream>>>(view, of_round(round));
    launched();
  }
  unsigned fit_blocks(std::size_t round) const {
    return (rounds[round] + lane_cuda::kFitThreads - 1) / lane_cuda::kFitThreads;
  }
  void run_quadric(std::size_t round) {
    lane_cuda::quadric_kernel<<<fit_blocks(round), lane_cuda::kFitThreads, 0, stream>>>(view, of_round(round), head());
    launched();
  }
  void run_circle(std::size_t round) {
    lane_cuda::circle_kernel<<<fit_blocks(round), lane_cuda::kFitThreads, 0, stream>>>(view, of_round(round));
    launched();
  }
  void run_shell(std::size_t round) {
    lane_cuda::shell_kernel<<<shell_blocks, lane_cuda::kShellThreads, 0, stream>>>(view, of_round(round), head());
    launched();
  }
  void run_round(bool draw, std::size_t round) {
    run_first_look(draw, round);
    run_sum(round), run_quadric(round), run_circle(round), run_shell(round);
  }
  /// A round after the first: about what the one before has found.
  void run_proposals(std::size_t round) {
    lane_cuda::order_kernel<<<align_blocks, lane_cuda::kAlignThreads, 0, stream>>>(view, head());
    launched();
    lane_cuda::round_kernel<<<1, 1, 0, stream>>>(view.counts);
    launched();
    lane_cuda::propose_kernel<<<rounds[round], lane_cuda::kProposeThreads, 0, stream>>>(view, of_round(round));
    launched();
  }
  void run_align() {
    lane_cuda::copy_kernel<<<align_blocks, lane_cuda::kAlignThreads, 0, stream>>>(view, head());
    launched();
    lane_cuda::align_kernel<<<align_blocks, lane_cuda::kAlignThreads, 0, stream>>>(view, of_round(0), head());
    launched();
  }
  std::uint32_t samples() const { return std::accumulate(rounds.begin(), rounds.end(), 0u); }
  /// Most often an eighth of the samples have a shell at most, and then there is no second copy.
  std::size_t report_bytes() const {
    const std::size_t shells = std::min<std::size_t>(view.capacity, std::max<std::size_t>(256, samples() / 8));
    return shells_at() + shells * sizeof(kernels::FoundShell);
  }
  std::size_t shells_at() const { return sizeof(ReportHead) + (view.capacity + 63) / 64 * 64; }
  void run_report() {
    check(cudaMemcpyAsync(returned.get(), report.get(), report_bytes(), cudaMemcpyDeviceToHost, stream),
          "the download");
  }
  void run_look(bool draw) {
    check(cudaMemcpyAsync(query.get(), sent.get(), rounds.size() * sizeof(kernels::FrameQuery), cudaMemcpyHostToDevice,
                          stream),
          "sending the query");
    if (!draw) {
      check(cudaMemcpyAsync(view.position, places.get(), 3 * sizeof(float) * static_cast<std::size_t>(rounds[0]),
                            cudaMemcpyHostToDevice, stream),
            "sending samples");
      clear_look();
    }
    run_round(draw, 0);
    for (std::size_t round = 1; round < rounds.size(); ++round) run_proposals(round), run_round(false, round);
    if (draw) run_align();
    run_report();
  }

  // ---- Memory -----------------------------------------------------------------------------------------------------

  /// For a cloud of this shape.
  void make_room(const CloudView& cloud, bool organized) {
    bool moved = points != cloud.size() || width != cloud.width || organized != (view.order != nullptr);
    points = cloud.size(), width = cloud.width;
    const std::uint32_t across = (cloud.width + 15) / 16, down = (cloud.height + 15) / 16;
    view.width = cloud.width, view.height = cloud.height;
    view.blocks = organized ? across * down : static_cast<std::uint32_t>((points + 255) / 256);
    view.regions = (view.blocks + 4095) / 4096 * 16;
    moved |= tile_points.require(std::size_t{768} * view.blocks);
    moved |= boxes.require(std::size_t{96} * view.blocks), moved |= sums.require(std::size_t{160} * view.blocks);
    moved |= full.require(view.blocks), moved |= before.require(std::size_t{16} * view.blocks);
    moved |= block_points.require(view.blocks), moved |= first_rank.require(view.blocks + std::size_t{1});
    moved |= block_boxes.require(std::size_t{96} * 16 * view.regions);
    moved |= group_boxes.require(std::size_t{96} * view.regions);
    moved |= region_boxes.require(std::size_t{6} * view.regions);
    moved |= source.require(4 * points);
    if (organized) {
      if (order_across != across || order_down != down) {
        std::vector<std::uint32_t> blocks(view.blocks);
        order_blocks(across, down, blocks.data());
        order.require(view.blocks);
        check(cudaMemcpy(order.get(), blocks.data(), sizeof(std::uint32_t) * blocks.size(), cudaMemcpyHostToDevice),
              "the order of blocks");
        order_across = across, order_down = down;
        moved = true;
      }
    } else {
      moved |= keys.require(points), moved |= other_keys.require(points);
      moved |= numbers.require(points), moved |= sorted.require(points);
      if (moved) {
        std::size_t narrow = 0, wide = 0;
        const auto n = static_cast<int>(points);
        check(cub::DeviceRadixSort::SortPairs(nullptr, narrow, static_cast<std::uint32_t*>(nullptr),
                                              static_cast<std::uint32_t*>(nullptr), numbers.get(), sorted.get(), n),
              "sorting");
        check(cub::DeviceRadixSort::SortPairs(nullptr, wide, keys.get(), other_keys.get(), numbers.get(), sorted.get(),
                                              n),
              "sorting");
        sort_memory.require(std::max(narrow, wide));
      }
    }
    view.order = organized ? order.get() : nullptr;
    view.sorted = sorted.get();
    view.source = source.get();
    view.points = tile_points.get(), view.boxes = boxes.get(), view.sums = sums.get(), view.full = full.get();
    view.block_boxes = block_boxes.get(), view.group_boxes = group_boxes.get(), view.region_boxes = region_boxes.get();
    view.before = before.get(), view.block_points = block_points.get(), view.first_rank = first_rank.get();
    if (moved) forget_graphs();
  }

  void make_room(std::uint32_t samples) {
    if (samples <= view.capacity) return;
    const std::size_t n = samples;
    view.capacity = samples;
    centres.require(3 * n);
    view.centres = centres.get();
    position.require(3 * n), summed.require(n), listed.require(17 * n), plane.require(3 * n),
        total.require(kernels::kMoments * n);
    quadric.require(10 * n), candidates.require(n), places.require(3 * n);
    shells.require(8 * ((n + 15) / 16 * 16));
    view.shells = shells.get();
    report.require(shells_at() + n * sizeof(kernels::FoundShell)), returned.require(report.size());
    view.position = position.get(), view.summed = summed.get(), view.listed = listed.get(), view.plane = plane.get(),
    view.total = total.get();
    view.quadric = quadric.get(), view.candidates = candidates.get();
    view.counts = &head()->counts;
    view.end = report.get() + sizeof(ReportHead);
    view.found = reinterpret_cast<kernels::FoundShell*>(report.get() + shells_at());
    forget_graphs();
  }

  void begin(const kernels::FrameQuery* queries, std::uint32_t n) {
    // After `take` nothing is under way but the upload, which touches none of this.
    if (!cloud_waits) finish();
    rounds.clear();
    for (std::uint32_t i = 0; i < n; ++i) rounds.push_back(queries[i].samples);
    cloud_waits |= samples() > view.capacity;  // what is counted of it moves
    make_room(samples());
    if (query.require(n) | sent.require(n)) forget_graphs();
    std::copy_n(queries, n, sent.get());
  }

  /// Nothing of the last frame may still be read or written.
  void finish() { check(cudaStreamSynchronize(stream), "the device's work"); }

  cudaStream_t stream = nullptr;
  cudaEvent_t event[2] = {};
  unsigned sum_blocks = 0, shell_blocks = 0, align_blocks = 0;
  kernels::FrameView view{};
  std::size_t points = 0, upload_bytes = 0;
  const void* upload_from = nullptr;
  std::uint32_t width = 0, order_across = 0, order_down = 0;
  kernels::MortonCells cells{};
  bool cloud_waits = false;  ///< it was sent, and its tiles are still to be made
  unsigned last_parts = 0;
  std::vector<std::uint32_t> rounds;  ///< samples of each

  Memory<float> source, tile_points, boxes, sums, block_boxes, group_boxes, region_boxes, position, plane, shells;
  Memory<std::uint16_t> full, before;
  Memory<std::uint32_t> order, block_points, first_rank, numbers, sorted, summed, listed, scratch;
  Memory<std::uint64_t> keys, other_keys;
  Memory<char> sort_memory;
  Memory<double> total, quadric, centres;
  Memory<kernels::FrameCandidate> candidates;
  Memory<kernels::FrameQuery> query;
  Memory<std::uint8_t> report;  ///< ReportHead | ends | shells
  Pinned<std::uint8_t> returned;
  Pinned<float> packed, places;
  Pinned<kernels::FrameQuery> sent;
  std::vector<Graph> graphs;
};

CudaFrame::CudaFrame() : impl_(std::make_unique<Impl>()) {}
CudaFrame::~CudaFrame() = default;

void CudaFrame::take(const CloudView& cloud, const RobustBounds& bounds) {
  const OnDevice on;
  Impl& m = *impl_;
  m.finish();
  m.make_room(1);  // the counts are part of it
  m.make_room(cloud, is_image(cloud));
  const kernels::MortonCells cells = bounds.cells();
  if (!m.view.order && std::memcmp(&cells, &m.cells, sizeof cells) != 0) {
    // They are an argument of a kernel in the graph.
    m.forget_graphs();
    m.cells = cells;
  }
  // Memory of the caller that is pinned is read where it is.
  cudaPointerAttributes attributes{};
  const bool pinned = cudaPointerGetAttributes(&attributes, cloud.data) == cudaSuccess &&
                      attributes.type == cudaMemoryTypeHost && cloud.point_step <= 16;
  cudaGetLastError();
  const auto step = static_cast<std::uint32_t>(pinned ? cloud.point_step / sizeof(float) : 3);
  if (step != m.view.source_step) m.forget_graphs();
  m.view.source_step = step;
  if (pinned) {
    m.upload_from = cloud.data;
    m.upload_bytes = (cloud.size() - 1) * cloud.point_step + 3 * sizeof(float);
  } else {
    m.packed.require(3 * cloud.size());
    pack_points(cloud, m.packed.get());
    m.upload_from = m.packed.get();
    m.upload_bytes = 3 * sizeof(float) * cloud.size();
  }
  check(cudaMemcpyAsync(m.source.get(), m.upload_from, m.upload_bytes, cudaMemcpyHostToDevice, m.stream), "the upload");
  m.cloud_waits = true;
}

void CudaFrame::draw(const kernels::FrameQuery* rounds, std::uint32_t n) {
  const OnDevice on;
  Impl& m = *impl_;
  m.begin(rounds, n);
  m.last_parts = Impl::kCloud | Impl::kDraw;
  m.launch(m.last_parts);
  m.cloud_waits = false;
}

void CudaFrame::look(const kernels::FrameQuery& q, const float* xyz) {
  const OnDevice on;
  Impl& m = *impl_;
  m.begin(&q, 1);
  if (m.cloud_waits) m.launch(Impl::kCloud);
  m.cloud_waits = false;
  std::memcpy(m.places.get(), xyz, 3 * sizeof(float) * static_cast<std::size_t>(q.samples));
  m.last_parts = Impl::kLook;
  m.launch(m.last_parts);
}

DeviceFrame::Found CudaFrame::wait() {
  const OnDevice on;
  Impl& m = *impl_;
  m.finish();
  const auto* head = reinterpret_cast<const ReportHead*>(m.returned.get());
  while (head->counts.lost > 0) {
    // Denser than any cloud before: once more, with room for the largest shell.
    m.view.scratch_words = (head->counts.wanted + 4095) / 4096 * 4096;
    m.scratch.require(static_cast<std::size_t>(m.view.scratch_words) * m.shell_blocks);
    m.view.scratch = m.scratch.get();
    m.forget_graphs();
    m.launch(m.last_parts);
    m.finish();
  }
  const std::size_t had = m.report_bytes();
  const std::size_t needed = m.shells_at() + head->counts.found * sizeof(kernels::FoundShell);
  if (needed > had) {
    check(cudaMemcpy(m.returned.get() + had, m.report.get() + had, needed - had, cudaMemcpyDeviceToHost),
          "the download");
  }
  Found found;
  found.finite = head->counts.finite;
  found.end = m.returned.get() + sizeof(ReportHead);
  found.shell = reinterpret_cast<const kernels::FoundShell*>(m.returned.get() + m.shells_at());
  found.shells = head->counts.found;
  return found;
}

void CudaFrame::positions(float* xyz) {
  const OnDevice on;
  const std::size_t bytes = 3 * sizeof(float) * static_cast<std::size_t>(impl_->samples());
  check(cudaMemcpy(xyz, impl_->view.position, bytes, cudaMemcpyDeviceToHost), "the samples' places");
}

void CudaFrame::add_times(StageTimes& times) const {
  const auto* head = reinterpret_cast<const ReportHead*>(impl_->returned.get());
  const auto ms = [&](lane_cuda::Part part) {
    unsigned long long ns = head->spent[part];
    if (part == head->part && head->ended > head->began) ns += head->ended - head->began;
    return 1e-6 * static_cast<double>(ns);
  };
  using namespace lane_cuda;
  times.index += ms(kIndex), times.samples += ms(kSamples), times.moments += ms(kMoments), times.fit += ms(kFit);
  times.shell += ms(kShell), times.handles += ms(kAlign);
}

// ---- For benchmarks -------------------------------------------------------------------------------------------------

namespace {

/// The stream waits, so that what is timed has been sent before it begins: then its time is the device's alone, not
/// that between two calls of the host.
void hold(cudaStream_t stream) {
  const auto wait = [](void*) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(100);
    while (std::chrono::steady_clock::now() < end) {
    }
  };
  check(cudaLaunchHostFunc(stream, wait, nullptr), "a pause");
}

}  // namespace

const char* CudaFrame::name(Stage stage) {
  static constexpr const char* kNames[kStages] = {"upload",  "tiles",  "tree",  "look",  "sums",
                                                  "quadric", "circle", "shell", "align", "download"};
  return kNames[static_cast<int>(stage)];
}

float CudaFrame::time(Stage stage) {
  const OnDevice on;
  Impl& m = *impl_;
  m.finish();
  // The counts that the stage starts from, as the last frame left them.
  kernels::FrameCounts counts;
  check(cudaMemcpy(&counts, m.view.counts, sizeof counts, cudaMemcpyDeviceToHost), "the counts");
  if (stage == Stage::kLook) counts.summed = 0;
  if (stage == Stage::kSum) counts.next_sum = 0;
  if (stage == Stage::kCircle) counts.candidates = 0;
  if (stage == Stage::kShell) counts.next_shell = counts.found = 0;
  check(cudaMemcpy(m.view.counts, &counts, sizeof counts, cudaMemcpyHostToDevice), "the counts");
  if (stage == Stage::kCircle) m.run_quadric(0);  // it says which fits go on
  hold(m.stream);
  check(cudaEventRecord(m.event[0], m.stream), "an event");
  switch (stage) {
    case Stage::kUpload:
      check(cudaMemcpyAsync(m.source.get(), m.upload_from, m.upload_bytes, cudaMemcpyHostToDevice, m.stream),
            "the upload");
      break;
    case Stage::kTiles:
      m.run_tiles();
      break;
    case Stage::kTree:
      m.run_tree();
      break;
    case Stage::kLook:
      m.run_first_look(m.last_parts & Impl::kDraw, 0);
      break;
    case Stage::kSum:
      m.run_sum(0);
      break;
    case Stage::kQuadric:
      m.run_quadric(0);
      break;
    case Stage::kCircle:
      m.run_circle(0);
      break;
    case Stage::kShell:
      m.run_shell(0);
      break;
    case Stage::kAlign:
      m.run_align();
      break;
    case Stage::kReport:
      m.run_report();
      break;
  }
  check(cudaEventRecord(m.event[1], m.stream), "an event");
  m.finish();
  if (stage == Stage::kTiles) {
    // It cleared the counts.
    m.run_tree();
    m.finish();
    kernels::FrameCounts now;
    check(cudaMemcpy(&now, m.view.counts, sizeof now, cudaMemcpyDeviceToHost), "the counts");
    counts.finite = now.finite;
    check(cudaMemcpy(m.view.counts, &counts, sizeof counts, cudaMemcpyHostToDevice), "the counts");
  }
  float ms = 0;
  check(cudaEventElapsedTime(&ms, m.event[0], m.event[1]), "the time");
  return ms;
}

float CudaFrame::time_frame(bool upload) {
  const OnDevice on;
  Impl& m = *impl_;
  m.finish();
  hold(m.stream);
  check(cudaEventRecord(m.event[0], m.stream), "an event");
  if (upload) {
    check(cudaMemcpyAsync(m.source.get(), m.upload_from, m.upload_bytes, cudaMemcpyHostToDevice, m.stream),
          "the upload");
  }
  m.launch(Impl::kCloud | Impl::kDraw);
  check(cudaEventRecord(m.event[1], m.stream), "an event");
  m.finish();
  float ms = 0;
  check(cudaEventElapsedTime(&ms, m.event[0], m.event[1]), "the time");
  return ms;
}

kernels::FrameCounts CudaFrame::counts() const {
  return reinterpret_cast<const ReportHead*>(impl_->returned.get())->counts;
}

}  // namespace handhold
