#include "equaltime/accel/accel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <new>
#include <numbers>
#include <stdexcept>

#include "equaltime/accel/embree_values.h"
#include "equaltime/accel/enclosing_spheres.h"
#include "equaltime/accel/instruction_set.h"
#include "equaltime/accel/moving_instance.h"
#include "equaltime/accel/packet_lanes.h"
#include "equaltime/accel/ray_packet.h"
#include "equaltime/accel/slivers.h"

namespace equaltime {

namespace {

/// Above this many triangles a BVH with spatial splits costs more seconds to build than it is likely to save.
constexpr std::size_t kHighQualityTriangles = 1'000'000;
/// The place of spheres among the geometries that are no meshes.
constexpr std::size_t kSpheres = AnalyticShapes::place_of<Sphere<float>>;
/// A hit by Embree's own numbers, all of which are invalid if nothing was hit.
struct EmbreeHit {
  std::uint32_t instance;
  PrimitiveId id;
};
constexpr EmbreeHit kNothing{RTC_INVALID_GEOMETRY_ID, {RTC_INVALID_GEOMETRY_ID, RTC_INVALID_GEOMETRY_ID}};

struct DeviceDelete {
  void operator()(RTCDevice d) const noexcept { rtcReleaseDevice(d); }
};
struct SceneDelete {
  void operator()(RTCScene s) const noexcept { rtcReleaseScene(s); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceDelete>;
using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneDelete>;

Device new_device() {
  Device device(rtcNewDevice(embree_config().c_str()));
  if (!device) throw std::runtime_error("Embree cannot create a device");
  return device;
}

void check(RTCDevice device, const char* during) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error != RTC_ERROR_NONE)
    throw std::runtime_error(std::string("Embree failed while ") + during + ", error " + std::to_string(error));
}

RayD to_ray(const RTCRay& r) noexcept {
  return RayD(Ray{{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}, r.tfar});
}

template <class Primitive>
void bounds_callback(const RTCBoundsFunctionArguments* args) {
  const auto& primitives = *static_cast<const std::vector<Primitive>*>(args->geometryUserPtr);
  *args->bounds_o = rounded(box_of(primitives[args->primID]));
}

template <class Primitive>
void intersect_callback(const RTCIntersectFunctionNArguments* args) {
  const auto& primitives = *static_cast<const std::vector<Primitive>*>(args->geometryUserPtr);
  for_each_valid_lane(args->valid, args->N, [&](unsigned count, unsigned lane) noexcept {
    const RayD ray(ray_of(RTCRayHitN_RayN(args->rayhit, count), count, lane));
    const auto t = intersect(primitives[args->primID], ray);
    args->valid[lane] = t ? -1 : 0;  // which Embree 4 asks for
    if (t)
      put_hit(args->rayhit, count, lane, static_cast<float>(*t), args->context->instID[0], args->geomID, args->primID);
  });
}

template <class Primitive>
void occluded_callback(const RTCOccludedFunctionNArguments* args) {
  const auto& primitives = *static_cast<const std::vector<Primitive>*>(args->geometryUserPtr);
  for_each_valid_lane(args->valid, args->N, [&](unsigned count, unsigned lane) noexcept {
    const bool met = intersect(primitives[args->primID], RayD(ray_of(args->ray, count, lane))).has_value();
    args->valid[lane] = met ? -1 : 0;
    if (met) RTCRayN_tfar(args->ray, count, lane) = -kInfinity;
  });
}

}  // namespace

constinit thread_local bool Accel::refused_ = false;

void refuse_ray() noexcept { Accel::refused_ = true; }

struct Accel::Impl {
  Geometries geometries;
  std::vector<Geometries> groups;
  std::atomic<std::int64_t> memory{0};
  std::deque<Slivers> slivers;  // of the meshes that have any
  Device device;
  std::vector<EmbreeScene> group_scenes;
  std::vector<MovingInstance> moving;
  EmbreeScene scene;                         // everything but enclosing spheres and, if they are few, moving instances
  EnclosingSpheres enclosing;                // beside Embree's tree
  std::vector<Sphere<float>> other_spheres;  // those in the tree, if some are enclosing; else empty
  Reach reach;                               // of the origins of rays, by the instances

