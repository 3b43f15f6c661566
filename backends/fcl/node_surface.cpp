#include "backends/fcl/node_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include "backends/fcl/fcl_model.hpp"
#include "core/geometry/mesh_size.hpp"

namespace musclebench {

namespace {

constexpr std::size_t all_contacts = std::numeric_limits<std::size_t>::max();

/// Above the rounding of FCL's test of a sphere and a triangle.
constexpr double sphere_slack = 1e-9;

/// In sizes of a triangle. FCL looks at all triangles in the box of a sphere, so that for a larger one its distance is
/// the faster way.
constexpr double largest_sphere = 2;
/// What a list reaches beyond the closest triangle: about as far as its places do on a smooth surface.
constexpr double list_reach = 2.5;

fcl::Transform3d at(const Vec3& point) {
  fcl::Transform3d transform = fcl::Transform3d::Identity();
  transform.translation() = point;
  return transform;
}

/// Triangles that `closest_on_triangle` may answer too far away by more than rounding: their distance at one place says
/// nothing about that at another.
std::vector<bool> needles_of(const TriangleMesh& mesh) {
  constexpr double least_squared_sine = 1e-6;
  std::vector<bool> needles;
  needles.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(triangle[i % 3])]; };
    bool is_needle = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 a = corner(i + 1) - corner(i);
      const Vec3 b = corner(i + 2) - corner(i);
      is_needle |= !(a.cross(b).squaredNorm() > least_squared_sine * a.squaredNorm() * b.squaredNorm());
    }
    needles.push_back(is_needle);
  }
  return needles;
}

}  // namespace

NodeSurface::NodeSurface(const FclOptions& options, const RepairedMesh& surface,
                         std::shared_ptr<fcl::CollisionGeometryd> model)
    : m_mesh(surface.mesh),
      m_sides(surface),
      m_model(std::move(model)),
      m_solver(to_fcl(options.narrow_phase)),
      m_box(bounding_box(m_mesh.vertices)),
      m_needles(needles_of(m_mesh)),
      m_touching_m(touching_distance_m(m_mesh)),
      m_node_radius_m(options.node_radius_m),
      m_triangle_size_m(mean_triangle_size_m(m_mesh)) {}

bool NodeSurface::is_outside(const Vec3& point, double& clearance_m) const {
  clearance_m = 0;
  if (!point.allFinite() || m_box.isEmpty()) {
    return true;
  }
  clearance_m = m_box.exteriorDistance(point);
  return clearance_m > 0;
}

ClosestPoint NodeSurface::closest(const Vec3& point) const {
  return closest_by_distance(point, std::numeric_limits<double>::max(), 0);
}

ClosestPoint NodeSurface::closest_by_distance(const Vec3& point, double bound_m, int triangle) const {
  const fcl::Sphered node(0);
  const fcl::DistanceRequestd request(true, false, 0, 0, 1e-6, m_solver);
  fcl::DistanceResultd result(bound_m);
  result.b1 = triangle;
  fcl::distance(m_model.get(), fcl::Transform3d::Identity(), &node, at(point), request, result);
  const int named = std::max(static_cast<int>(result.b1), 0);
  const ClosestOnTriangle found = closest_on(point, named);
  return {found.point, std::sqrt(found.squared_distance_m2), named, found.feature};
}

/// Where a point lies in a triangle, FCL 0.7 leaves that triangle's distance unset, and names another one or this one
/// with any distance; and of several triangles at the same distance it names any. Its collision is sound in both cases.
ClosestPoint NodeSurface::settled(const Vec3& point, const ClosestPoint& closest) const {
  return closest_within(point, closest.distance_m, closest.triangle);
}

/// Across a hole the side changes without a surface.
double NodeSurface::free_m(const Vec3& point, const ClosestPoint& closest, bool is_settled) const {
  if (!m_sides.closed() || !(closest.distance_m > m_touching_m)) {
    return 0;
  }
  if (is_settled) {
    return (1 - sphere_slack) * closest.distance_m;
  }
  std::vector<int> touched;
  meet(point, m_touching_m, touched);
  return touched.empty() ? (1 - sphere_slack) * closest.distance_m : 0;
}

