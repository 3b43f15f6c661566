#include "bench/cases/forces/force_obstacles.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace {

double number_or(const SceneEffect& effect, const char* name, double otherwise) {
  const auto found = effect.parameters.values().find(name);
  return found == effect.parameters.values().end() ? otherwise : std::get<double>(found->second);
}

/// A constraint that corrects a part of its error only holds by a force that depends on the number of iterations.
/// A compliance sets the force (Macklin, Mueller and Chentanez 2016).
bool depends_on_iterations(const SceneEffect& effect, bool has_fibres) {
  if (number_or(effect, "compliance_m_per_n", 0) > 0 || number_or(effect, "compliance_rad_per_n_m", 0) > 0)
    return false;
  const bool is_softened = has_fibres && number_or(effect, "anisotropy_exponent", 0) > 0;
  return number_or(effect, "stiffness", 1) < 1 || number_or(effect, "projection_scale", 1) < 1 || is_softened;
}

/// A constraint whose compliance over the squared time step is far below the inverse masses is never reached by few
/// iterations: its force grows with their number. Measured on activated fibres: proportional to it at a ratio of 0.001.
constexpr double least_softness = 0.1;

/// The longest time step with which the effect's edges are soft enough, s; 0 where it asks for none.
double longest_step_s(const Scene& scene, const SceneEffect& effect) {
  const double compliance = number_or(effect, "compliance_m_per_n", 0);
  double longest_s = 0;
  for (const Muscle& muscle : scene.muscles) {
    const double both_per_kg = 2 / node_mass_kg(scene, muscle);
    if (compliance / (scene.loop.time_step_s * scene.loop.time_step_s) < least_softness * both_per_kg) {
      longest_s = std::sqrt(compliance / (least_softness * both_per_kg));
    }
  }
  return longest_s;
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
  ForceObstacles found{of_all, of_all};
  if (std::ranges::find(responses, ResponseKind::backtrack) != responses.end()) {
    add_reason(found.contacts, "the response backtrack moves nodes back along their paths (cure: project)");
  }
  const bool has_fibres = std::ranges::any_of(
      scene.muscles, [](const Muscle& m) { return !m.fibres.empty() || m.fibres_between_attachments; });
  for (const SceneEffect& effect : scene.effects) {
    if (const double step_s = longest_step_s(scene, effect); step_s > 0 && of_all.empty()) {
      add_reason(found.attachments,
                 fmt::format("{} is too stiff for its time step, and its force grows with the number "
                             "of iterations (cure: loop.time_step_s = {:.2g}, with more substeps)",
                             effect.name, step_s));
    }
    if (!depends_on_iterations(effect, has_fibres)) continue;
    add_reason(found.attachments,
               fmt::format("{} corrects a part of its error only, and so depends on the number of "
                           "iterations (cure: {})",
                           effect.name, effect.name.ends_with("volume") ? "projection_scale = 1" : "a compliance"));
  }
  return found;
}

}  // namespace musclebench
