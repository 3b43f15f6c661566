#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The particles (nodes) of a muscle at the start of a simulation, one for each vertex of its surface. They are in the
/// world frame. All three vectors must have the same size.
struct Particles {
  std::vector<Vec3> positions;         ///< m
  std::vector<Vec3> velocities;        ///< m/s
  std::vector<double> inverse_masses;  ///< 1/kg; 0 for a node that is attached to a bone

  [[nodiscard]] std::size_t size() const { return positions.size(); }
};

}  // namespace musclebench
