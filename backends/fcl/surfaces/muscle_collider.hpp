#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "backends/fcl/fcl_options.hpp"
#include "backends/fcl/surfaces/muscle_surface.hpp"

namespace musclebench {

/// Triangles of two muscles that intersect, as the indices of `MuscleSurface::triangles`.
struct IntersectingTriangles {
  int of_first = 0;
  int of_second = 0;
};

/// FCL's part of contacts between muscles, without FCL's types: pairs of intersecting triangles of two surfaces, both
/// of which deform.
class MuscleCollider {
 public:
  MuscleCollider() = default;
  MuscleCollider(const MuscleCollider&) = delete;
  MuscleCollider& operator=(const MuscleCollider&) = delete;
  virtual ~MuscleCollider() = default;

  /// Refits the tree of one muscle to the positions of its nodes, world frame, m. Different muscles may be updated by
  /// several threads at once.
  virtual void update(std::size_t muscle, std::span<const Vec3> positions) = 0;

  /// All pairs that FCL finds after the last update, overwritten, in the order of its traversal; none where the boxes
  /// of the muscles do not overlap or a position is not finite. Different pairs may be collided by several threads at
  /// once.
  virtual void collide(std::size_t first, std::size_t second, std::vector<IntersectingTriangles>& pairs) = 0;

  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

std::unique_ptr<MuscleCollider> make_muscle_collider(const FclOptions& options, std::span<const MuscleSurface> muscles);

}  // namespace musclebench
