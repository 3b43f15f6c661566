#include "backends/embree/embree_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// No axis, no plane of symmetry of a mesh, and no edge that one would draw lies along these.
constexpr std::array<std::array<float, 3>, 9> directions = {{{0.8017F, 0.2673F, 0.5345F},
                                                             {-0.3713F, 0.9047F, 0.2087F},
                                                             {0.1291F, -0.5123F, 0.8491F},
                                                             {-0.6441F, -0.7129F, 0.2771F},
                                                             {0.2239F, 0.6091F, -0.7609F},
                                                             {-0.9103F, 0.1117F, -0.3989F},
                                                             {0.5851F, -0.7907F, -0.1801F},
                                                             {-0.1613F, -0.4517F, -0.8773F},
                                                             {0.9431F, -0.0907F, -0.3203F}}};

/// Of a coordinate of the surface and one of the point, and what Embree rounds as it compares them.
constexpr double rounding_units = 16;
constexpr double single_rounding = std::numeric_limits<float>::epsilon();

struct Search {
  const EmbreeScene& scene;
  Vec3 point;
  double squared_limit_m2;
  double rounding_m;
  EmbreeClosest best;

  [[nodiscard]] float radius() const {
    const double reach_m = std::sqrt(squared_limit_m2) + rounding_m;
    return std::nextafter(static_cast<float>(reach_m), std::numeric_limits<float>::infinity());
  }
  void look_at(int triangle) {
    const auto [a, b, c] = scene.corners(triangle);
    const ClosestOnTriangle found = closest_on_triangle(point, a, b, c);
    const double squared = found.squared_distance_m2;
    if (squared > squared_limit_m2 || (squared == squared_limit_m2 && best.triangle >= 0 && triangle > best.triangle)) {
      return;
    }
    squared_limit_m2 = squared;
    best = {found, triangle};
  }
};

bool look_at_triangle(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Search*>(arguments->userPtr);
  search.look_at(static_cast<int>(arguments->primID));
  // Embree goes on within the smaller sphere if it is told so.
  const float radius = search.radius();
  if (radius >= arguments->query->radius) return false;
  arguments->query->radius = radius;
  return true;
}

struct Listing {
  const EmbreeScene& scene;
  Vec3 point;
  double squared_radius_m2;
  ListedTriangles& list;
};

bool list_triangle(RTCPointQueryFunctionArguments* arguments) {
  auto& listing = *static_cast<Listing*>(arguments->userPtr);
  const auto triangle = static_cast<int>(arguments->primID);
  const auto [a, b, c] = listing.scene.corners(triangle);
  if (closest_on_triangle(listing.point, a, b, c).squared_distance_m2 <= listing.squared_radius_m2) {
    listing.list.add(triangle);
  }
  return false;
}

/// A ray that is told what it meets. Trees of high quality hold a triangle more than once, and tell it as often.
struct CountingRay {
  RTCIntersectContext context;  ///< first, so that Embree's pointer to it is one to this
  std::array<unsigned, 64> met;
  std::size_t count = 0;
  int windings = 0;
};

void count_crossing(const RTCFilterFunctionNArguments* arguments) {
  auto& ray = *reinterpret_cast<CountingRay*>(arguments->context);
  arguments->valid[0] = 0;  // go on
  const auto* hit = reinterpret_cast<const RTCHit*>(arguments->hit);
  const auto* along = reinterpret_cast<const RTCRay*>(arguments->ray);
  const auto last = ray.met.begin() + static_cast<std::ptrdiff_t>(std::min(ray.count, ray.met.size()));
  if (std::find(ray.met.begin(), last, hit->primID) != last) return;
  if (ray.count < ray.met.size()) ray.met[ray.count] = hit->primID;
  ++ray.count;
  ray.windings += along->dir_x * hit->Ng_x + along->dir_y * hit->Ng_y + along->dir_z * hit->Ng_z > 0 ? 1 : -1;
}

RTCRayHit ray_along(const std::array<float, 3>& from, const std::array<float, 3>& direction, float length) {
  RTCRayHit ray{};
  ray.ray = {from[0], from[1], from[2], 0, direction[0], direction[1], direction[2], 0, length, ~0U, 0, 0};
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return ray;
}

bool count_memory(void* counter, std::ptrdiff_t bytes, bool /*after*/) {
  *static_cast<std::atomic<std::ptrdiff_t>*>(counter) += bytes;
  return true;
}

}  // namespace

EmbreeScene::EmbreeScene(const TriangleMesh& mesh, std::span<const Triangle> triangles, const EmbreeSettings& settings)
    : m_triangles(triangles),
      m_positions(mesh.vertices),
      m_settings(settings),
      m_device(rtcNewDevice("threads=1,set_affinity=0")) {
  rtcSetDeviceMemoryMonitorFunction(m_device.get(), count_memory, &m_allocated);
  m_scene.reset(rtcNewScene(m_device.get()));
  m_geometry.reset(rtcNewGeometry(m_device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  m_vertices = static_cast<float*>(rtcSetNewGeometryBuffer(m_geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0,
                                                           RTC_FORMAT_FLOAT3, 3 * sizeof(float), m_positions.size()));
  auto* corners = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      m_geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), m_triangles.size()));
  for (const Triangle& triangle : m_triangles) {
    for (const int corner : triangle) *corners++ = static_cast<unsigned>(corner);
  }
  int flags = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
  if (m_settings.robust) flags |= RTC_SCENE_FLAG_ROBUST;
  if (m_settings.deforms) flags |= RTC_SCENE_FLAG_DYNAMIC;
  rtcSetSceneFlags(m_scene.get(), static_cast<RTCSceneFlags>(flags));
  const RTCBuildQuality quality = m_settings.deforms        ? RTC_BUILD_QUALITY_REFIT
                                  : m_settings.high_quality ? RTC_BUILD_QUALITY_HIGH
                                                            : RTC_BUILD_QUALITY_MEDIUM;
  rtcSetGeometryBuildQuality(m_geometry.get(), quality);
  if (!m_settings.deforms) rtcSetSceneBuildQuality(m_scene.get(), quality);
  place();
  rtcCommitGeometry(m_geometry.get());
  rtcAttachGeometry(m_scene.get(), m_geometry.get());
  rtcCommitScene(m_scene.get());
}

