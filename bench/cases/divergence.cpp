#include "bench/cases/divergence.hpp"

#include <fmt/format.h>

#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

/// Positions farther than this many scene diagonals from the start count as blown up.
constexpr double divergence_diagonals = 10;

}  // namespace

Divergence::Divergence(const Scene& scene)
    : m_scene(scene), m_range_m(divergence_diagonals * scene_diagonal_m(scene)) {}

std::string Divergence::describe(int frame, std::span<const Vec3> positions) const {
  const std::vector<Vec3>& rest = m_scene.muscle_mesh.vertices;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!((positions[i] - rest[i]).norm() <= m_range_m)) {  // so that NaN counts as lost
      return fmt::format("frame {}: node {} left the scene by more than {:.3g} m", frame, i, m_range_m);
    }
  }
  return "";
}

}  // namespace musclebench
