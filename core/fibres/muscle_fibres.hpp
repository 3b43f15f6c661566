#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/fibres/fibre_paths.hpp"

namespace musclebench {

/// Fibres of one muscle that follow its surface: their ends as points of the triangles that they lie on, the points in
/// between by mean value coordinates. They are watched, and have no part in the simulation.
class MuscleFibres {
 public:
  /// `muscle` at rest. Throws InputError (location: `name`, that of the muscle) where a path lies where the surface has
  /// no coordinates.
  MuscleFibres(const TriangleMesh& muscle, const FibrePaths& paths, const std::string& name, int threads);

  [[nodiscard]] std::size_t count() const { return m_count; }
  [[nodiscard]] std::size_t points_per_fibre() const { return m_points_per_fibre; }

  /// Fibre after fibre, each from the origin to the insertion, given the positions of the muscle's nodes, m.
  [[nodiscard]] std::vector<Vec3> points(std::span<const Vec3> nodes) const;

  /// Of each fibre, m, given its points.
  [[nodiscard]] std::vector<double> lengths(std::span<const Vec3> points) const;

  [[nodiscard]] std::size_t bytes() const;

 private:
  /// A point of a triangle.
  struct EndPoint {
    Triangle nodes{};
    Vec3 weights = Vec3::Zero();
  };

  std::size_t m_count = 0;
  std::size_t m_points_per_fibre = 0;
  std::size_t m_nodes = 0;
  std::vector<EndPoint> m_ends;   // two a fibre
  std::vector<double> m_weights;  // of all nodes, a row for each point between ends
  int m_threads;
};

}  // namespace musclebench
