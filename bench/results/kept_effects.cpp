#include "bench/results/kept_effects.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/results/manifest.hpp"
#include "core/base/atomic_file.hpp"
#include "core/base/input_error.hpp"
#include "core/base/input_file.hpp"
#include "core/base/sha256.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/scene/check/auto_effects.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

/// By its bytes: a version does not tell what was changed since. Empty where they can't be read.
std::string hash_of_this_program() {
  std::ifstream program("/proc/self/exe", std::ios::binary);
  std::array<char, 1 << 16> block;
  Sha256 hash;
  while (program.read(block.data(), block.size()) || program.gcount() > 0) {
    hash.add(std::string_view(block.data(), static_cast<std::size_t>(program.gcount())));
  }
  return program.eof() ? hash.hex_digest() : std::string();
}

fs::path cache_folder() {
  if (const char* folder = std::getenv("XDG_CACHE_HOME"); folder != nullptr && *folder == '/') return folder;
  const char* home = std::getenv("HOME");
  return home != nullptr && *home == '/' ? fs::path(home) / ".cache" : fs::path();
}

/// The cache never has more searches than that: the oldest go.
constexpr std::size_t most_kept = 1000;

void forget_oldest(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::error_code failed;
  for (fs::directory_iterator file(folder, failed); file != fs::directory_iterator(); file.increment(failed)) {
    const fs::file_time_type written = file->last_write_time(failed);
    if (!failed && file->path().extension() == ".json") files.emplace_back(written, file->path());
  }
  if (files.size() <= most_kept) return;
  const auto kept = files.end() - static_cast<std::ptrdiff_t>(most_kept);
  std::nth_element(files.begin(), kept, files.end());
  std::for_each(files.begin(), kept, [&](const auto& file) { fs::remove(file.second, failed); });
}

/// Those that the search gave; a default that is given is another scene to the checker.
Json json_of_values(const Scene& scene, const std::string& name) {
  Json values = Json::array();
  const auto effect = std::ranges::find(scene.effects, name, &SceneEffect::name);
  if (effect == scene.effects.end()) return values;
  for (const auto& [key, value] : effect->parameters.values()) {
    if (effect->parameters.given(key)) values.push_back(fmt::format("{}={}", key, format_parameter_value(value)));
  }
  return values;
}

/// Throws InputError for what this program does not know, or a search would not add.
void add_kept(const Json& kept, const std::string& file, Scene& scene) {
  const std::string name = kept.at("effect");
  const std::string rule = kept.at("rule");
  const std::string reason = kept.at("reason");
  if (std::ranges::any_of(rule + reason, [](unsigned char letter) { return letter < ' '; })) {
    throw InputError(file, "has a reason of several lines");
  }
  if (const EffectEntry* entry = find_effect(name)) {
    if (!may_add_effect(scene, name)) throw InputError(file, "has an effect that the scene has or keeps out");
    add_effect(scene, {name, parse_assignments(kept.at("values"), file, entry->parameters)}, rule, reason);
    return;
  }
  const int muscles = static_cast<int>(scene.muscles.size());
  for (int first = 0; first < muscles; ++first) {
    for (int second = first + 1; second < muscles; ++second) {
      if (name_of_muscle_contact(scene, {first, second}) != name) continue;
      if (!may_add_muscle_contact(scene, {first, second})) break;
      add_muscle_contact(scene, {first, second}, rule, reason);
      return;
    }
  }
  throw InputError(file, "has the unknown effect " + name);
}

}  // namespace

std::optional<fs::path> kept_effects_file(const Scene& scene, const std::string& resolved_text) {
  const fs::path folder = cache_folder();
  const std::string program = folder.empty() ? std::string() : hash_of_this_program();
  if (program.empty()) return std::nullopt;
  Json search = {{"program", program}, {"scene", resolved_text}, {"kept_out", Json::array()}};
  for (const EffectExclusion& exclusion : scene.exclusions) search["kept_out"].push_back(exclusion.effect);
  if (scene.auto_effects.keeps_out_muscle_contact) search["kept_out"].push_back("muscle_contact");
  return folder / "musclebench" / "effects" / (id_of(search, scene) + ".json");
}

std::optional<EffectChoice> add_kept_effects(const fs::path& file, Scene& scene) {
  try {
    const Json kept = Json::parse(InputFile(file).text());
    Scene with = scene;
    EffectChoice choice;
    if (!kept.at("added").is_array() || !kept.at("unmet").is_array()) return std::nullopt;
    for (const Json& added : kept.at("added")) add_kept(added, file.string(), with);
    for (const Json& unmet : kept.at("unmet")) choice.unmet.push_back({unmet.at("what"), unmet.at("tried")});
    choice.added = with.auto_effects.added;
    choice.judged_all_frames = kept.at("judged_all_frames");
    scene = std::move(with);
    return choice;
  } catch (const InputError&) {
    return std::nullopt;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

void keep_effects(const fs::path& file, const Scene& scene, const EffectChoice& found) {
  Json added = Json::array();
  for (const AddedEffect& each : found.added) {
    added.push_back({{"effect", each.effect},
                     {"rule", each.rule},
                     {"reason", each.reason},
                     {"values", json_of_values(scene, each.effect)}});
  }
  Json unmet = Json::array();
  for (const Unmet& each : found.unmet) unmet.push_back({{"what", each.what}, {"tried", each.tried}});
  const Json kept = {
      {"scene", scene.name}, {"added", added}, {"unmet", unmet}, {"judged_all_frames", found.judged_all_frames}};
  try {
    write_atomically(file, [&](std::ostream& out) { out << text_of(kept, 2) << '\n'; });
    forget_oldest(file.parent_path());
  } catch (const InputError&) {
    // A folder that can't be written is no reason not to run.
  }
}

}  // namespace musclebench
