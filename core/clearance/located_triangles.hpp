#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/clearance/cached_point_query.hpp"
#include "core/clearance/query_surface.hpp"
#include "core/contact/backend_entry.hpp"
#include "core/contact/bone.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/contact/surface_queries.hpp"
#include "core/distance/triangle_distance.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

/// Triangles near a place, as a library lists them, each once. A list that overflows is of no use and is not kept.
class ListedTriangles {
 public:
  static constexpr std::size_t capacity = 26;

  void add(int triangle) {
    const auto known = m_triangles.begin() + static_cast<std::ptrdiff_t>(std::min(m_count, capacity));
    if (std::find(m_triangles.begin(), known, triangle) != known) return;
    if (m_count < capacity) m_triangles[m_count] = triangle;
    ++m_count;
  }
  void clear() { m_count = 0; }
  [[nodiscard]] bool empty() const { return m_count == 0; }
  [[nodiscard]] bool has_overflowed() const { return m_count > capacity; }
  [[nodiscard]] auto begin() const { return m_triangles.begin(); }
  [[nodiscard]] auto end() const { return m_triangles.begin() + static_cast<std::ptrdiff_t>(m_count); }

 private:
  std::array<int, capacity> m_triangles;
  std::size_t m_count = 0;
};

/// What a library has to offer about the triangles of one bone to get candidate lists as well as a clearance cache and
/// warm starts. Points are finite, in the bone's rest frame, in metres, and no farther than 1e15 m from its origin;
/// triangles are those of the bone's mesh. All operations are const and safe from several threads.
///
/// - `closest(point, near)`: index of the closest triangle. `near` is one that may be near, or -1; it must change no
///   answer. Of several triangles at the same distance a list takes the smallest index; where this takes another, the
///   last digits of a contact may depend on the cache.
/// - `list_within(point, radius_m, list)`: adds every triangle closer to `point` than `radius_m`. It may add more.
/// - `is_inside(point)`: the side of a point that is not on the surface.
/// - `answer_bound()`: see BoneStructure.
/// - `bytes()`: memory of the structure.
///
/// It may offer `way_out_m(from, direction, length_m)`, too: SurfaceQueries::way_out_m by a ray of its own.
template <typename Library>
concept TriangleLibrary = requires(const Library& library, const Vec3& point, double radius_m, int near,
                                   ListedTriangles& list) {
  { library.closest(point, near) } -> std::same_as<int>;
  library.list_within(point, radius_m, list);
  { library.is_inside(point) } -> std::same_as<bool>;
  { library.answer_bound() } -> std::same_as<AnswerBound>;
  { library.bytes() } -> std::same_as<std::size_t>;
};

/// A QuerySurface over a TriangleLibrary, for CachedPointQuery. Distances to single triangles are computed here, in
/// double precision, so that a library that works in single precision has only to find the right triangle.
template <TriangleLibrary Library>
class LocatedTriangles {
 public:
  struct CandidateList {
    ListedTriangles triangles;
    Vec3 point = Vec3::Zero();
    double reach_m = 0;  ///< from `point`: all triangles that are closer are listed

    [[nodiscard]] bool empty() const { return triangles.empty(); }
    void clear() { triangles.clear(); }
  };
  struct CandidateSearch {
    Vec3 point = Vec3::Zero();
  };

  /// The bone outlives the surface. `culls`: points outside the box of a closed bone are told without the library.
  LocatedTriangles(std::unique_ptr<const Library> library, const Bone& bone, bool culls)
      : m_library(std::move(library)),
        m_mesh(&bone.surface.mesh),
        m_touching_m(touching_distance_m(*m_mesh)),
        m_near_m(mean_triangle_size_m(*m_mesh)),
        m_is_closed(musclebench::is_closed(*m_mesh)),
        m_culls(culls && m_is_closed) {
    m_box = bounding_box(m_mesh->vertices);
    const Vec3 reach = Vec3::Constant(m_library->answer_bound().false_distance_m);
    m_box = Eigen::AlignedBox3d(m_box.min() - reach, m_box.max() + reach);
  }

