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

/// A node of one muscle that was found inside another muscle. There is at most one contact for each node and other
/// muscle. The node moves along the normal, the closest triangle against it, each by its share of inverse mass.
struct MuscleContact {
  int node = 0;
  int muscle = 0;               ///< the other muscle, an index of the scene's bodies
  int triangle = 0;             ///< the closest triangle of the other muscle, an index of the mesh of all muscles
  Vec3 weights = Vec3::Zero();  ///< barycentric coordinates of the closest point: each >= 0, the sum is 1
  double depth_m = 0;           ///< distance from the node to the closest point, > 0
  Vec3 normal = Vec3::UnitZ();  ///< unit vector in the world frame, from the node to the closest point
};

/// Two muscles that may touch each other: indices of the scene's bodies, the smaller first.
struct MusclePair {
  int first = 0;
  int second = 0;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes the 0 that results are compared with for a pointer.
  friend auto operator<=>(const MusclePair&, const MusclePair&) = default;
};

/// The time of one pair in a detector's last detection, summed over threads. It covers the queries of the nodes of each
/// muscle against the other. Work for all pairs together, such as refitting, is not included.
struct PairTime {
  MusclePair muscles;
  Nanoseconds detect_ns = 0;
};

/// The muscles and pairs for which a detector is made.
struct TouchingMuscles {
  const TriangleMesh& mesh;       ///< of all muscles, at rest, in metres; must outlive the detector
  std::vector<Body> bodies;       ///< the muscles, in the order of their nodes
  std::vector<MusclePair> pairs;  ///< ascending, each pair once
};

/// Finds the nodes of muscles that are inside other muscles, while all muscles deform. The surfaces must be closed; the
/// reader of scenes checks that. Calls come from one thread. A call may use several threads, but the result must not
/// depend on their number.
class MuscleContactDetector {
 public:
  MuscleContactDetector() = default;
  MuscleContactDetector(const MuscleContactDetector&) = delete;
  MuscleContactDetector& operator=(const MuscleContactDetector&) = delete;
  virtual ~MuscleContactDetector() = default;

  /// Finds the contacts of all pairs. `positions` has each node's position in the world frame, in metres. Overwrites
  /// `contacts` with the result, ordered by node and then by the other muscle.
  virtual void detect(std::span<const Vec3> positions, std::vector<MuscleContact>& contacts) = 0;

  /// The times of the last detection, in the order of `TouchingMuscles::pairs`.
  [[nodiscard]] virtual std::span<const PairTime> pair_times() const = 0;

  /// Memory of the detector's structures without the input meshes, counted from sizes.
  [[nodiscard]] virtual std::size_t structure_bytes() const = 0;
};

/// Makes a backend's detector. It may use `threads` threads. Empty if the backend cannot follow deforming surfaces.
using MakeMuscleContactDetector = std::function<std::unique_ptr<MuscleContactDetector>(
    const Parameters& parameters, const TouchingMuscles& muscles, int threads)>;

/// Makes the contact of a node at `point`, given its closest point on another muscle. `corners` are those of
/// `triangle`, in the world frame, in metres. The node must be inside.
MuscleContact muscle_contact_at(int node, int muscle, const Vec3& point, int triangle,
                                const std::array<Vec3, 3>& corners, const ClosestOnTriangle& closest);

/// The indices of all muscles that are in a pair with muscle `index`, ascending.
std::vector<int> muscles_beside(std::span<const MusclePair> pairs, int index);

/// The index in `pairs` of the pair of two muscles, given in either order. The pair must exist.
std::size_t pair_index(std::span<const MusclePair> pairs, int one, int other);

/// A list with a time of 0 for each pair.
std::vector<PairTime> no_times(std::span<const MusclePair> pairs);

}  // namespace musclebench
