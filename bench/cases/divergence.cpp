#include "bench/cases/divergence.hpp"

#include <vector>

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
  const std::optional<std::size_t> node = lost_node(positions);
  if (!node) return "";
  return fmt::format("frame {}: node {} left the scene by more than {:.3g} m", frame, *node, m_range_m);
}

std::string Divergence::cause(Simulation& simulation, int frame, std::span<const std::string> effect_names,
                              CollisionObserver& observe_last) const {
  for (int earlier = 1; earlier < frame; ++earlier) {
    simulation.step_frame(earlier, earlier >= frame - kept_frames ? &observe_last : nullptr);
  }
  std::vector<std::string> told;  // of each node, the first time that it is lost
  told.resize(m_scene.muscle_mesh.vertices.size());
  int iteration = 0;
  simulation.watch_movers([&](int mover) {
    for (std::size_t node = 0; node < told.size(); ++node) {
      if (!told[node].empty() || !is_lost(node, simulation.predicted(static_cast<int>(node)))) continue;
      const std::string words = mover == moved_by_velocity   ? "its own velocity"
                                : mover == moved_by_contacts ? "contacts"
                                                             : effect_names[static_cast<std::size_t>(mover)];
      told[node] = fmt::format("{} in substep {} of the frame", words, iteration / m_scene.loop.iterations + 1);
    }
    if (mover == moved_by_contacts) ++iteration;
  });
  simulation.step_frame(frame);
  simulation.watch_movers({});
  const std::optional<std::size_t> node = lost_node(simulation.positions());
  return node ? told[*node] : "";
}

std::optional<std::size_t> Divergence::lost_node(std::span<const Vec3> positions) const {
  for (std::size_t node = 0; node < positions.size(); ++node) {
    if (is_lost(node, positions[node])) return node;
  }
  return std::nullopt;
}

bool Divergence::is_lost(std::size_t node, const Vec3& position) const {
  return !((position - m_scene.muscle_mesh.vertices[node]).norm() <= m_range_m);  // so that NaN counts as lost
}

}  // namespace musclebench
