#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The nodes of a muscle: one a vertex of its surface, all vectors of the same length, world frame.
struct Particles {
  std::vector<Vec3> positions;         ///< x: at the start of the substep, m
  std::vector<Vec3> predicted;         ///< p: what constraints and collisions correct, m
  std::vector<Vec3> velocities;        ///< m/s
  std::vector<double> inverse_masses;  ///< 1/kg; 0 for a node that a bone carries

  [[nodiscard]] std::size_t size() const { return positions.size(); }
};

}  // namespace musclebench
