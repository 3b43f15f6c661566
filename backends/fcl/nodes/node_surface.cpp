#include "backends/fcl/nodes/node_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include "backends/fcl/fcl_model.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

constexpr std::size_t all_contacts = std::numeric_limits<std::size_t>::max();
/// Distances that FCL measures and those that are measured here differ by this share of them, besides the rounding of
/// coordinates.
constexpr double rounding_share = 1e-9;

/// A closest point is a sum of three points, each rounded to the digits that the largest coordinate leaves; twice that
/// for the two that are compared.
double rounding_of(const Eigen::AlignedBox3d& box) {
  constexpr double units = 16;
  return box.isEmpty() ? 0
                       : units * std::numeric_limits<double>::epsilon() *
                             box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
}

fcl::Transform3d at(const Vec3& point) {
  fcl::Transform3d transform = fcl::Transform3d::Identity();
  transform.translation() = point;
  return transform;
}

}  // namespace

NodeSurface::NodeSurface(const FclOptions& options, const Bone& bone)
    : m_sides(bone.kept_signed_distance()),
      m_box(bounding_box(bone.surface.mesh.vertices)),
      m_touching_m(touching_distance_m(bone.surface.mesh)),
      m_rounding_m(m_touching_m + rounding_of(m_box)),
      m_solver(to_fcl(options.narrow_phase)),
      m_node_radius_m(options.node_radius_m) {
  with_bounding_volume(options.bounding_volume, [&](auto volume) {
    const TriangleMesh& mesh = bone.surface.mesh;
    auto model = make_fcl_model<typename decltype(volume)::type>(mesh.vertices, mesh.triangles);
    m_model_bytes = model_bytes(*model);
    m_model = std::move(model);
  });
}

bool NodeSurface::is_outside_box(const Vec3& point, double reach_m) const {
  return !point.allFinite() || m_box.isEmpty() || m_box.exteriorDistance(point) > reach_m;
}

bool NodeSurface::contains(const Vec3& point, const ClosestPoint& closest) const {
  return closest.distance_m > m_touching_m && m_sides->is_inside(point, closest);
}

Vec3 NodeSurface::outward(const Vec3& point, const ClosestPoint& closest) {
  return (closest.point - point) / (closest.point - point).norm();
}

ClosestPoint NodeSurface::closest(const Vec3& point) const {
  const fcl::Sphered node(0);
  const fcl::DistanceRequestd request(true, false, 0, 0, 1e-6, m_solver);
  fcl::DistanceResultd result;
  fcl::distance(m_model.get(), fcl::Transform3d::Identity(), &node, at(point), request, result);
  const int named = std::max(static_cast<int>(result.b1), 0);
  const ClosestOnTriangle found = closest_on(point, named);
  return {found.point, std::sqrt(found.squared_distance_m2), named, found.feature};
}

/// Where a point lies in a triangle, FCL 0.7 leaves that triangle's distance unset, and names another one or this one
/// with any distance; and of several triangles at the same distance it names any. Its collision is sound in both cases.
ClosestPoint NodeSurface::settled(const Vec3& point, const ClosestPoint& closest) const {
  std::vector<int> near;
  meet(point, (1 + rounding_share) * closest.distance_m + m_rounding_m, near);
  near.push_back(closest.triangle);
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
