#include "core/scene/check/scene_check.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/percentile.hpp"
#include "core/scene/check/effect_checks.hpp"
#include "core/scene/scene_warnings.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

const PoseEstimates& CheckContext::poses() {
  if (!m_poses) m_poses = std::make_unique<PoseEstimates>(scene);
  return *m_poses;
}

const std::vector<double>& CheckContext::thickness_m() {
  if (!m_thickness_m) m_thickness_m = node_thicknesses_m(scene);
  return *m_thickness_m;
}

const std::vector<BoneNearness>& CheckContext::nearness() {
  if (!m_nearness) m_nearness = bone_nearness(scene, poses(), thickness_m());
  return *m_nearness;
}

std::optional<double> CheckContext::usual_thickness_m() {
  std::vector<double> known;
  std::ranges::copy_if(thickness_m(), std::back_inserter(known), [](double thickness) { return thickness > 0; });
  if (known.empty()) return std::nullopt;
  return percentile(std::move(known), 0.25);
}

std::size_t CheckContext::free_node_count() { return scene.muscle_mesh.vertices.size() - scene.bound_nodes().size(); }

namespace {

/// The line of what the finding is about; the file where no line is.
std::string place_of(const Scene& scene, const std::string& where) {
  for (const SceneEffect& effect : scene.effects) {
    const std::string key = "effects." + effect.name;
    const bool is_meant = where == key || where.starts_with(key + ".");
    if (is_meant && !effect.location.empty()) return effect.location;
  }
  for (const Attachment& attachment : scene.attachments) {
    if (where == "attachment '" + attachment.name + "'" && !attachment.location.empty()) return attachment.location;
  }
  return scene.file;
}

}  // namespace

Findings check_scene(const Scene& scene, const CheckOptions& options) {
  CheckContext context(scene, options);
  std::vector<SceneRule> rules = general_rules();
  for (const EffectChecksSource& source : effect_checks_table()) {
    const std::vector<SceneRule>& own = find_checks(source.effect)->rules;
    rules.insert(rules.end(), own.begin(), own.end());
  }
  std::stable_partition(rules.begin(), rules.end(), [](const SceneRule& rule) { return !rule.needs_geometry; });
  if (options.only_quick) std::erase_if(rules, [](const SceneRule& rule) { return rule.needs_geometry; });
  Findings findings;
  int done = 0;
  for (const SceneRule& rule : rules) {
    const std::size_t before = findings.size();
    rule.look(context, findings);
    for (std::size_t i = before; i < findings.size(); ++i) {
      findings[i].id = rule.id;
      findings[i].place = place_of(scene, findings[i].where);
    }
    if (options.report) options.report(++done, static_cast<int>(rules.size()));
  }
  return findings;
}

std::vector<SceneWarning> warnings_of(const Scene& scene) {
  std::vector<SceneWarning> warnings = scene_warnings(scene);
  for (const Finding& finding : check_scene(scene, {.only_quick = true})) {
    warnings.push_back({finding.id, text_of(finding)});
  }
  return warnings;
}

bool is_closed_muscle(const Scene& scene, std::size_t muscle) {
  return is_closed(scene.mesh_of(scene.muscles[muscle].body));
}

}  // namespace musclebench
