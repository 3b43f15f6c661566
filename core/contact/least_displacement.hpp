#pragma once

#include <array>
#include <cstddef>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// All displacements d with normal . d >= depth_m.
struct HalfSpace {
  Vec3 normal;     ///< unit
  double depth_m;  ///< how far the point is from it, along the normal; <= 0 for one that holds the point
};

/// A few half spaces; what does not fit replaces the shallowest.
class HalfSpaces {
 public:
  static constexpr std::size_t most = 8;

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

/// The shortest displacement into all half spaces, short of it by at most 1e-9 of the largest depth. Where they have
/// nothing in common, as between two bones that close on a node, it is the one of the least sum of squared depths that
/// are left. The same bits whatever their order.
///
/// Solves min d.d / 2 + sum max(0, depth - normal . d)^2 / (2 e), e = 1e-9, in its dual variables, which are the
/// lengths along the normals, all >= 0, by the active-set method of Lawson and Hanson (Solving Least Squares Problems,
/// 1974, chapter 23).
Vec3 least_displacement(HalfSpaces half_spaces);

}  // namespace musclebench
