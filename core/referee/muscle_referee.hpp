#pragma once

#include <span>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/body.hpp"
#include "core/referee/referee.hpp"
#include "core/referee/referee_tree.hpp"

namespace musclebench {

/// Muscles of which each is judged against others.
struct JudgedMuscles {
  std::vector<Body> bodies;
  std::vector<std::vector<int>> beside;  ///< by body: muscles that its nodes are tested against, ascending
};

/// The ground truth between muscles: which nodes of one lie inside another, and how deep, by the Referee's own trees
/// (RefereeTree), refitted to the muscles as they are, and by exact winding numbers. It shares no code with the
/// detectors.
class MuscleReferee {
 public:
  /// `mesh` of all muscles, closed, at rest. Throws InputError that names a muscle without triangles.
  MuscleReferee(const TriangleMesh& mesh, JudgedMuscles muscles);

  /// Finds all nodes that lie inside a muscle beside theirs at `positions` (of all nodes, world frame, m) and not
  /// closer to its surface than `touching_distance_m`, into `truth`, which is overwritten: ordered by node, then by the
  /// other muscle, whose index stands in `Contact::bone`.
  void judge(std::span<const Vec3> positions, std::vector<Contact>& truth);

  /// Of a point (world frame, m) and a muscle as it was at the last call of `judge`; the closest point and the normal
  /// in the world frame, too.
  [[nodiscard]] SurfaceDistance distance(int muscle, const Vec3& point_m) const;

  /// Muscles that the nodes of this one are tested against, ascending.
  [[nodiscard]] std::span<const int> beside(std::size_t muscle) const { return m_muscles.beside[muscle]; }

  /// The tree over a muscle, as it was then; world frame, relative to its centre_m().
  [[nodiscard]] const RefereeTree& tree(int muscle) const { return m_surfaces[static_cast<std::size_t>(muscle)].tree; }

  /// Of the last call, in the unit of RefereeTree.
  [[nodiscard]] long last_work() const { return m_work; }

 private:
  struct Surface {
    std::vector<Triangle> triangles;  ///< nodes counted from the body's first
    RefereeTree tree;
    double touching_m;
  };

  JudgedMuscles m_muscles;
  std::vector<Surface> m_surfaces;  ///< by body
  long m_work = 0;
};

}  // namespace musclebench
