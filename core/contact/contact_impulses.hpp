#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/body.hpp"

namespace musclebench {

/// What the contacts of a frame did to the nodes of muscles: sums of impulses (N s, world frame) by collider and node.
/// A collider is a bone, a muscle, or `unknown` for what no contact tells the collider of. Bones come first, then
/// muscles; a node's own muscle is contact of the muscle with itself.
///
/// A correction of a node by d metres in a substep of h seconds changes its velocity by d / h. Its impulse is m d / h,
/// with the node's mass m.
class ContactImpulses {
 public:
  /// `inverse_masses` by node, 1/kg. A node of inverse mass 0 is moved by nothing: what a contact does to it is passed
  /// on to the bone that carries it.
  ContactImpulses(std::vector<Body> muscles, std::size_t bones, std::span<const double> inverse_masses);

  [[nodiscard]] std::size_t colliders() const { return m_bones + m_muscles.size() + 1; }
  [[nodiscard]] std::size_t of_muscle(std::size_t muscle) const { return m_bones + muscle; }
  [[nodiscard]] std::size_t unknown() const { return colliders() - 1; }

  /// Forgets all impulses.
  void clear();
  /// Duration of the substep that the next ones are of.
  void set_time_step(double time_step_s) { m_per_time_step = 1 / time_step_s; }

  /// Adds mass times correction, kg m, and the part of it that pushes along the contact's normal.
  void add(int node, std::size_t collider, const Vec3& moved_kg_m, const Vec3& pushed_kg_m);
  /// The collider of corner `k` of a contact between muscles, or with `bone` (-1: none). Corners on the two sides have
  /// weights of opposite signs.
  [[nodiscard]] std::size_t other_side(int bone, const std::array<int, 4>& nodes, const std::array<double, 4>& weights,
                                       std::size_t k) const;
  /// Adds mass times correction of a node that moved out of several bones at once. It is divided into pushes along the
  /// normals of `contacts` (all of the node), which fit it best by least squares, and what is left, which is friction,
  /// by their pushes. Of a node in more than eight bones nothing is added: it is of unknown colliders.
  void add_to_bones(int node, const Vec3& moved_kg_m, std::span<const Contact> contacts);

  /// Inverse of the mass of a node, 1/kg.
  [[nodiscard]] double inverse_mass(int node) const { return m_inverse_masses[static_cast<std::size_t>(node)]; }
  /// What was added for the node, of all colliders, kg m / s.
  [[nodiscard]] const Vec3& known(int node) const { return m_known[static_cast<std::size_t>(node)]; }
  /// The sum of impulses on a node, N s.
  [[nodiscard]] const Vec3& at(std::size_t collider, int node) const {
    return m_impulses[collider * m_known.size() + static_cast<std::size_t>(node)];
  }
  /// The sum of those parts that pushed along normals, N s. The rest is friction.
  [[nodiscard]] const Vec3& push_at(std::size_t collider, int node) const {
    return m_pushes[collider * m_known.size() + static_cast<std::size_t>(node)];
  }

 private:
  std::vector<Body> m_muscles;
  std::size_t m_bones;
  std::vector<double> m_inverse_masses;
  double m_per_time_step = 0;
  std::vector<Vec3> m_known;  ///< by node
  // By collider, then node.
  std::vector<Vec3> m_impulses;
  std::vector<Vec3> m_pushes;
};

}  // namespace musclebench
