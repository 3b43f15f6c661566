#pragma once

#include <array>
#include <cstddef>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The half space of displacements d (metres) with normal . d >= depth_m.
struct HalfSpace {
  Vec3 normal;     ///< unit vector
  double depth_m;  ///< distance to the half space along the normal; <= 0 if the point is in it already
};

/// A list of up to 8 half spaces. It allocates no memory.
class HalfSpaces {
 public:
  static constexpr std::size_t most = 8;

  /// Appends a half space. In a full list it replaces the one with the smallest depth, if it is deeper.
  void add(const HalfSpace& half_space);
  void clear() { m_count = 0; }
  [[nodiscard]] std::size_t size() const { return m_count; }
  [[nodiscard]] const HalfSpace* begin() const { return m_half_spaces.data(); }
  [[nodiscard]] const HalfSpace* end() const { return m_half_spaces.data() + m_count; }
  [[nodiscard]] HalfSpace* begin() { return m_half_spaces.data(); }
  [[nodiscard]] HalfSpace* end() { return m_half_spaces.data() + m_count; }
  [[nodiscard]] const HalfSpace& operator[](std::size_t i) const { return m_half_spaces[i]; }

 private:
  std::array<HalfSpace, most> m_half_spaces;
  std::size_t m_count = 0;
};

/// The shortest displacement (metres) into all half spaces. It falls short by at most 1e-9 of the largest depth. The
/// half spaces may not intersect, as between two bones that close on a node. Then the sum of the squared remaining
/// depths is smallest. The bits do not depend on the order of the half spaces. Safe from several threads.
///
/// It solves min d.d / 2 + sum max(0, depth - normal . d)^2 / (2 e) with e = 1e-9. The unknowns are the dual variables,
/// which are lengths along the normals, all >= 0. The method is the active-set method of Lawson and Hanson (Solving
/// Least Squares Problems, 1974, chapter 23).
Vec3 least_displacement(HalfSpaces half_spaces);

}  // namespace musclebench
