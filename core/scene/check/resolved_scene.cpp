#include <algorithm>
#include <filesystem>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "core/scene/check/auto_effects.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

namespace {

/// A reference of a scene to a file, `FILE` or `FILE#NAME`; other words that may stand in its place are none.
bool is_relative_file(const std::string& word) {
  return !word.starts_with("synthetic:") && !word.starts_with("${data}/") && word != "none" &&
         word != "between_attachments" && std::filesystem::path(word).is_relative();
}

void make_absolute(toml::table* table, std::string_view key, const std::filesystem::path& folder) {
  toml::value<std::string>* word = table == nullptr ? nullptr : table->get_as<std::string>(key);
  if (word == nullptr || !is_relative_file(word->get())) return;
  word->get() = std::filesystem::absolute(folder / word->get()).lexically_normal().string();
}

/// Calls `change` with the table `key`, or each one of a list of tables.
template <typename Change>
void for_each_table(toml::table& root, std::string_view key, const Change& change) {
  if (toml::table* one = root.get_as<toml::table>(key)) change(*one);
  if (toml::array* several = root.get_as<toml::array>(key)) {
    for (toml::node& node : *several) change(*node.as_table());
  }
}

void make_paths_absolute(toml::table& root, const std::filesystem::path& folder) {
  for_each_table(root, "bone", [&](toml::table& bone) {
    make_absolute(&bone, "mesh", folder);
    for_each_table(bone, "motion", [&](toml::table& motion) { make_absolute(&motion, "table", folder); });
  });
  for_each_table(root, "muscle", [&](toml::table& muscle) {
    make_absolute(&muscle, "mesh", folder);
    make_absolute(&muscle, "fibres", folder);
  });
  for_each_table(root, "attachment", [&](toml::table& area) { make_absolute(&area, "outline", folder); });
}

std::string toml_text_of(const ParameterValue& value) {
  const auto* word = std::get_if<std::string>(&value);
  if (word == nullptr) return format_parameter_value(value);
  std::ostringstream quoted;
  quoted << toml::value<std::string>(*word);
  return quoted.str();
}

/// A value in one line. Numbers are as short as they can be to read back to the same bits.
std::string toml_text_of(const toml::node& node) {
  std::vector<std::string> parts;
  if (const toml::array* array = node.as_array()) {
    for (const toml::node& item : *array) parts.push_back(toml_text_of(item));
    return fmt::format("[{}]", fmt::join(parts, ", "));
  }
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table) parts.push_back(fmt::format("{} = {}", key.str(), toml_text_of(value)));
    return fmt::format("{{ {} }}", fmt::join(parts, ", "));
  }
  if (const auto* number = node.as_floating_point()) return toml_text_of(ParameterValue(number->get()));
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  return text.str();
}

std::string table_text(const std::string& heading, toml::table& table) {
  std::string text = fmt::format("\n{}\n", heading);
  // Its name comes first, its tables last.
  if (const toml::node* name = table.get("name")) text += fmt::format("name = {}\n", toml_text_of(*name));
  for (const auto& [key, value] : table) {
    if (key.str() != "name" && key.str() != "motion") {
      text += fmt::format("{} = {}\n", key.str(), toml_text_of(value));
    }
  }
  const char* heading_of_motion = table.get_as<toml::array>("motion") ? "[[bone.motion]]" : "[bone.motion]";
  for_each_table(table, "motion", [&](const toml::table& motion) {
    text += fmt::format("{}\n", heading_of_motion);
    for (const auto& [key, value] : motion) text += fmt::format("{} = {}\n", key.str(), toml_text_of(value));
  });
  return text;
}

std::string tables_text(toml::table& root, std::string_view key) {
  const std::string heading = root.get_as<toml::array>(key) ? fmt::format("[[{}]]", key) : fmt::format("[{}]", key);
  std::string text;
  for_each_table(root, key, [&](toml::table& table) { text += table_text(heading, table); });
  return text;
}

std::string effect_text(const Scene& scene, const SceneEffect& effect) {
  std::string text;
  const auto& added = scene.auto_effects.added;
  if (const auto why = std::ranges::find(added, effect.name, &AddedEffect::effect); why != added.end()) {
    text = fmt::format("\n# Added [{}]: {}", why->rule, why->reason);
  }
  text += fmt::format("\n[effects.{}]\n", effect.name);
  for (const auto& [key, value] : effect.parameters.values()) {
    if (effect.parameters.given(key)) text += fmt::format("{} = {}\n", key, toml_text_of(value));
  }
  return text;
}

std::string pair_texts(const Scene& scene) {
  std::string text;
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    const std::string& first = scene.muscles[static_cast<std::size_t>(pair.muscles.first)].body.name;
    const std::string& second = scene.muscles[static_cast<std::size_t>(pair.muscles.second)].body.name;
    const auto& added = scene.auto_effects.added;
    const auto why = std::ranges::find(added, fmt::format("muscle_contact {} {}", first, second), &AddedEffect::effect);
    if (why == added.end()) continue;
    text += fmt::format("\n# Added [{}]: {}\n[[pair]]\nmuscles = [\"{}\", \"{}\"]\n", why->rule, why->reason, first,
                        second);
  }
  return text;
}

}  // namespace

namespace {

/// As the command line has it.
void change_motions(toml::table& root, const std::map<std::string, ParameterValue>& overrides) {
  toml::array* bones = root["bone"].as_array();
  for (std::size_t i = 0; bones != nullptr && i < bones->size(); ++i) {
    // Several [[bone.motion]] and overrides are refused (read_motion).
    for_each_table(*bones->get(i)->as_table(), "motion", [&](toml::table& motion) {
      for (const auto& [key, value] : overrides) {
        std::visit([&, &name = key](const auto& held) { motion.insert_or_assign(name, held); }, value);
      }
    });
  }
}

}  // namespace

std::string resolved_scene_text(const SceneRequest& request, const Scene& scene) {
  toml::table root = parse_toml(request.text, request.file);
  make_paths_absolute(root, request.folder);
  change_motions(root, request.motion_overrides);
  std::ostringstream text;
  text << fmt::format("# {}{}, with all effects by name: those of scene and preset, and those that were added.\n",
                      scene.name, scene.preset.empty() ? "" : fmt::format(" (preset {})", scene.preset));
  text << fmt::format("title = {}\n", toml_text_of(ParameterValue(scene.title)));
  if (const auto* word = root.get_as<std::string>("attachment")) {
    text << fmt::format("attachment = {}\n", toml_text_of(ParameterValue(word->get())));
  }
  text << "\n[loop]\n";
  for (const auto& [key, value] : loop_values(scene.loop)) text << fmt::format("{} = {}\n", key, toml_text_of(value));
  text << "\n[meshes]\n";
  for (const auto& [key, value] : mesh_values(scene.mesh_splits))
    text << fmt::format("{} = {}\n", key, toml_text_of(value));
  if (scene.fibre_count > 0) text << fmt::format("\n[measure]\nfibres = {}\n", scene.fibre_count);
  if (scene.wanted.is_given) text << "\n[wanted]\n";
  for (const auto& [key, value] : scene.wanted.own_values) text << fmt::format("{} = {}\n", key, toml_text_of(value));
  for (const SceneEffect& effect : scene.effects) text << effect_text(scene, effect);
  for (const char* key :
       {"source", "time_step_change", "contact", "bone", "muscle", "attachment", "retinaculum", "pair"})
    text << tables_text(root, key);
  text << pair_texts(scene);
  return text.str();
}

}  // namespace musclebench
