#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

// Constraints by the formulas of PBDlib (Bender et al.), which are those of Mueller et al. 2007: what another program
// would take for the same constraints in the same order. Nodes share an array of positions and one of inverse masses.
namespace musclebench::published {

struct Length {
  std::array<int, 2> nodes;
  double rest_length_m;
};

/// Section 3.3.
inline void project(const Length& constraint, double stiffness, Vec3* x, const double* inverse_masses) {
  const auto [a, b] = constraint.nodes;
  const double weights = inverse_masses[a] + inverse_masses[b];
  if (weights == 0) return;
  Vec3 direction = x[b] - x[a];
  const double length_m = direction.norm();
  direction.normalize();
  const Vec3 correction = stiffness * direction * ((length_m - constraint.rest_length_m) / weights);
  x[a] += inverse_masses[a] * correction;
  x[b] -= inverse_masses[b] * correction;
}

struct Angle {
  std::array<int, 4> nodes;  ///< the two wings, the two ends of the edge
  double rest_angle_rad;
};

/// Appendix A in the form of Bridson et al. 2003: gradients by heights, the angle by an arc cosine.
inline void project(const Angle& constraint, double stiffness, Vec3* x, const double* inverse_masses) {
  const auto [left, right, start, end] = constraint.nodes;
  const Vec3 edge = x[end] - x[start];
  const double edge_m = edge.norm();
  if (edge_m < 1e-6) return;
  const double per_edge = 1 / edge_m;
  Vec3 left_normal = (x[start] - x[left]).cross(x[end] - x[left]);
  left_normal /= left_normal.squaredNorm();
  Vec3 right_normal = (x[end] - x[right]).cross(x[start] - x[right]);
  right_normal /= right_normal.squaredNorm();
  const std::array<Vec3, 4> gradients = {
      edge_m * left_normal, edge_m * right_normal,
      (x[left] - x[end]).dot(edge) * per_edge * left_normal + (x[right] - x[end]).dot(edge) * per_edge * right_normal,
      (x[start] - x[left]).dot(edge) * per_edge * left_normal +
          (x[start] - x[right]).dot(edge) * per_edge * right_normal};
  left_normal.normalize();
  right_normal.normalize();
  const double angle_rad = std::acos(std::clamp(left_normal.dot(right_normal), -1.0, 1.0));
  double weights = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    weights += inverse_masses[constraint.nodes[i]] * gradients[i].squaredNorm();
  }
  if (weights == 0) return;
  double multiplier = stiffness * (angle_rad - constraint.rest_angle_rad) / weights;
  if (left_normal.cross(right_normal).dot(edge) > 0) multiplier = -multiplier;
  for (std::size_t i = 0; i < 4; ++i) {
    x[constraint.nodes[i]] -= inverse_masses[constraint.nodes[i]] * multiplier * gradients[i];
  }
}

}  // namespace musclebench::published
