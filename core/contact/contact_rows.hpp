#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

class ContactImpulses;

/// A one-sided constraint on up to four nodes, a row of the Jacobian J: n . sum w_i p_i >= offset. Against a bone the
/// weights are barycentric and the plane is the bone's; between two points of muscles those of one point count against
/// those of the other, so that the weights add up to 0 and a correction changes no momentum.
struct ContactRow {
  std::array<int, 4> nodes = {};       ///< all different where weights are not 0
  std::array<double, 4> weights = {};  ///< 0 for one that is not used
  Vec3 normal = Vec3::UnitZ();         ///< n, unit, world frame
  double offset_m = 0;
  Vec3 start_normal = Vec3::UnitZ();  ///< the same plane where the substep began
  double start_offset_m = 0;
  Vec3 carried_m = Vec3::Zero();  ///< how far a bone carries its point of contact in the substep; 0 between muscles
  int steps = 1;                  ///< corrections; the row is left as it is while others go on
  int bone = -1;                  ///< whose plane it is; -1 between muscles
};

/// Corrects contacts of several nodes each. All rows of a step are corrected from the same positions and added, so that
/// their order means nothing. A node that many rows move would then be moved too far; each correction is therefore
/// divided by the sum of the moduli of its row of J M^-1 J^T instead of by the diagonal (l1-Jacobi: Baker, Falgout,
/// Kolev and Yang 2011, "Multigrid smoothers for ultraparallel computing"). For a single row the two are the same; rows
/// of one gap and normal all around are solved at once; and the steps converge for any set of rows. A step moves no
/// node by more than twice the largest gap of its rows: a face of which bones hold all but a corner is not thrown, and
/// takes more steps.
///
/// What violated a row already when the substep began is corrected in the substep's start, too, and so gives no
/// velocity (pre-stabilisation: Macklin et al. 2014, "Unified particle physics for real-time applications").
///
/// Friction undoes what a row's points have slid on each other in the substep, as far as the row's own impulse allows
/// (`share_undone_by_friction`), by inverse mass on both sides, so that between muscles it changes no momentum.
class ContactRowSolver {
 public:
  /// `inverse_masses` of all nodes, 1/kg. `friction_coefficient`: see ContactProperties.
  explicit ContactRowSolver(std::vector<double> inverse_masses, double friction_coefficient = 0);

  /// Before `solve`: lowers the offsets of rows that began deeper than `most_m`, so that they are corrected by no more.
  /// Only of nodes that were in such rows in the first call, and have been in all calls since: those that overlap as
  /// the run begins. What came in later has a speed, which is to be taken away whole.
  void lay_out_slowly(std::span<ContactRow> rows, std::span<const Vec3> start, std::span<const Vec3> predicted,
                      double most_m);

  /// Corrects `predicted` (p) and `start` (x), both of all nodes, world frame, m. Ends early once no row is violated.
  /// Adds what it does to nodes to `impulses`, where given.
  void solve(std::span<const ContactRow> rows, std::span<Vec3> start, std::span<Vec3> predicted,
             ContactImpulses* impulses = nullptr);

  /// The nodes that the last `solve` may have moved, ascending.
  [[nodiscard]] std::span<const int> moved_nodes() const { return m_moved; }
  /// How many rows the step of the last `solve` that had most of them corrected.
  [[nodiscard]] int most_corrected() const { return m_most_corrected; }

 private:
  /// What the rows of a node weigh on it.
  struct Load {
    double weights = 0;  ///< sum of the moduli
    int rows = 0;
  };

  void collect_moved(std::span<const ContactRow> rows);
  [[nodiscard]] double row_sum(const ContactRow& row) const;
  void add_to_all(const ContactRow& row, const Vec3& change, std::vector<Vec3>& corrections) const;
  void correct_all(std::span<const ContactRow> rows, std::span<Vec3> start, std::span<Vec3> predicted);
  void rub(std::span<const ContactRow> rows, std::span<const Vec3> start, std::span<Vec3> predicted);
  void tell(std::span<const ContactRow> rows, ContactImpulses& impulses) const;
  void add_load(const ContactRow& row);
  void clear_loads();
  [[nodiscard]] bool overlapped_before(const ContactRow& row) const;
  bool correct(const ContactRow& row, std::span<const Vec3> start, std::span<const Vec3> predicted, double& multiplier);

  std::vector<double> m_inverse_masses;
  double m_friction_coefficient;
  // By node, zero but for m_moved.
  std::vector<Load> m_loads;
  std::vector<Vec3> m_corrections;
  std::vector<Vec3> m_start_corrections;
  std::vector<int> m_moved;
  bool m_is_first_call = true;
  std::vector<char> m_overlaps;     ///< by node: since the run began; empty once there are none
  std::vector<char> m_overlap_now;  ///< the same of this call alone
  int m_most_corrected = 0;
  // By row: the sum of its corrections over its row sum, without what was there before; what friction has undone.
  std::vector<double> m_multipliers;
  std::vector<Vec3> m_undone_m;
};

}  // namespace musclebench