  /// `is_top`: the scene itself, not a group; it has the instances.
  EmbreeScene build(Geometries& all, std::vector<Sphere<float>>& spheres, Intersection mode,
                    const std::vector<InstanceGeometry>& instances, bool is_top);
  template <bool kMoves>
  [[nodiscard]] EmbreeHit trace(Vec3f o, Vec3f d, float t_max, float time) const noexcept;
  template <bool kMoves>
  [[nodiscard]] bool blocked(Vec3f o, Vec3f d, float t_max, float time) const noexcept;
  /// Returns the nearer of two hits: the one that a query of Embree's tree found, and the nearest one with enclosing
  /// spheres and moving instances, which may stand beside the tree.
  template <bool kMoves>
  [[nodiscard]] EmbreeHit nearest_of(RTCRayHit& query) const noexcept;
  /// Whether a moving instance beside the tree is in the way.
  template <bool kMoves>
  [[nodiscard]] bool blocked_beside(const RTCRay& query) const noexcept;
  /// This is no part of `blocked`, so that scenes without enclosing spheres need no registers for them.
  [[nodiscard, gnu::noinline]] bool blocked_by_enclosing(const Ray& ray) const noexcept {
    return enclosing.any(RayD(ray));
  }
  /// Returns the hit by this class's numbers of instances; none if nothing was hit.
  [[nodiscard]] Optional<Hit> numbered(EmbreeHit hit) const noexcept;
  /// How many geometries of the scene are no instances.
  [[nodiscard]] std::size_t before_instances() const noexcept {
    return geometries.meshes.size() + AnalyticShapes::size;
  }

 private:
  void attach(RTCScene to, RTCGeometry geometry) const;
  void add_mesh(RTCScene to, TriangleMesh& mesh, RTCBuildQuality quality);
  template <class Primitive>
  void add_primitives(RTCScene to, std::vector<Primitive>& primitives) const;
  void add_instance(RTCScene to, const InstanceGeometry& instance) const;
};

void Accel::Impl::attach(RTCScene to, RTCGeometry geometry) const {
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(to, geometry);
  rtcReleaseGeometry(geometry);
}

void Accel::Impl::add_mesh(RTCScene to, TriangleMesh& mesh, RTCBuildQuality quality) {
  const RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  const std::size_t count = mesh.vertices.size();
  mesh.vertices.emplace_back();  // Embree reads 16 bytes at every vertex of 12: the last needs some to spare
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.vertices.data(), 0,
                             sizeof(Vec3f), count);
  if (!mesh.later.empty()) rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(mesh.later.size() + 1));
  for (unsigned i = 0; i < mesh.later.size(); ++i) {
    mesh.later[i].emplace_back();
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, i + 1, RTC_FORMAT_FLOAT3, mesh.later[i].data(), 0,
                               sizeof(Vec3f), count);
  }
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                             sizeof(Triangle), mesh.triangles.size());
  if (Slivers found = slivers_of(mesh); !found.thin.empty())
    drop_false_hits(geometry, slivers.emplace_back(std::move(found)));
  rtcSetGeometryBuildQuality(geometry, quality);
  attach(to, geometry);
}

template <class Primitive>
void Accel::Impl::add_primitives(RTCScene to, std::vector<Primitive>& primitives) const {
  const RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(primitives.size()));
  rtcSetGeometryUserData(geometry, &primitives);
  rtcSetGeometryBoundsFunction(geometry, bounds_callback<Primitive>, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_callback<Primitive>);
  rtcSetGeometryOccludedFunction(geometry, occluded_callback<Primitive>);
  attach(to, geometry);
}

void Accel::Impl::add_instance(RTCScene to, const InstanceGeometry& instance) const {
  const RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, group_scenes[instance.group].get());
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, instance.to_world.data());
  attach(to, geometry);
}

