#include "ray_caster.h"

#include <embree3/rtcore.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "vec.h"

namespace handhold::sensor {
namespace {

void validate(const Object& object) {
  for (const Vector3& v : object.mesh.vertices) {
    if (!std::isfinite(v[0] + v[1] + v[2])) {
      throw std::invalid_argument("scene: object '" + object.name +
                                  "' has a vertex that is not finite; coordinates must be metres");
    }
  }
  for (const auto& t : object.mesh.triangles) {
    for (std::uint32_t index : t) {
      if (index >= object.mesh.vertices.size()) {
        throw std::invalid_argument("scene: object '" + object.name + "' has vertex index " + std::to_string(index) +
                                    " in a triangle; it has " + std::to_string(object.mesh.vertices.size()) +
                                    " vertices");
      }
    }
  }
}

RTCRay make_ray(const Vector3& origin, const Vector3& direction, float to) {
  RTCRay ray = {};
  ray.org_x = static_cast<float>(origin[0]);
  ray.org_y = static_cast<float>(origin[1]);
  ray.org_z = static_cast<float>(origin[2]);
  ray.dir_x = static_cast<float>(direction[0]);
  ray.dir_y = static_cast<float>(direction[1]);
  ray.dir_z = static_cast<float>(direction[2]);
  ray.tnear = 0;
  ray.tfar = to;
  ray.mask = ~0u;
  return ray;
}

/// What Embree's filter is called with: the context comes first, so that the pointer to it is one to this.
struct CollectingContext {
  RTCIntersectContext context;
  std::vector<Crossing>* crossings;
};

/// Notes a hit and refuses it, so that the ray goes on.
void collect(const RTCFilterFunctionNArguments* arguments) {
  arguments->valid[0] = 0;
  const auto& hit = *reinterpret_cast<const RTCHit*>(arguments->hit);
  const auto& ray = *reinterpret_cast<const RTCRay*>(arguments->ray);
  const float along = hit.Ng_x * ray.dir_x + hit.Ng_y * ray.dir_y + hit.Ng_z * ray.dir_z;
  reinterpret_cast<const CollectingContext*>(arguments->context)
      ->crossings->push_back({ray.tfar, along < 0, static_cast<std::int32_t>(hit.geomID)});
}

using Visit = std::function<void(std::int32_t, std::uint32_t)>;

bool visit_triangle(RTCPointQueryFunctionArguments* arguments) {
  const auto& visit = *static_cast<const Visit*>(arguments->userPtr);
  visit(static_cast<std::int32_t>(arguments->geomID), arguments->primID);
  return false;  // the radius stays
}

}  // namespace

struct RayCaster::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  ~Impl() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

RayCaster::RayCaster(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  for (const Object& object : scene.objects) validate(object);
  impl_->device = rtcNewDevice(nullptr);
  if (!impl_->device) throw std::runtime_error("sensor: Embree gives no device; is the library for this machine?");
  impl_->scene = rtcNewScene(impl_->device);
  // Robust: a ray through a shared edge must not slip between its two triangles.
  // Context filter: crossings() goes on behind each hit.
  rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Mesh& mesh = scene.objects[i].mesh;
    if (mesh.triangles.empty()) continue;
    RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
    if (!vertices || !indices) {
      rtcReleaseGeometry(geometry);
      throw std::runtime_error("sensor: Embree has no memory for object '" + scene.objects[i].name + "'");
    }
    for (const Vector3& v : mesh.vertices) {
      for (double value : v) *vertices++ = static_cast<float>(value);
    }
    for (const auto& t : mesh.triangles) {
      for (std::uint32_t value : t) *indices++ = value;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(impl_->scene, geometry, static_cast<unsigned>(i));
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(impl_->scene);
  if (rtcGetDeviceError(impl_->device) != RTC_ERROR_NONE) {
    throw std::runtime_error("sensor: Embree could not build the scene");
  }
}

RayCaster::~RayCaster() = default;

std::optional<RayHit> RayCaster::cast(const Vector3& origin, const Vector3& direction) const {
  RTCRayHit query = {};
  query.ray = make_ray(origin, direction, std::numeric_limits<float>::infinity());
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const Vector3 normal = {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z};
  const double cosine = -dot(normal, direction) / (norm(normal) * norm(direction));
  return RayHit{query.ray.tfar, cosine, unit(normal), static_cast<std::int32_t>(query.hit.geomID)};
}

bool RayCaster::blocked(const Vector3& from, const Vector3& to) const {
  RTCRay ray = make_ray(from, to - from, 1);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->scene, &context, &ray);
  return ray.tfar < 0;  // Embree's mark for a hit
}

std::vector<Crossing> RayCaster::crossings(const Vector3& origin, const Vector3& direction) const {
  std::vector<Crossing> result;
  RTCRayHit query = {};
  query.ray = make_ray(origin, direction, std::numeric_limits<float>::infinity());
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  CollectingContext context;
  rtcInitIntersectContext(&context.context);
  context.context.filter = collect;
  context.crossings = &result;
  rtcIntersect1(impl_->scene, &context.context, &query);
  return result;
}

void RayCaster::near(const Vector3& p, double distance, const Visit& visit) const {
  RTCPointQuery query = {};
  query.x = static_cast<float>(p[0]);
  query.y = static_cast<float>(p[1]);
  query.z = static_cast<float>(p[2]);
  query.radius = static_cast<float>(1.0001 * distance + 1e-5);  // more than single precision loses
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(impl_->scene, &query, &context, visit_triangle, const_cast<Visit*>(&visit));
}

}  // namespace handhold::sensor
