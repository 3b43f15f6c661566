#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// What has to be known of a node for it to be free of a muscle.
struct MuscleQuery {
  double touching_m = 0;  ///< a point that is no farther from the surface is on it, and free
  double excess_travel_m =
      0;                ///< where the surface is farther away than this, the node is free; its side need not be asked
  double enough_m = 0;  ///< a larger distance need not be told
};

/// Where a node is to a muscle.
struct MuscleAnswer {
  double clearance_m = 0;  ///< lower bound of the distance, or `enough_m` where that is less; 0 inside
  int triangle = -1;       ///< inside: the closest one, of the mesh of all muscles; -1: the node is free
  ClosestOnTriangle closest = {};
};

/// What a method that finds contacts between muscles node by node keeps of one muscle, whose surface is closed.
class DeformingStructure {
 public:
  DeformingStructure() = default;
  DeformingStructure(const DeformingStructure&) = delete;
  DeformingStructure& operator=(const DeformingStructure&) = delete;
  virtual ~DeformingStructure() = default;

  /// Follows the muscle to `positions` (of all nodes, world frame, m), which stay as they are until the next call.
  virtual void update(std::span<const Vec3> positions, int threads) = 0;

  /// `guess`: a triangle that may be near, or -1; becomes the one that was closest, for the next query of this node.
  /// Safe from several threads.
  [[nodiscard]] virtual MuscleAnswer query(const Vec3& point, const MuscleQuery& wanted, int& guess) const = 0;

  /// Counted from sizes, without the mesh.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

/// Describes such a method.
struct DeformingMethod {
  /// Whether only nodes are queried that have used up their clearance (MovingClearances). It changes the time only.
  bool has_cache = false;
  std::function<std::unique_ptr<DeformingStructure>(const TriangleMesh& mesh, const Body& body)> build = nullptr;
};

/// Loops over nodes and the muscles beside theirs, deals them out to threads, keeps clearances, the order of contacts
/// and the times of pairs: the same contacts for any number of threads.
std::unique_ptr<MuscleContactDetector> make_point_muscle_detector(const DeformingMethod& method,
                                                                  const TouchingMuscles& muscles, int threads);

}  // namespace musclebench