EmbreeScene Accel::Impl::build(Geometries& all, std::vector<Sphere<float>>& spheres, Intersection mode,
                               const std::vector<InstanceGeometry>& instances, bool is_top) {
  EmbreeScene made(rtcNewScene(device.get()));
  rtcSetSceneFlags(made.get(), mode == Intersection::robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  std::size_t triangles = 0;
  for (const TriangleMesh& mesh : all.meshes) triangles += mesh.triangles.size();
  const auto quality = triangles <= kHighQualityTriangles ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
  rtcSetSceneBuildQuality(made.get(), quality);
  for (TriangleMesh& mesh : all.meshes) add_mesh(made.get(), mesh, quality);
  AnalyticShapes::for_each([&]<class Shape>(std::type_identity<Shape>) {
    if constexpr (std::is_same_v<Shape, Sphere<float>>)
      add_primitives(made.get(), spheres);
    else
      add_primitives(made.get(), all.of<Shape>());
  });
  for (const InstanceGeometry& instance : instances) add_instance(made.get(), instance);
  if (is_top && moving.size() > kFewMoving)
    for (MovingInstance& instance : moving) attach(made.get(), instance.new_geometry(device.get()));
  rtcCommitScene(made.get());
  check(device.get(), "building the scene");
  return made;
}

Accel::Accel(Geometries geometries, Intersection mode, std::vector<Geometries> groups,
             const std::vector<InstanceGeometry>& instances, const std::vector<MovingInstanceGeometry>& moving)
    : impl_(std::make_unique<Impl>()) {
  impl_->geometries = std::move(geometries);
  impl_->groups = std::move(groups);
  impl_->device = new_device();
  rtcSetDeviceMemoryMonitorFunction(
      impl_->device.get(),
      [](void* total, ssize_t bytes, bool) {
        *static_cast<std::atomic<std::int64_t>*>(total) += bytes;
        return true;
      },
      &impl_->memory);
  for (Geometries& group : impl_->groups)
    impl_->group_scenes.push_back(impl_->build(group, group.of<Sphere<float>>(), mode, {}, false));
  const std::size_t unmoving = impl_->before_instances() + instances.size();
  for (const auto& [group, to_world] : moving)
    impl_->moving.emplace_back(impl_->group_scenes[group].get(), to_world,
                               static_cast<std::uint32_t>(unmoving + impl_->moving.size()));
  for (const InstanceGeometry& instance : instances) impl_->reach.limit(static_cast<float>(reach(instance)));
  std::vector<Sphere<float>>& spheres = impl_->geometries.of<Sphere<float>>();
  impl_->enclosing = EnclosingSpheres(spheres, impl_->geometries.meshes);
  if (!impl_->enclosing.empty()) impl_->other_spheres = impl_->enclosing.taken_out_of(spheres);
  impl_->scene =
      impl_->build(impl_->geometries, impl_->enclosing.empty() ? spheres : impl_->other_spheres, mode, instances, true);
  has_instances_ = !instances.empty();
  const auto deforms = [](const Geometries& g) {
    return std::any_of(g.meshes.begin(), g.meshes.end(), [](const TriangleMesh& mesh) { return !mesh.later.empty(); });
  };
  moves_ =
      !moving.empty() || deforms(impl_->geometries) || std::any_of(impl_->groups.begin(), impl_->groups.end(), deforms);
}
Accel::~Accel() = default;
Accel::Accel(Accel&&) noexcept = default;
Accel& Accel::operator=(Accel&&) noexcept = default;

template <bool kMoves>
EQUALTIME_INLINE EmbreeHit Accel::Impl::nearest_of(RTCRayHit& query) const noexcept {
  if constexpr (kMoves)
    if (moving.size() <= kFewMoving) equaltime::intersect(moving, query);
  if (!enclosing.empty())
    if (const auto nearer = enclosing.nearest(to_ray(query.ray)))
      return {RTC_INVALID_GEOMETRY_ID, {static_cast<std::uint32_t>(geometries.meshes.size() + kSpheres), *nearer}};
  return {query.hit.instID[0], {query.hit.geomID, query.hit.primID}};
}

template <bool kMoves>
EQUALTIME_INLINE bool Accel::Impl::blocked_beside(const RTCRay& query) const noexcept {
  return kMoves && moving.size() <= kFewMoving && query.tfar >= 0 && equaltime::occluded(moving, query);
}

template <bool kMoves>
EQUALTIME_INLINE EmbreeHit Accel::Impl::trace(Vec3f o, Vec3f d, float t_max, float time) const noexcept {
  RTCRayHit query;
  if (!write_unit(query.ray, o, d, t_max, time, reach)) [[unlikely]] {
    refuse_ray();
    return kNothing;
  }
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  embree_intersect(scene.get(), query);
  return nearest_of<kMoves>(query);
}

template <bool kMoves>
EQUALTIME_INLINE bool Accel::Impl::blocked(Vec3f o, Vec3f d, float t_max, float time) const noexcept {
  if (!enclosing.empty() && blocked_by_enclosing({o, d, t_max})) return true;
  RTCRay query;
  if (!write_unit(query, o, d, t_max, time, reach)) [[unlikely]] {
    refuse_ray();
    return true;
  }
  embree_occluded(scene.get(), query);
  return query.tfar < 0 || blocked_beside<kMoves>(query);
}

EQUALTIME_INLINE Optional<Hit> Accel::Impl::numbered(EmbreeHit hit) const noexcept {
  if (hit.id.geometry == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  static_assert(kNotInstanced == RTC_INVALID_GEOMETRY_ID);
  if (hit.instance != kNotInstanced) hit.instance -= static_cast<std::uint32_t>(before_instances());
  return Hit{hit.instance, hit.id};
}

Optional<PrimitiveId> Accel::closest_fixed(float ox, float oy, float oz, float dx, float dy, float dz,
                                           float t_max) const noexcept {
  const PrimitiveId id = impl_->trace<false>({ox, oy, oz}, {dx, dy, dz}, t_max, 0).id;
  if (id.geometry == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return id;
}
Optional<Hit> Accel::closest_instanced(const Ray& ray) const noexcept {
  return impl_->numbered(impl_->trace<false>(ray.origin, ray.direction, ray.t_max, 0));
}
Optional<Hit> Accel::closest_moving(const Ray& ray, float time) const noexcept {
  return impl_->numbered(impl_->trace<true>(ray.origin, ray.direction, ray.t_max, time));
}

bool Accel::occluded_fixed(float ox, float oy, float oz, float dx, float dy, float dz, float t_max) const noexcept {
  return impl_->blocked<false>({ox, oy, oz}, {dx, dy, dz}, t_max, 0);
}
bool Accel::occluded_moving(const Ray& ray, float time) const noexcept {
  return impl_->blocked<true>(ray.origin, ray.direction, ray.t_max, time);
}

void Accel::closest(std::span<const Ray> rays, std::span<const float> times,
                    std::span<Optional<Hit>> hits) const noexcept {
  for (std::size_t first = 0; first < rays.size(); first += RayPacket::kLanes) {
    RayPacket packet(rays.subspan(first), times.subspan(first), impl_->reach);
    packet.intersect(impl_->scene.get());
    for (std::size_t i = 0; i < packet.size(); ++i) {
      hits[first + i] = std::nullopt;
      if (!packet.accepted(i)) continue;
      RTCRayHit query = packet.lane(i);
      hits[first + i] = impl_->numbered(impl_->nearest_of<true>(query));
    }
  }
}

void Accel::occluded(std::span<const Ray> rays, std::span<const float> times, std::span<bool> blocked) const noexcept {
  for (std::size_t first = 0; first < rays.size(); first += RayPacket::kLanes) {
    RayPacket packet(rays.subspan(first), times.subspan(first), impl_->reach);
    packet.occlude(impl_->scene.get());
    for (std::size_t i = 0; i < packet.size(); ++i) {
      const RTCRay query = packet.lane(i).ray;
      blocked[first + i] = !packet.accepted(i) || query.tfar < 0 || impl_->blocked_by_enclosing(rays[first + i]) ||
                           impl_->blocked_beside<true>(query);
    }
  }
}

double Accel::reach(const InstanceGeometry& instance) noexcept {
  const auto column = [&](std::size_t i) {
    const float* c = &instance.to_world[3 * i];
    return Vec3d(Vec3f(c[0], c[1], c[2]));
  };
  const Vec3d x = column(0), y = column(1), z = column(2), at = column(3);
  const double volume = dot(x, cross(y, z));
  if (!(std::abs(volume) > 0)) return 0;
  double stretch = 0;  // of a unit vector on its way to the group's space, at the most
  for (const Vec3d& row : {cross(y, z), cross(z, x), cross(x, y)}) stretch = std::max(stretch, length(row / volume));
  const double most =
      static_cast<double>(kEmbreeLargest) / std::numbers::sqrt3;  // of a vector's length, from its parts
  const double reach = most / stretch - max_component(abs(at));
  return stretch < most && reach > 0 ? std::min(reach, static_cast<double>(kEmbreeLargest)) : 0;
}

const Geometries& Accel::geometries() const noexcept { return impl_->geometries; }
const std::vector<Geometries>& Accel::groups() const noexcept { return impl_->groups; }
std::size_t Accel::memory_bytes() const noexcept {
  return static_cast<std::size_t>(std::max<std::int64_t>(0, impl_->memory.load())) +
         impl_->other_spheres.capacity() * sizeof(Sphere<float>);
}

std::string Accel::version() {
  const Device device = new_device();
  const auto version = rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_VERSION);
  return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

}  // namespace equaltime
