#include "bench/cases/forces/force_obstacles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

double number_or(const SceneEffect& effect, const char* name, double otherwise) {
  const auto found = effect.parameters.values().find(name);
  return found == effect.parameters.values().end() ? otherwise : std::get<double>(found->second);
}

/// A constraint without compliance holds by a force that depends on the number of iterations, as does one that corrects
/// a part of its error only. A compliance sets the force (Macklin, Mueller and Chentanez 2016). Measured on activated
/// fibres without compliance: 0.23, 0.46, 1.83 N with 1, 2, 8 iterations. The one constraint on a volume is whole after
/// one projection.
bool depends_on_iterations(const SceneEffect& effect) {
  constexpr double none = -1;
  const double compliance =
      std::max(number_or(effect, "compliance_m_per_n", none), number_or(effect, "compliance_rad_per_n_m", none));
  return compliance == 0 || number_or(effect, "projection_scale", 1) < 1;
}

/// How soft edges are to one iteration: their compliance over the squared time step, over the inverse masses of both
/// ends. Measured on the pull of activated fibres (`hard/isometric`), one iteration against four: 0.2 and 1.8 of 131.7
/// N at 0.001, 22 and 70 N at 0.1, 125.6 and 131.7 N at 10.
constexpr double settled_softness = 10;
constexpr double least_softness = 0.1;

/// The longest time step with which the effect's edges are that soft in every muscle, s; infinite without edges of a
/// compliance.
double longest_step_s(const Scene& scene, const SceneEffect& effect, double softness) {
  const double compliance = number_or(effect, "compliance_m_per_n", 0);
  double longest_s = std::numeric_limits<double>::infinity();
  for (const Muscle& muscle : scene.muscles) {
    const double both_per_kg = 2 / node_mass_kg(scene, muscle);
    if (compliance > 0) longest_s = std::min(longest_s, std::sqrt(compliance / (softness * both_per_kg)));
  }
  return longest_s;
}

std::string cure_by_step(double step_s) {
  return fmt::format("(cure: loop.time_step_s = {:.2g}, with more substeps)", step_s);
}

void add_reason(std::string& reasons, const std::string& reason) { reasons += (reasons.empty() ? "" : "; ") + reason; }

}  // namespace

std::string ForceObstacles::text() const {
  if (contacts == attachments || attachments.empty()) return contacts;
  return contacts.empty() ? fmt::format("of attachments: {}", attachments)
                          : fmt::format("of contacts: {}; of attachments: {}", contacts, attachments);
}

ForceObstacles force_obstacles(const Scene& scene, const std::vector<ResponseKind>& responses) {
  std::string of_all;
  const bool has_density = scene.loop.density_kg_per_m3 > 0 || std::ranges::all_of(scene.muscles, [](const Muscle& m) {
                             return m.density_kg_per_m3.value_or(0) > 0;
                           });
  if (!has_density && scene.loop.node_mass_kg == LoopParameters().node_mass_kg) {
    add_reason(of_all, fmt::format("each node weighs {} kg, as by default (cure: loop.density_kg_per_m3)",
                                   scene.loop.node_mass_kg));
  }
  const bool turns = std::ranges::any_of(scene.motions, &BoneMotion::turns);
  if (turns && !scene.loop.interpolate_poses && scene.loop.substeps > 1) {
    add_reason(of_all, "bones jump in the first substep of a frame (cure: loop.bone_motion = \"interpolated\")");
  }
  ForceObstacles found;
  found.contacts = found.attachments = of_all;
  if (std::ranges::find(responses, ResponseKind::backtrack) != responses.end()) {
    add_reason(found.contacts, "the response backtrack moves nodes back along their paths (cure: project)");
  }
  for (const SceneEffect& effect : scene.effects) {
    const double settled_s = longest_step_s(scene, effect, settled_softness);
    found.settled_step_s = std::min(found.settled_step_s, settled_s);
    if (of_all.empty() && scene.loop.time_step_s > longest_step_s(scene, effect, least_softness)) {
      add_reason(found.attachments,
                 fmt::format("{} is too stiff for its time step, and its force grows with the number "
                             "of iterations {}",
                             effect.name, cure_by_step(settled_s)));
    } else if (of_all.empty() && scene.loop.time_step_s > settled_s) {
      add_reason(found.unsettled,
                 fmt::format("forces may be several times too small: {} is softer in this loop than its "
                             "compliance says {}",
                             effect.name, cure_by_step(settled_s)));
    }
    if (!depends_on_iterations(effect)) continue;
    add_reason(
        found.attachments,
        fmt::format("{}, and its force depends on the number of iterations (cure: {})",
                    effect.name + (effect.name.ends_with("volume") ? " is projected in part" : " has no compliance"),
                    effect.name.ends_with("volume") ? "projection_scale = 1" : "a compliance"));
  }
  return found;
}

}  // namespace musclebench