  [[nodiscard]] bool is_outside(const Vec3& point, double& clearance_m) const {
    clearance_m = 0;
    if (!(point.array().abs() < farthest_m).all()) return true;
    if (m_culls) clearance_m = m_box.exteriorDistance(point);
    return clearance_m > 0;
  }
  [[nodiscard]] ClosestPoint closest(const Vec3& point, int triangle) const {
    return on_triangle(point, m_library->closest(point, triangle));
  }
  /// No library tells a bound that is cheaper than the distance.
  [[nodiscard]] Clearance clearance(const Vec3& /*point*/, int /*triangle*/) const { return {}; }
  [[nodiscard]] double distance_m(const Vec3& point, int triangle) const {
    return on_triangle(point, triangle).distance_m;
  }
  [[nodiscard]] PointSide side(const Vec3& point, const ClosestPoint& closest) const {
    if (!(closest.distance_m > m_touching_m)) return {};
    if (m_library->is_inside(point)) return {.inside = true};
    // What a library rounds may hide that much; across a hole the side changes in empty space.
    const double clearance_m = closest.distance_m - m_library->answer_bound().storage_m;
    return {.inside = false, .clearance_m = m_is_closed ? std::max(clearance_m, 0.0) : 0};
  }
  [[nodiscard]] Vec3 outward(const Vec3& point, const ClosestPoint& closest) const {
    return (closest.point - point) / closest.distance_m;
  }
  /// Unit normal of a triangle.
  [[nodiscard]] Vec3 normal(int triangle) const {
    const auto [a, b, c] = corners(triangle);
    return (b - a).cross(c - a).stableNormalized();
  }
  /// Whether the side of a point changes only at the surface.
  [[nodiscard]] bool is_closed() const { return m_is_closed; }
  [[nodiscard]] const Library& library() const { return *m_library; }
  [[nodiscard]] AnswerBound answer_bound() const { return m_library->answer_bound(); }
  [[nodiscard]] double touching_m() const { return m_touching_m; }
  [[nodiscard]] double near_m() const { return m_near_m; }
  [[nodiscard]] std::size_t bytes() const { return sizeof(*this) + m_library->bytes(); }

  void list_candidates(const Vec3& point, double bound_m, CandidateList& list) const {
    list.point = point;
    list.reach_m = bound_m + list_skin * m_near_m;
    m_library->list_within(point, list.reach_m * (1 + length_rounding), list.triangles);
    if (list.triangles.has_overflowed()) list.clear();
  }
  void begin_candidate_search(const Vec3& point, const CandidateList& /*list*/, CandidateSearch& search) const {
    search.point = point;
  }
  [[nodiscard]] ClosestCandidate finish_candidate_search(const CandidateList& list, double enough_m,
                                                         CandidateSearch& search) const {
    ClosestCandidate found;
    found.closest.distance_m = std::numeric_limits<double>::infinity();
    for (const int triangle : list.triangles) {
      const ClosestPoint other = on_triangle(search.point, triangle);
      const bool is_first = other.distance_m == found.closest.distance_m && triangle < found.closest.triangle;
      if (other.distance_m < found.closest.distance_m || is_first) found.closest = other;
    }
    const double covered_m = list.reach_m - (search.point - list.point).norm();
    found.certain = found.closest.distance_m < covered_m;
    const double clearance_m = std::min(found.closest.distance_m, covered_m) - m_library->answer_bound().storage_m;
    if (m_is_closed && clearance_m > enough_m) found.clearance_m = clearance_m;
    return found;
  }
  void prefetch(const Vec3& /*point*/, const CandidateList& /*list*/) const {}

 private:
  /// The squares of larger coordinates may overflow in a library that computes in single precision.
  static constexpr double farthest_m = 1e15;
  /// More than the relative rounding errors of the lengths that are compared with a list's reach.
  static constexpr double length_rounding = 1e-9;
  /// Skin of a candidate list, in mean triangle sizes.
  static constexpr double list_skin = 0.75;

  [[nodiscard]] std::array<Vec3, 3> corners(int triangle) const {
    const auto& [a, b, c] = m_mesh->triangles[static_cast<std::size_t>(triangle)];
    const auto corner = [&](int vertex) -> const Vec3& { return m_mesh->vertices[static_cast<std::size_t>(vertex)]; };
    return {corner(a), corner(b), corner(c)};
  }
  [[nodiscard]] ClosestPoint on_triangle(const Vec3& point, int triangle) const {
    const auto [a, b, c] = corners(triangle);
    const ClosestOnTriangle found = closest_on_triangle(point, a, b, c);
    return {found.point, std::sqrt(found.squared_distance_m2), triangle, found.feature};
  }

