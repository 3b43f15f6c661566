#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/constraints/constraint_lanes.hpp"
#include "core/mesh/body.hpp"

namespace musclebench {

/// A triangle's fibres. Their stretch is the length of `per_m[0] x_0 + per_m[1] x_1 + per_m[2] x_2`: the gradients of
/// the triangle's barycentric coordinates along the fibres, at rest, so that it is 1 there.
struct FibreConstraint {
  std::array<int, 3> nodes;
  std::array<double, 3> per_m;
  double volume_m3;  ///< of muscle whose fibres these are
};

/// How a muscle's fibres pull (Hill 1938). The curves and their constants are those of Thelen 2003, "Adjustment of
/// muscle mechanics model parameters to simulate dynamic contractions in older adults", for young adults:
/// - active force over length is a Gaussian of width 0.45;
/// - passive force over length is (e^(5 strain / `passive_strain`) - 1) / (e^5 - 1); beyond that strain, its tangent;
/// - active force over speed is Hill's hyperbola with 0.25, and at most 1.4 where fibres are stretched. At activation a
///   the fastest speed is 0.25 + 0.75 a of that of fully active fibres.
struct FibreLaw {
  double peak_stress_pa = 3e5;  ///< of fully active fibres at their optimal length; of the section at rest
  double optimal_stretch = 1;   ///< of fibres at their optimal length
  double passive_strain = 0.6;  ///< beyond the optimal length, at which passive fibres bear `peak_stress_pa`
  double fastest_per_s = 10;    ///< optimal lengths a second at which active fibres bear nothing; 0: no such speed

  // Parts of the peak stress, of fully active fibres.
  [[nodiscard]] double active_at(double stretch) const;
  /// `speed`: over the fastest, above 0 where fibres are stretched. At most `most_over_speed`.
  [[nodiscard]] static double active_over_speed(double speed);
  static constexpr double most_over_speed = 1.4;
};

struct FibreSlots;

/// Fibres of muscles' surfaces that pull, and never push.
///
/// The active fibres of a muscle bear one stress, by their mean stretch, weighted by volume, and its rate. In the first
/// projection of a substep each node moves along the gradient, at the start of the substep, of volume times stretch. So
/// pulls are balanced along the surface. The stress is solved together with the change of speed that it makes.
///
/// What a triangle's fibres bear by their own stretch is projected in SIMD lanes, as XPBD (Macklin et al. 2016) for a
/// stiffness in place of a compliance, which may be 0:
/// - Passive fibres store energy, the volume times the integral of the nominal stress over the stretch. In a substep
///   that stress is linear in the stretch at its end, with value and slope as at its start.
/// - Active fibres longer than the mean bear more, and shorter ones less, in proportion: they resist quick changes
///   (their short-range stiffness: Cui and others 2008). Else some parts of a fibre would run together and others
///   apart, since nothing decides between them.
class FibreConstraints {
 public:
  /// Nodes of a constraint are all of one of `bodies`.
  FibreConstraints(std::span<const FibreConstraint> constraints, std::span<const Body> bodies, const NodeOrder& order,
                   const FibreLaw& law);

  // Every thread of the team makes these calls, and waits for the others between them.

  /// `rows`: where nodes are at the start of the substep; `activation`: 0 to 1.
  void begin_substep(const NodeRows& rows, double activation, double time_step_s, const Team& team);
  void project(NodeRows& rows, double time_step_s, const Team& team);

  // One thread makes these.

  void forget_pulls();
  /// By body, what its fibres pulled since `forget_pulls`: their volume times nominal stress times duration, N m s.
  /// Divided by the mean length of what no bone carries of them and by the duration, the mean force along all fibres.
  [[nodiscard]] std::vector<double> pulls_n_m_s() const;

 private:
  /// All fibres of a body.
  struct Muscle {
    std::size_t first_row, last_row;
    double activation_share = 1;  ///< as that of the body
    double volume_m3 = 0;
    double stretch = 1;       ///< mean at the start of the substep
    double last_stretch = 1;  ///< of the substep before
    double rate_per_s = 0;    ///< of the mean stretch, in the last substep
    double stress_pa = 0;     ///< active, of the substep
    double last_pa_s = 0;     ///< active stress of the last substep times its time step
    double active_n_m_s = 0;  ///< since `forget_pulls`
  };

  /// Over the active stress, by stretch beyond the mean. From 10 to 23 a muscle's moment arms differ by 0.2 mm.
  static constexpr double short_range_stiffness = 10;

  [[nodiscard]] FibreSlots slots(NodeRow* impulses);
  void find_stretches(double time_step_s);
  [[nodiscard]] double stress_pa(const Muscle& muscle, const NodeRows& rows, double time_step_s) const;
  void pull(NodeRows& rows, double time_step_s, const Team& team);

  ConstraintOrder<3> m_order;
  FibreLaw m_law;
  double m_activation = 0;
  std::array<std::vector<double>, 3> m_per_m;
  std::vector<double> m_volume_m3;
  std::vector<std::size_t> m_muscle_of_slot;
  std::vector<double> m_stretch;  ///< at the start of the substep
  // Of the substep, times its squared time step.
  std::vector<double> m_pull, m_slope;  ///< at stretch 0, and by stretch
  std::vector<double> m_multipliers;
  std::vector<double> m_most;        ///< of a multiplier: it takes away what all active fibres pull, and no more
  std::vector<double> m_sum;         ///< of the multipliers over their time steps, with the sign of a pull
  std::vector<Muscle> m_muscles;     ///< by body
  std::vector<NodeRow> m_gradients;  ///< by row, of the sum of volume times stretch, m2
  double m_last_time_step_s = 0;     ///< 0: no substep yet
  bool m_begins = false;             ///< the substep has had no projection
};

}  // namespace musclebench
