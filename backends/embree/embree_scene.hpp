#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <embree3/rtcore.h>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "core/clearance/located_triangles.hpp"
#include "core/distance/triangle_distance.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// How Embree is driven. The defaults are what its documentation advises.
struct EmbreeSettings {
  int rays = 3;              ///< that vote on the side of a point, odd
  bool robust = true;        ///< RTC_SCENE_FLAG_ROBUST: rays do not slip between triangles
  bool high_quality = true;  ///< RTC_BUILD_QUALITY_HIGH: a slower build and a better tree
  bool deforms = false;      ///< a tree that is refitted to new positions
};

/// The closest point that a query found.
struct EmbreeClosest {
  ClosestOnTriangle on_triangle;
  int triangle = -1;  ///< -1: none closer than the limit
};

/// A surface in Embree. Embree computes in single precision, so the surface is kept relative to a middle. Its tree
/// says which triangles are near; their distance is computed in double precision, so closest points are exact. The side
/// of a point is Embree's: rays that count what they pass. Queries are safe from several threads.
class EmbreeScene {
 public:
  /// `mesh` outlives the scene. `triangles` are the ones of the mesh that count.
  EmbreeScene(const TriangleMesh& mesh, std::span<const Triangle> triangles, const EmbreeSettings& settings);
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// Follows `positions` of all vertices, kept by reference. For a scene that deforms.
  void update(std::span<const Vec3> positions);

  /// The closest point of the surface, not farther than `limit_m` from `point`. Triangles count from 0 within those of
  /// the scene. `near`: one that may be close, or -1.
  [[nodiscard]] EmbreeClosest closest(const Vec3& point, int near, double limit_m) const;
  /// Adds every triangle closer to `point` than `radius_m`.
  void list_within(const Vec3& point, double radius_m, ListedTriangles& list) const;
  /// Whether most rays from `point` leave the surface more often than they enter it.
  [[nodiscard]] bool is_inside(const Vec3& point) const;
  /// How far a point inside goes along `direction` (unit) until it leaves the surface; nothing if that is farther than
  /// `length_m`, or if it enters first. Embree finds the triangle; where its plane is met is computed in double
  /// precision.
  [[nodiscard]] std::optional<double> way_out_m(const Vec3& from, const Vec3& direction, double length_m) const;
  [[nodiscard]] std::array<Vec3, 3> corners(int triangle) const;
  /// How far single precision may move a point or a triangle, m.
  [[nodiscard]] double rounding_m() const { return m_rounding_m; }
  /// What Embree allocated, and the vertices that it was given.
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
  };
  template <typename Handle>
  using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release>;

  void place();
  [[nodiscard]] int windings_along(const std::array<float, 3>& from, const std::array<float, 3>& direction) const;

  std::span<const Triangle> m_triangles;
  std::span<const Vec3> m_positions;
  EmbreeSettings m_settings;
  Vec3 m_middle = Vec3::Zero();
  double m_rounding_m = 0;
  std::atomic<std::ptrdiff_t> m_allocated = 0;  ///< before the device, which counts until it is gone
  Owned<RTCDevice> m_device;
  Owned<RTCScene> m_scene;
  Owned<RTCGeometry> m_geometry;
  float* m_vertices = nullptr;  ///< Embree's own
};

}  // namespace musclebench
