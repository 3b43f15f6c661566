#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// How often the contacts of a detection are corrected. A pair whose steps are done is left as it is while others go
/// on.
struct PairSteps {
  int most = 1;  ///< >= 1; of all pairs that are not told below
  std::vector<Body> bodies = {};
  std::vector<MusclePair> pairs = {};
  std::vector<int> of_pairs = {};  ///< >= 1; empty: `most` for all

  PairSteps(int steps) : most(steps) {}  // NOLINT(google-explicit-constructor)
  PairSteps(std::vector<Body> muscles, std::vector<MusclePair> touching, std::vector<int> steps);

  [[nodiscard]] int of(const MuscleContact& contact) const;
};

/// Moves nodes out of other muscles. A contact between a node p and the closest point q = sum b_i q_i of a triangle is
/// the constraint n . (p - q) >= 0; the node moves along the normal n and the triangle's corners against it, each by
/// its inverse mass and its weight, so that a correction changes no momentum.
///
/// All contacts are corrected from the same positions and added, so that their order means nothing. A node that many
/// contacts move would then be moved too far; each correction is therefore divided by the sum of the moduli of its row
/// of J M^-1 J^T instead of by the diagonal (l1-Jacobi: Baker, Falgout, Kolev and Yang 2011, "Multigrid smoothers for
/// ultraparallel computing"). For a single contact the two are the same; contacts of one depth and normal all
/// around are solved at once; and the steps converge for any set of contacts.
///
/// Depth that was there already when the substep began is corrected in the substep's start, too, and so gives no
/// velocity (pre-stabilisation: Macklin et al. 2014, "Unified particle physics for real-time applications"): muscles
/// that overlap at rest separate without being accelerated.
class MuscleContactResponse {
 public:
  /// `triangles` of the mesh of all muscles, which outlive this; `inverse_masses` of all nodes, 1/kg. `steps`:
  /// corrections of the contacts of one detection, each of the depth that the ones before have left.
  MuscleContactResponse(std::span<const Triangle> triangles, std::vector<double> inverse_masses, PairSteps steps);

  /// Corrects `predicted` (p) and `start` (x), both of all nodes.
  void resolve(std::span<const MuscleContact> contacts, std::span<Vec3> start, std::span<Vec3> predicted);

  /// The nodes that the last `resolve` may have moved, ascending.
  [[nodiscard]] std::span<const int> moved_nodes() const { return m_moved; }

 private:
  /// One of the four nodes of a contact, with its entry of the contact's row of the Jacobian J, along the normal.
  struct Arm {
    std::size_t node;
    double weight;
  };
  [[nodiscard]] std::array<Arm, 4> arms_of(const MuscleContact& contact) const;
  void collect_moved(std::span<const MuscleContact> contacts);

  std::span<const Triangle> m_triangles;
  std::vector<double> m_inverse_masses;
  PairSteps m_steps;
  std::vector<int> m_steps_of_contacts;
  // By node, zero but for m_moved.
  std::vector<double> m_loads;  ///< sum of the moduli of the weights of all its contacts
  std::vector<Vec3> m_corrections;
  std::vector<Vec3> m_start_corrections;
  std::vector<int> m_moved;
};

}  // namespace musclebench
