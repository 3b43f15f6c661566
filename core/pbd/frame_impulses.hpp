#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/contact_impulses.hpp"
#include "core/pbd/effect.hpp"

namespace musclebench {

/// The impulses on all nodes in a frame (N s, world frame): of each effect, and of contacts by collider. Divided by the
/// duration of the frame they are its mean forces. For a node that no bone carries, those of all effects and of all
/// contacts add up to its mass times its change of velocity, to rounding.
///
/// The Simulation fills it in. A force changes velocities: mass times the change. A constraint corrects positions: its
/// multiplier times its gradient, over the time step. For compliant constraints (XPBD: Macklin, Mueller and Chentanez
/// 2016, section 4) this is the force of the spring that they stand for; for hard ones it is what holds them.
class FrameImpulses {
 public:
  FrameImpulses(std::vector<Body> muscles, std::size_t bones, const NodeOrder& order,
                std::span<const double> inverse_masses, std::size_t effects);

  /// Simulated duration of what was recorded, s.
  [[nodiscard]] double duration_s() const { return m_duration_s; }
  /// Of an effect on a node. Constraints act on nodes that bones carry, too; their bones bear it.
  [[nodiscard]] Vec3 of_effect(std::size_t effect, int node) const {
    return m_of_effects[effect][static_cast<std::size_t>(m_order.row_of(node))].position() / m_time_step_s;
  }
  /// Of all contacts on a node.
  [[nodiscard]] const Vec3& of_contacts(int node) const { return m_contact_sum[static_cast<std::size_t>(node)]; }
  /// The same by collider.
  [[nodiscard]] const ContactImpulses& by_collider() const { return m_by_collider; }

  // For the Simulation.

  /// All substeps of a frame have the same time step.
  void begin_frame(double time_step_s);
  void begin_substep() { m_duration_s += m_time_step_s; }
  void end_frame();
  /// Where an effect adds mass times correction, by row, as in NodeRows.
  [[nodiscard]] NodeRow* rows_of(std::size_t effect) { return m_of_effects[effect].data(); }
  /// Room for velocities before a force, by row.
  [[nodiscard]] std::vector<NodeRow>& velocities_before() { return m_velocities_before; }

  /// What moves nodes from here on is contact. `start` and `predicted` as in ContactStageInput.
  void begin_contacts(std::span<const Vec3> start, std::span<const Vec3> predicted);
  /// Adds what has moved since `begin_contacts`. Of this, what no row has told is said to be of the
  /// bones that `contacts` (ordered by bone, then node) name.
  void add_contacts(std::span<const Vec3> start, std::span<const Vec3> predicted, std::span<const Contact> contacts);
  [[nodiscard]] ContactImpulses* contacts() { return &m_by_collider; }

 private:
  ContactImpulses m_by_collider;
  NodeOrder m_order;
  std::vector<std::vector<NodeRow>> m_of_effects;  ///< by effect, then row: mass times correction, kg m
  double m_duration_s = 0;
  double m_time_step_s = 1;
  std::vector<NodeRow> m_velocities_before;
  // By node.
  std::vector<Vec3> m_contact_sum;
  std::vector<double> m_contact_size;  ///< sum of the sizes of what was added to it
  std::vector<Vec3> m_moved_m;         ///< p - x as contacts began
  std::vector<Vec3> m_known;           ///< ContactImpulses::known then
  std::vector<std::vector<Contact>> m_contacts;
};

}  // namespace musclebench
