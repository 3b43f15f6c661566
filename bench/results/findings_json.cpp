#include "bench/results/findings_json.hpp"

#include "core/scene/check/effect_reach.hpp"

namespace musclebench {

Json json_of(const Finding& finding) {
  Json figures = Json::object();
  for (const Figure& figure : finding.figures) figures[figure.name] = figure.value;
  Json json = {{"id", finding.id},       {"kind", name_of(finding.kind)}, {"place", finding.place},
               {"where", finding.where}, {"what", finding.what},          {"figures", figures},
               {"add", finding.add},     {"remove", finding.remove}};
  json["effect"] = finding.effect ? Json(finding.effect->name) : Json(nullptr);
  return json;
}

namespace {

Json json_of(const std::vector<AddedEffect>& all) {
  Json added = Json::array();
  for (const AddedEffect& effect : all) {
    added.push_back({{"effect", effect.effect}, {"rule", effect.rule}, {"reason", effect.reason}});
  }
  return added;
}

Json json_of(const std::vector<RequiredFigure>& all) {
  Json figures = Json::array();
  for (const RequiredFigure& figure : all) {
    figures.push_back({{"requirement", name_of(figure.requirement)},
                       {"value", figure.value},
                       {"limit", figure.limit},
                       {"holds", figure.holds()},
                       {"where", figure.where},
                       {"frame", figure.when.frame},
                       {"text", figure.text()}});
  }
  return figures;
}

}  // namespace

Json json_of_added(const Scene& scene) { return json_of(scene.auto_effects.added); }

Json json_of(const EffectChoice& choice) {
  Json tried = Json::array();
  for (const TriedSet& each : choice.tried) {
    tried.push_back({{"change", each.change},
                     {"verdict", each.verdict},
                     {"stopped", each.was_stopped},
                     {"frames", each.frames},
                     {"cpu_ns", each.cpu_ns},
                     {"figures", json_of(each.figures)}});
  }
  Json unmet = Json::array();
  for (const Unmet& each : choice.unmet) unmet.push_back({{"what", each.what}, {"tried", each.tried}});
  return {{"added_effects", json_of(choice.added)},
          {"needless", choice.needless},
          {"unmet", unmet},
          {"figures", json_of(choice.figures)},
          {"tried", tried},
          {"cpu_ns", choice.cpu_ns}};
}

Json json_of(const std::vector<SceneWarning>& warnings) {
  Json json = Json::array();
  for (const SceneWarning& warning : warnings) json.push_back({{"rule", warning.rule}, {"text", warning.text}});
  return json;
}

Json json_of_check(const Scene& scene, const std::vector<SceneWarning>& warnings,
                   const std::vector<Finding>& findings) {
  Json json = {{"scene", scene.name}, {"preset", scene.preset}, {"obstacles", scene.obstacles}};
  json["warnings"] = json_of(warnings);
  json["added_effects"] = json_of_added(scene);
  json["acts_on"] = Json::object();
  for (const EffectReach& reach : effect_reaches(scene)) {
    json["acts_on"][std::string(reach.effect)] = {{"nodes_against_bones", reach.nodes},
                                                  {"faces_and_edges_against_bones", reach.surface},
                                                  {"muscles", reach.muscles},
                                                  {"itself", reach.itself}};
  }
  json["findings"] = Json::array();
  for (const Finding& finding : findings) json["findings"].push_back(json_of(finding));
  return json;
}

}  // namespace musclebench
