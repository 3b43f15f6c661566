#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/contact/contact_rows.hpp"
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
/// its inverse mass and its weight (ContactRowSolver; the point-triangle constraint of Mueller et al. 2007, "Position
/// based dynamics", sections 3.4 and 4.3). Muscles that overlap at rest separate without being accelerated.
class MuscleContactResponse {
 public:
  /// `triangles` of the mesh of all muscles, which outlive this; `inverse_masses` of all nodes, 1/kg. `steps`:
  /// corrections of the contacts of one detection, each of the depth that the ones before have left.
  MuscleContactResponse(std::span<const Triangle> triangles, std::vector<double> inverse_masses, PairSteps steps);

  /// Coulomb friction, >= 0: of what a contact's two points slide on each other in a substep, the part up to the
  /// coefficient times their push apart is undone (Macklin et al. 2014, "Unified particle physics for real-time
  /// applications"), by inverse mass on both sides, so that it changes no momentum.
  void set_friction(double coefficient) { m_friction = coefficient; }

  /// Corrects `predicted` (p) and `start` (x), both of all nodes. `depenetration_m`: see ContactRowSolver.
  void resolve(std::span<const MuscleContact> contacts, std::span<Vec3> start, std::span<Vec3> predicted,
               double depenetration_m = std::numeric_limits<double>::infinity());

  /// The nodes that the last `resolve` may have moved, ascending.
  [[nodiscard]] std::span<const int> moved_nodes() const { return m_solver.moved_nodes(); }

 private:
  void find_approaches(std::span<const Vec3> start, std::span<const Vec3> predicted);
  void rub(std::span<const Vec3> start, std::span<Vec3> predicted);

  std::span<const Triangle> m_triangles;
  PairSteps m_steps;
  ContactRowSolver m_solver;
  double m_friction = 0;
  std::vector<ContactRow> m_rows;
  // Of friction.
  std::vector<double> m_approaches_m;  ///< along each row's normal since the substep began, before the correction
  std::vector<Vec3> m_slides;          ///< by row
};

}  // namespace musclebench
