#include "bench/results/catalogue.hpp"

#include <sstream>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "backends/registry.hpp"
#include "bench/results/build_info.hpp"
#include "bench/results/results_schema.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/scene/toml_table.hpp"
#include "datasets/embedded/embedded_files.hpp"

namespace musclebench {

namespace {

Json json_of(const ParameterValue& value) {
  return std::visit([](const auto& v) { return Json(v); }, value);
}

/// A bound of the parameter, as a whole number where the parameter is one.
Json json_of_bound(const ParameterSpec& spec, double bound) {
  if (!spec.has_range()) {
    return nullptr;
  }
  return spec.kind == ParameterKind::integer ? Json(static_cast<std::int64_t>(bound)) : Json(bound);
}

Json json_of(const ParameterSpec& spec) {
  Json json = {{"name", spec.name},
               {"kind", name_of(spec.kind)},
               {"unit", spec.unit},
               {"default", json_of(spec.default_value)},
               {"minimum", json_of_bound(spec, spec.minimum)},
               {"maximum", json_of_bound(spec, spec.maximum)},
               {"help", spec.help},
               {"role", name_of(spec.role)}};
  if (spec.kind == ParameterKind::choice) {
    json["choices"] = spec.choices;
  }
  return json;
}

Json json_of(const std::vector<ParameterSpec>& specs) {
  Json json = Json::array();
  for (const ParameterSpec& spec : specs) {
    json.push_back(json_of(spec));
  }
  return json;
}

/// TOML as JSON of the same structure; null where there is none.
Json json_of_study(const BackendEntry& backend) {
  if (backend.study.empty()) {
    return nullptr;
  }
  const toml::table study = parse_toml(backend.study, fmt::format("{}/study.toml", backend.name));
  std::ostringstream text;
  text << toml::json_formatter(study);
  return Json::parse(text.str());
}

Json json_of(const Capabilities& capabilities) {
  return {{"depth", capabilities.depth},
          {"point_queries", capabilities.point_queries},
          {"has_cache", capabilities.has_cache},
          {"has_step", capabilities.has_step},
          {"steady_memory", capabilities.steady_memory},
          {"times_pairs", capabilities.times_pairs}};
}

Json json_of(const BackendEntry& backend) {
  const Json study = json_of_study(backend);
  const auto of_study = [&](const char* key, const Json& fallback) {
    return study.is_object() ? study.value(key, fallback) : fallback;
  };
  const auto made = backend.make(Parameters(backend.parameters, {}, backend.name));
  return {{"name", backend.name},
          {"label", of_study("label", backend.name)},
          {"help", backend.help},
          {"implementation", backend.implementation},
          {"colour", of_study("colour", nullptr)},
          {"dash", of_study("dash", nullptr)},
          {"default_response", name_of(backend.default_response)},
          {"exact", backend.exact},
          {"muscle_contact", backend.make_muscle_detector != nullptr},
          {"face_contact", backend.make_surface_queries != nullptr},
          {"parameters", json_of(backend.parameters)},
          {"capabilities", json_of(made->capabilities())},
          {"study", study}};
}

Json json_of_presets() {
  Json presets = Json::array();
  for (const EmbeddedFile& file : embedded_presets()) {
    const toml::table text = parse_toml(file.text, std::string(file.name));
    const TomlTable preset(text, std::string(file.name), "");
    presets.push_back({{"name", file.name}, {"title", preset.word_or("title", std::string(file.name))}});
  }
  return presets;
}

Json json_of_scenes() {
  Json scenes = Json::array();
  for (const EmbeddedFile& file : embedded_scenes()) {
    const std::string name(file.name);
    const toml::table text = parse_toml(file.text, name);
    const TomlTable scene(text, name, "");
    Json bones = Json::array();
    for (const TomlTable& bone : scene.tables("bone")) {
      bones.push_back(bone.word("name"));
    }
    Json muscles = Json::array();
    for (const TomlTable& muscle : scene.table_or_tables("muscle")) {
      muscles.push_back(muscle.word("name"));
    }
    scenes.push_back({{"name", name}, {"title", scene.word_or("title", name)}, {"muscles", muscles}, {"bones", bones}});
  }
  return scenes;
}

}  // namespace

Json catalogue() {
  Json backends = Json::array();
  for (const BackendEntry& backend : backend_registry()) {
    backends.push_back(json_of(backend));
  }
  Json responses = Json::array();
  for (const ResponseEntry& response : response_registry()) {
    responses.push_back({{"name", response.name}, {"help", response.help}});
  }
  Json effects = Json::array();
  for (const EffectEntry& effect : effect_registry()) {
    Json remedies = Json::array();
    for (const Remedy& remedy : effect.remedies) remedies.push_back(name_of(remedy.requirement));
    effects.push_back({{"name", effect.name},
                       {"help", effect.help},
                       {"parameters", json_of(effect.parameters)},
                       {"remedies", remedies},
                       {"colour", effect.colour}});
  }
  const BuildInfo build = build_info();
  return {{"schema", catalogue_schema},
          {"version", build.version},
          {"git", build.git},
          {"backends", backends},
          {"responses", responses},
          {"effects", effects},
          {"loop", json_of(loop_parameters())},
          {"meshes", json_of(mesh_parameters())},
          {"wanted", json_of(wanted_parameters())},
          {"presets", json_of_presets()},
          {"scenes", json_of_scenes()},
          {"results", results_schema_json()}};
}

}  // namespace musclebench
