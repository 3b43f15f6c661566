#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "core/fibres/volume_potential.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench::test {

/// A bar along x from 0 to `length_m`, of square section; a map of its points bends it.
struct Bar {
  TriangleMesh mesh;
  std::vector<int> start_nodes;  ///< of the end x = 0
  std::vector<int> end_nodes;
  double length_m = 0;
};

inline Bar make_bar(double length_m, double half_width_m, int cells_per_edge) {
  Bar bar{make_box(Vec3(length_m / 2, half_width_m, half_width_m), cells_per_edge), {}, {}, length_m};
  for (Vec3& vertex : bar.mesh.vertices) vertex.x() += length_m / 2;
  for (std::size_t i = 0; i < bar.mesh.vertices.size(); ++i) {
    const double x = bar.mesh.vertices[i].x();
    if (x < 1e-9 * length_m) bar.start_nodes.push_back(static_cast<int>(i));
    if (x > (1 - 1e-9) * length_m) bar.end_nodes.push_back(static_cast<int>(i));
  }
  return bar;
}

/// Bends the bar about the z axis: x becomes the angle, from 0 to `angle_rad`, y the distance from `radius_m`.
inline std::vector<Vec3> bent(const Bar& bar, double radius_m, double angle_rad) {
  std::vector<Vec3> bent;
  for (const Vec3& vertex : bar.mesh.vertices) {
    const double angle = angle_rad * vertex.x() / bar.length_m;
    const double radius = radius_m + vertex.y();
    bent.emplace_back(radius * std::cos(angle), radius * std::sin(angle), vertex.z());
  }
  return bent;
}

/// That keeps the winding outwards.
inline Bar bent_bar(Bar bar, double radius_m, double angle_rad) {
  bar.mesh.vertices = bent(bar, radius_m, angle_rad);
  for (auto& [a, b, c] : bar.mesh.triangles) std::swap(b, c);
  return bar;
}

inline SignedSurface surface_of(const TriangleMesh& mesh) { return SignedSurface(RepairedMesh{mesh, false, {}}); }

}  // namespace musclebench::test
