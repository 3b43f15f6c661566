#include "bench/cases/divergence.hpp"

#include <vector>

#include <fmt/format.h>

namespace musclebench {

std::string describe_divergence(const Simulation& simulation, int frame) {
  const std::optional<int> node = simulation.lost().first();
  if (!node) return "";
  const MotionLimits& limits = simulation.lost().limits();
  const std::string lost = simulation.lost().is_out_of_range(*node, simulation.predicted(*node))
                               ? fmt::format("left the scene by more than {:.3g} m", limits.range_m)
                               : fmt::format("moves more than {:.3g} m a substep", limits.move_m);
  return fmt::format("frame {}, substep {}: node {} {}", frame, simulation.substep(), *node, lost);
}

std::string cause_of_divergence(Simulation& simulation, int frame, CollisionObserver& observe_last) {
  for (int earlier = 1; earlier < frame; ++earlier) {
    simulation.step_frame(earlier, earlier >= frame - frames_kept_before_divergence ? &observe_last : nullptr);
    if (simulation.was_stopped()) return "";
  }
  const LostNodes& lost = simulation.lost();
  std::vector<std::string_view> movers(simulation.positions().size());  // of each lost node what first made it so
  simulation.watch_movers([&](std::string_view mover) {
    for (int node = 0; node < static_cast<int>(movers.size()); ++node) {
      std::string_view& told = movers[static_cast<std::size_t>(node)];
      const bool is_lost =
          lost.is_out_of_range(node, simulation.predicted(node)) || lost.is_too_far(simulation.move(node));
      told = !is_lost ? "" : told.empty() ? mover : told;
    }
  });
  simulation.step_frame(frame);
  simulation.watch_movers({});
  const std::optional<int> node = simulation.lost().first();
  return node ? std::string(movers[static_cast<std::size_t>(*node)]) : "";
}

}  // namespace musclebench
