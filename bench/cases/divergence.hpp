#pragma once

#include <span>
#include <string>

#include "core/scene/scene.hpp"

namespace musclebench {

/// Tells when a run has blown up: a node is farther from where it started than ten diagonals of the scene.
class Divergence {
 public:
  /// `scene` outlives it.
  explicit Divergence(const Scene& scene);

  /// Which node is lost, in words; empty when all is well. A position that is no number counts as lost.
  [[nodiscard]] std::string describe(int frame, std::span<const Vec3> positions) const;

 private:
  const Scene& m_scene;
  double m_range_m;
};

}  // namespace musclebench
