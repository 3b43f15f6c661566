#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/base/scoped_timer.hpp"
#include "core/distance/triangle_distance.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// One node of a muscle found inside another muscle. There is at most one contact a node and other muscle. Both sides
/// move: the closest triangle against the normal, the node along it (rows_of, ContactRowSolver).
struct MuscleContact {
  int node = 0;
  int muscle = 0;               ///< the other one, an index of the scene's bodies
  int triangle = 0;             ///< its closest one, of the mesh of all muscles
  Vec3 weights = Vec3::Zero();  ///< barycentric coordinates of the closest point in it: positive or 0, the sum is 1
  double depth_m = 0;           ///< distance to the closest point, > 0
  Vec3 normal = Vec3::UnitZ();  ///< unit, world frame, from the node to the closest point: out of the other muscle
};

/// Two muscles that touch each other: indices of the scene's bodies, the smaller one first.
struct MusclePair {
  int first = 0;
  int second = 0;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes the 0 that results are compared with for a pointer.
  friend auto operator<=>(const MusclePair&, const MusclePair&) = default;
};

/// Time of one pair in a detector's last detection: queries of the nodes of either muscle against the other, summed
/// over threads. Refitting and clearances serve all pairs and are in none.
struct PairTime {
  MusclePair muscles;
  Nanoseconds detect_ns = 0;
};

/// The muscles and pairs that a detector of contacts between muscles is made for.
struct TouchingMuscles {
  const TriangleMesh& mesh;  ///< of all muscles, at rest; outlives the detector
  std::vector<Body> bodies;
  std::vector<MusclePair> pairs;  ///< ascending, no pair twice
};

/// Finds the nodes of muscles that lie inside other muscles, while all of them deform. Surfaces are closed
/// (a scene's reader sees to it). May use several threads, with the same result for any number.
class MuscleContactDetector {
 public:
  MuscleContactDetector() = default;
  MuscleContactDetector(const MuscleContactDetector&) = delete;
  MuscleContactDetector& operator=(const MuscleContactDetector&) = delete;
  virtual ~MuscleContactDetector() = default;

  /// Finds the contacts of the pairs at `positions` (of all nodes, world frame, m), into `contacts`, which is
  /// overwritten: ordered by node, then by the other muscle.
  virtual void detect(std::span<const Vec3> positions, std::vector<MuscleContact>& contacts) = 0;

  /// In the order of `TouchingMuscles::pairs`.
  [[nodiscard]] virtual std::span<const PairTime> pair_times() const = 0;

  /// Of its structures, counted from their sizes, without the input meshes.
  [[nodiscard]] virtual std::size_t structure_bytes() const = 0;
};

/// Makes a backend's detector; empty for a backend that can't follow a surface that deforms.
using MakeMuscleContactDetector = std::function<std::unique_ptr<MuscleContactDetector>(
    const Parameters& parameters, const TouchingMuscles& muscles, int threads)>;

/// The contact of a node at `point` whose closest point on the other muscle is known.
MuscleContact muscle_contact_at(int node, int muscle, const Vec3& point, int triangle,
                                const std::array<Vec3, 3>& corners, const ClosestOnTriangle& closest);

/// All muscles that touch the one at `index`, ascending.
std::vector<int> muscles_beside(std::span<const MusclePair> pairs, int index);

/// Index in `pairs` of two muscles that touch, in either order.
std::size_t pair_index(std::span<const MusclePair> pairs, int one, int other);

/// A time of 0 for each pair.
std::vector<PairTime> no_times(std::span<const MusclePair> pairs);

}  // namespace musclebench