ClosestPoint NodeSurface::closest_from(const Vec3& point, int triangle) const {
  const double bound_m = distance_m(point, triangle);
  return bound_m < largest_sphere * m_triangle_size_m
             ? closest_within(point, bound_m, triangle)
             : closest_by_distance(point, (1 + sphere_slack) * bound_m, triangle);
}

double NodeSurface::distance_m(const Vec3& point, int triangle) const {
  return std::sqrt(closest_on(point, triangle).squared_distance_m2);
}

ClosestOnTriangle NodeSurface::closest_on(const Vec3& point, int triangle) const {
  const Triangle& corners = m_mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto corner = [&](std::size_t i) { return m_mesh.vertices[static_cast<std::size_t>(corners[i])]; };
  return closest_on_triangle(point, corner(0), corner(1), corner(2));
}

ClosestPoint NodeSurface::closest_within(const Vec3& point, double distance_m, int triangle) const {
  std::vector<int> near;
  meet(point, distance_m * (1 + sphere_slack) + m_touching_m, near);
  near.push_back(triangle);
  return closest_of(point, near);
}

ClosestPoint NodeSurface::closest_of(const Vec3& point, std::span<const int> triangles) const {
  ClosestPoint best;
  double squared_m2 = std::numeric_limits<double>::infinity();
  for (const int triangle : triangles) {
    const ClosestOnTriangle found = closest_on(point, triangle);
    if (found.squared_distance_m2 < squared_m2 ||
        (found.squared_distance_m2 == squared_m2 && triangle < best.triangle)) {
      squared_m2 = found.squared_distance_m2;
      best = {found.point, 0, triangle, found.feature};
    }
  }
  best.distance_m = std::sqrt(squared_m2);
  return best;
}

void NodeSurface::list_near(const Vec3& point, double bound_m, NearTriangles& list) const {
  const double radius_m = bound_m + list_reach * m_triangle_size_m;
  std::vector<int> met;
  meet(point, radius_m, met);
  std::vector<std::pair<double, int>> by_distance;
  by_distance.reserve(met.size());
  for (const int triangle : met) {
    const bool is_needle = m_needles[static_cast<std::size_t>(triangle)];
    by_distance.emplace_back(is_needle ? 0.0 : std::sqrt(closest_on(point, triangle).squared_distance_m2), triangle);
  }
  std::sort(by_distance.begin(), by_distance.end());
  list.place = point;
  list.count = std::min(by_distance.size(), list.nearest.size());
  for (std::size_t i = 0; i < list.count; ++i) {
    const auto& [distance_m, triangle] = by_distance[i];
    list.nearest[i] = {triangle, std::nextafter(static_cast<float>(distance_m), 0.0F)};
  }
  const bool all = list.count == by_distance.size();
  list.complete_m = (1 - sphere_slack) * (all ? radius_m : std::min(radius_m, by_distance[list.count].first));
}

ListedClosest NodeSurface::finish_listed(const Vec3& point, const NearTriangles& list, double /*enough_m*/,
                                         const ListSearch& /*search*/) const {
  return musclebench::closest_listed(list, point, [&](int triangle) { return closest_on(point, triangle); });
}

bool NodeSurface::contains(const Vec3& point, const ClosestPoint& closest) const {
  return closest.distance_m > m_touching_m && m_sides.is_inside(point, closest);
}

Vec3 NodeSurface::outward(const Vec3& point, const ClosestPoint& closest) const {
  return (closest.point - point) / (closest.point - point).norm();
}

ClosestPoint NodeSurface::closest_met(const Vec3& point) const {
  std::vector<int> near;
  meet(point, m_node_radius_m, near);
  return closest_of(point, near);
}

void NodeSurface::meet(const Vec3& point, double radius_m, std::vector<int>& triangles) const {
  const fcl::Sphered sphere(radius_m);
  fcl::CollisionRequestd request(all_contacts, false);
  request.gjk_solver_type = m_solver;
  fcl::CollisionResultd result;
  fcl::collide(m_model.get(), fcl::Transform3d::Identity(), &sphere, at(point), request, result);
  triangles.clear();
  for (std::size_t i = 0; i < result.numContacts(); ++i) {
    triangles.push_back(static_cast<int>(result.getContact(i).b1));
  }
}

}  // namespace musclebench
