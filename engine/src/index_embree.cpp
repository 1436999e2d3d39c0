// Neighbour queries through an Embree BVH. Embree calls back for every primitive of a leaf that a query touches, and
// the call is what costs: so a primitive is a block of 256 points, and one query serves a whole group of
// neighbourhoods.
#include <embree3/rtcore.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "index.h"

namespace handhold {
namespace {

class EmbreeIndex final : public NeighbourIndex {
 public:
  // No "threads=": Embree would set the limit for the whole process. rtcCommitScene builds in the caller's TBB arena;
  // rtcJoinCommitScene would use the device's own.
  EmbreeIndex() : device_(rtcNewDevice(nullptr)) {
    if (!device_)
      throw std::runtime_error("Embree: no device (error " + std::to_string(rtcGetDeviceError(nullptr)) + ")");
  }
  ~EmbreeIndex() override {
    release();
    rtcReleaseDevice(device_);
  }
  EmbreeIndex(const EmbreeIndex&) = delete;
  EmbreeIndex& operator=(const EmbreeIndex&) = delete;

  void build(const TileStore& tiles) override {
    tiles_ = &tiles;
    blocks_.clear();
    for (std::uint32_t b = 0; b < tiles.blocks(); ++b) {
      if (!tiles.block_empty(b)) blocks_.push_back(b);
    }
    // Embree keeps its tree and memory while the number of primitives stays: a scene for each number would be rebuilt
    // from nothing, so only a changed number makes a new one.
    if (!scene_ || built_ != blocks_.size()) {
      release();
      scene_ = rtcNewScene(device_);
      rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
      geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
      rtcSetGeometryUserPrimitiveCount(geometry_, static_cast<unsigned>(blocks_.size()));
      rtcSetGeometryBoundsFunction(geometry_, bounds, nullptr);
      rtcSetGeometryBuildQuality(geometry_, RTC_BUILD_QUALITY_LOW);
      rtcSetGeometryUserData(geometry_, this);
      rtcAttachGeometry(scene_, geometry_);
      built_ = blocks_.size();
    }
    rtcCommitGeometry(geometry_);
    rtcCommitScene(scene_);
    const RTCError error = rtcGetDeviceError(device_);
    if (error != RTC_ERROR_NONE)
      throw std::runtime_error("Embree: building the index failed (error " + std::to_string(error) + ")");
  }

  void query(const float* centre, float radius, BlockSet& found) const override {
    if (blocks_.empty()) return;
    alignas(16) RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    alignas(16) RTCPointQuery query{};
    query.x = centre[0], query.y = centre[1], query.z = centre[2];
    query.radius = radius;
    Visit visit{&blocks_, &found};
    rtcPointQuery(scene_, &query, &context, collect, &visit);
  }

 private:
  struct Visit {
    const std::vector<std::uint32_t>* blocks;
    BlockSet* found;
  };

  static void bounds(const RTCBoundsFunctionArguments* a) {
    const auto* self = static_cast<const EmbreeIndex*>(a->geometryUserPtr);
    const float* box = self->tiles_->block_box(self->blocks_[a->primID]);
    RTCBounds& b = *a->bounds_o;
    // A little wider: Embree's build aborts when all boxes are one and the same point. Lists are culled exactly later.
    const auto slack = [](float x) { return 1e-6f + 1e-6f * std::fabs(x); };
    b.lower_x = box[0] - slack(box[0]), b.lower_y = box[1] - slack(box[1]), b.lower_z = box[2] - slack(box[2]);
    b.upper_x = box[4] + slack(box[4]), b.upper_y = box[5] + slack(box[5]), b.upper_z = box[6] + slack(box[6]);
  }
  static bool collect(RTCPointQueryFunctionArguments* a) {
    auto* visit = static_cast<Visit*>(a->userPtr);
    visit->found->insert((*visit->blocks)[a->primID]);
    return false;  // the radius stays
  }
  void release() {
    if (geometry_) rtcReleaseGeometry(geometry_);
    if (scene_) rtcReleaseScene(scene_);
    geometry_ = nullptr, scene_ = nullptr;
  }

  RTCDevice device_;
  RTCScene scene_ = nullptr;
  RTCGeometry geometry_ = nullptr;
  const TileStore* tiles_ = nullptr;
  std::vector<std::uint32_t> blocks_;
  std::size_t built_ = 0;
};

}  // namespace

std::unique_ptr<NeighbourIndex> make_embree_index() {
  return std::make_unique<EmbreeIndex>();
}

}  // namespace handhold
