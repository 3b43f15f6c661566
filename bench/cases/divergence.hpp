#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/pbd/simulation.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Tells when a run has blown up: a node is farther from where it started than ten diagonals of the scene.
class Divergence {
 public:
  /// `scene` outlives it.
  explicit Divergence(const Scene& scene);

  /// Which node is lost, in words; empty when all is well. A position that is no number counts as lost.
  [[nodiscard]] std::string describe(int frame, std::span<const Vec3> positions) const;

  /// What moved the node lost in `frame` out of the scene, in words: steps `simulation`, which is at its start, there
  /// again. Empty where it is not lost in that frame. `observe_last` sees the collision steps of the up to
  /// `kept_frames` frames before it.
  [[nodiscard]] std::string cause(Simulation& simulation, int frame, std::span<const std::string> effect_names,
                                  CollisionObserver& observe_last) const;
  static constexpr int kept_frames = 3;

 private:
  /// The first node that is.
  [[nodiscard]] std::optional<std::size_t> lost_node(std::span<const Vec3> positions) const;
  [[nodiscard]] bool is_lost(std::size_t node, const Vec3& position) const;

  const Scene& m_scene;
  double m_range_m;
};

}  // namespace musclebench
