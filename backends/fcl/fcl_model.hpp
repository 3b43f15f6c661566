// Knows FCL's types: for the .cpp files of this folder only.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/gjk_solver_type.h>

#include "backends/fcl/fcl_options.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

// The library was compiled for the baseline CPU. A wider alignment here (-march=native without
// EIGEN_MAX_ALIGN_BYTES=16) would give CollisionObject another layout than it has inside the library.
static_assert(alignof(fcl::Transform3d) == 16, "compile with EIGEN_MAX_ALIGN_BYTES=16, as FCL was");

inline fcl::Transform3d to_fcl(const RigidMotion& motion) {
  fcl::Transform3d transform = fcl::Transform3d::Identity();
  transform.linear() = motion.rotation;
  transform.translation() = motion.translation_m;
  return transform;
}

inline fcl::GJKSolverType to_fcl(NarrowPhase solver) {
  return solver == NarrowPhase::libccd ? fcl::GST_LIBCCD : fcl::GST_INDEP;
}

template <typename BoundingVolume>
using FclModel = fcl::BVHModel<BoundingVolume>;

template <typename BoundingVolume>
std::shared_ptr<FclModel<BoundingVolume>> make_fcl_model(std::span<const Vec3> vertices,
                                                         std::span<const Triangle> triangles) {
  const std::vector<Vec3> points(vertices.begin(), vertices.end());
  std::vector<fcl::Triangle> corners;
  corners.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    corners.emplace_back(static_cast<std::size_t>(triangle[0]), static_cast<std::size_t>(triangle[1]),
                         static_cast<std::size_t>(triangle[2]));
  }
  auto model = std::make_shared<FclModel<BoundingVolume>>();
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
  model->addSubModel(points, corners);
  model->endModel();
  return model;
}

/// BVHModel::memUsage() answers an error code, so its arrays are counted here. A model of n triangles allocates 2 n - 1
/// nodes and as many primitive indices, though only n of these are used.
template <typename BoundingVolume>
std::size_t model_bytes(const FclModel<BoundingVolume>& model) {
  const auto triangles = static_cast<std::size_t>(model.num_tris);
  const auto vertices = static_cast<std::size_t>(model.num_vertices);
  const std::size_t nodes = 2 * triangles - 1;
  return sizeof(FclModel<BoundingVolume>) + nodes * (sizeof(fcl::BVNode<BoundingVolume>) + sizeof(unsigned int)) +
         triangles * sizeof(fcl::Triangle) + vertices * sizeof(Vec3) + sizeof(fcl::detail::BVSplitter<BoundingVolume>) +
         sizeof(fcl::detail::BVFitter<BoundingVolume>);
}

/// Calls `visit(std::type_identity<V>{})` with FCL's type V of that name. Throws InputError for an unknown one.
template <typename Visit>
auto with_bounding_volume(const std::string& name, const Visit& visit) {
  if (name == "OBBRSS") {
    return visit(std::type_identity<fcl::OBBRSSd>{});
  }
  if (name == "OBB") {
    return visit(std::type_identity<fcl::OBBd>{});
  }
  if (name == "RSS") {
    return visit(std::type_identity<fcl::RSSd>{});
  }
  if (name == "kIOS") {
    return visit(std::type_identity<fcl::kIOSd>{});
  }
  if (name == "AABB") {
    return visit(std::type_identity<fcl::AABBd>{});
  }
  if (name == "KDOP24") {
    return visit(std::type_identity<fcl::KDOPd<24>>{});
  }
  throw InputError("fcl: bounding_volume",
                   "'" + name + "' is unknown; did you mean '" + nearest_word(name, bounding_volumes()) + "'?");
}

}  // namespace musclebench