void EmbreeScene::update(std::span<const Vec3> positions) {
  m_positions = positions;
  place();
  rtcUpdateGeometryBuffer(m_geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(m_geometry.get());
  rtcCommitScene(m_scene.get());
}

void EmbreeScene::place() {
  Eigen::AlignedBox3d box;
  for (const Triangle& triangle : m_triangles) {
    for (const int corner : triangle) box.extend(m_positions[static_cast<std::size_t>(corner)]);
  }
  m_middle = box.center();
  m_rounding_m = rounding_units * single_rounding * box.diagonal().norm();
  for (std::size_t i = 0; i < m_positions.size(); ++i) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      m_vertices[3 * i + static_cast<std::size_t>(axis)] = static_cast<float>(m_positions[i][axis] - m_middle[axis]);
    }
  }
}

std::array<Vec3, 3> EmbreeScene::corners(int triangle) const {
  const auto& [a, b, c] = m_triangles[static_cast<std::size_t>(triangle)];
  return {m_positions[static_cast<std::size_t>(a)], m_positions[static_cast<std::size_t>(b)],
          m_positions[static_cast<std::size_t>(c)]};
}

EmbreeClosest EmbreeScene::closest(const Vec3& point, int near, double limit_m) const {
  const Vec3 local = point - m_middle;
  // A point far away is rounded by more than one at the surface.
  const double far_m = single_rounding * local.cwiseAbs().maxCoeff();
  Search search{*this, point, limit_m * limit_m, m_rounding_m + rounding_units * far_m, {}};
  if (near >= 0) search.look_at(near);
  RTCPointQuery query{static_cast<float>(local.x()), static_cast<float>(local.y()), static_cast<float>(local.z()), 0,
                      search.radius()};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(m_scene.get(), &query, &context, look_at_triangle, &search);
  return search.best;
}

void EmbreeScene::list_within(const Vec3& point, double radius_m, ListedTriangles& list) const {
  const Vec3 local = point - m_middle;
  const double rounding_m = m_rounding_m + rounding_units * single_rounding * local.cwiseAbs().maxCoeff();
  Listing listing{*this, point, radius_m * radius_m, list};
  RTCPointQuery query{static_cast<float>(local.x()), static_cast<float>(local.y()), static_cast<float>(local.z()), 0,
                      static_cast<float>(radius_m + rounding_m)};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(m_scene.get(), &query, &context, list_triangle, &listing);
}

bool EmbreeScene::is_inside(const Vec3& point) const {
  const Vec3 local = point - m_middle;
  const std::array<float, 3> from = {static_cast<float>(local.x()), static_cast<float>(local.y()),
                                     static_cast<float>(local.z())};
  const int most = std::min(m_settings.rays, static_cast<int>(directions.size()));
  int votes = 0;
  for (int ray = 0; ray < most; ++ray) {
    votes += windings_along(from, directions[static_cast<std::size_t>(ray)]) > 0 ? 1 : -1;
    if (std::abs(votes) > most - ray - 1) break;  // the others can't turn it
  }
  return votes > 0;
}

std::optional<double> EmbreeScene::way_out_m(const Vec3& from, const Vec3& direction, double length_m) const {
  const Vec3 local = from - m_middle;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  const std::array<float, 3> start = {static_cast<float>(local.x()), static_cast<float>(local.y()),
                                      static_cast<float>(local.z())};
  const std::array<float, 3> along = {static_cast<float>(direction.x()), static_cast<float>(direction.y()),
                                      static_cast<float>(direction.z())};
  RTCRayHit ray = ray_along(start, along, static_cast<float>(length_m + m_rounding_m));
  rtcIntersect1(m_scene.get(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const auto [a, b, c] = corners(static_cast<int>(ray.hit.primID));
  const Vec3 normal = (b - a).cross(c - a);
  const double rises = normal.dot(direction);
  if (!(rises > 0)) return std::nullopt;
  const double way_m = normal.dot(a - from) / rises;
  // Along a triangle that is almost parallel to the way rounding moves the point where its plane is met.
  const bool is_sure = std::abs(way_m - static_cast<double>(ray.ray.tfar)) < rounding_units * m_rounding_m;
  return is_sure && way_m <= length_m ? std::optional(std::max(way_m, 0.0)) : std::nullopt;
}

int EmbreeScene::windings_along(const std::array<float, 3>& from, const std::array<float, 3>& direction) const {
  CountingRay counting;
  rtcInitIntersectContext(&counting.context);
  counting.context.filter = count_crossing;
  RTCRayHit ray = ray_along(from, direction, std::numeric_limits<float>::infinity());
  rtcIntersect1(m_scene.get(), &counting.context, &ray);
  return counting.windings;
}

std::size_t EmbreeScene::bytes() const {
  return sizeof(*this) + static_cast<std::size_t>(std::max<std::ptrdiff_t>(m_allocated, 0));
}

}  // namespace musclebench