  std::unique_ptr<const Library> m_library;
  const TriangleMesh* m_mesh;
  double m_touching_m;
  double m_near_m;
  bool m_is_closed;
  bool m_culls;
  Eigen::AlignedBox3d m_box;
};

/// SurfaceQueries over a TriangleLibrary.
template <TriangleLibrary Library>
class TriangleQueries final : public SurfaceQueries {
 public:
  explicit TriangleQueries(LocatedTriangles<Library> surface) : m_surface(std::move(surface)) {}

  [[nodiscard]] SurfaceAnswer locate(const Vec3& point, int near) const override {
    const ClosestPoint closest = m_surface.closest(point, near);
    const Vec3 away = point - closest.point;
    if (!(closest.distance_m > m_surface.touching_m())) {
      const Vec3 normal = m_surface.normal(closest.triangle);
      return {normal.dot(away), normal, closest.point, closest.triangle};
    }
    return on_side(m_surface.side(point, closest).inside, point, closest);
  }

  [[nodiscard]] SurfaceAnswer locate_from(const Vec3& point, const Vec3& last_point,
                                          const SurfaceAnswer& last) const override {
    const double free_m = std::abs(last.signed_distance_m) - m_surface.answer_bound().storage_m;
    // Across a hole the side changes in empty space.
    if (!m_surface.is_closed() || !((point - last_point).norm() < free_m)) return locate(point, last.near);
    const ClosestPoint closest = m_surface.closest(point, last.near);
    if (!(closest.distance_m > m_surface.touching_m())) return locate(point, last.near);
    return on_side(last.signed_distance_m < 0, point, closest);
  }

  [[nodiscard]] Clearance clearance(const Vec3& point, int near) const override {
    const ClosestPoint closest = m_surface.closest(point, near);
    return {std::max(closest.distance_m - m_surface.answer_bound().storage_m, 0.0), closest.triangle};
  }

  [[nodiscard]] std::size_t bytes() const override { return m_surface.bytes(); }

  [[nodiscard]] std::optional<double> way_out_m(const Vec3& from, const Vec3& direction, double length_m, int near,
                                                std::vector<PathCrossing>& scratch) const override {
    if constexpr (requires { m_surface.library().way_out_m(from, direction, length_m); }) {
      return m_surface.library().way_out_m(from, direction, length_m);
    } else {
      return SurfaceQueries::way_out_m(from, direction, length_m, near, scratch);
    }
  }

 private:
  [[nodiscard]] static SurfaceAnswer on_side(bool inside, const Vec3& point, const ClosestPoint& closest) {
    const double signed_distance_m = inside ? -closest.distance_m : closest.distance_m;
    return {signed_distance_m, (point - closest.point) / signed_distance_m, closest.point, closest.triangle};
  }

  LocatedTriangles<Library> m_surface;
};

/// BackendEntry::make_surface_queries of such a backend, with the same `make`.
template <typename Make>
MakeSurfaceQueries queries_on_triangles(Make make) {
  return [make](const Bone& bone, int /*threads*/) -> std::shared_ptr<const SurfaceQueries> {
    auto library = make(bone);
    using Library = std::remove_const_t<typename decltype(library)::element_type>;
    return std::make_shared<const TriangleQueries<Library>>(LocatedTriangles<Library>(std::move(library), bone, false));
  };
}

/// PointMethod::build of a backend over a TriangleLibrary that has `cull_parameter()`. `make(bone)` returns the
/// library's structure over a bone: std::unique_ptr<const Library>.
template <typename Make>
auto build_on_triangles(const Parameters& parameters, Make make) {
  const bool culls = parameters.flag("cull");
  return [culls, make](const Bone& bone, int /*threads*/,
                       const ShareReport& /*report*/) -> std::unique_ptr<BoneStructure> {
    auto library = make(bone);
    using Surface = LocatedTriangles<std::remove_const_t<typename decltype(library)::element_type>>;
    return std::make_unique<CachedPointQuery<Surface>>(Surface(std::move(library), bone, culls));
  };
}

}  // namespace musclebench
