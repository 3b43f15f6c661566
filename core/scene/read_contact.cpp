#include "core/scene/read_contact.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

void require_closed(const Scene& scene, int muscle, const std::string& location) {
  const Body& body = scene.muscles[static_cast<std::size_t>(muscle)].body;
  if (!is_closed(scene.mesh_of(body))) {
    throw InputError(location,
                     fmt::format("muscle '{}' is open: what is inside it can't be told; close its surface, or "
                                 "let it touch no muscle (`musclebench check` counts its boundary edges)",
                                 body.name));
  }
}

std::optional<ResponseKind> response_in(const TomlTable& table) {
  if (!table.has("response")) {
    return std::nullopt;
  }
  return find_response(table.word("response"), table.location("response"));
}

std::optional<int> steps_in(const TomlTable& table) {
  if (!table.has("steps")) {
    return std::nullopt;
  }
  constexpr double most_steps = 1000;
  const double steps = table.number("steps", 1, most_steps);
  if (steps != std::floor(steps)) {
    throw InputError(table.location("steps"), "has to be a whole number");
  }
  return static_cast<int>(steps);
}

SceneBackend backend_in(const TomlTable& table, std::string_view key) {
  if (!table.has(key)) {
    return {};
  }
  return {table.word(key), {}, table.location(key), ""};
}

/// `[[pair]]`: two muscles that touch, and who detects that.
SceneMusclePair read_pair(const TomlTable& table, const Scene& scene) {
  table.allow_only({"muscles", "backend", "steps"});
  const std::vector<std::string> names = table.words("muscles");
  const std::string location = table.location("muscles");
  if (names.size() != 2) {
    throw InputError(location, "has to name two muscles [\"a\", \"b\"]");
  }
  const auto first = static_cast<int>(find_muscle(scene, names[0], location));
  const auto second = static_cast<int>(find_muscle(scene, names[1], location));
  if (first == second) {
    throw InputError(location, fmt::format("'{}' stands there twice; a pair is of two muscles", names[0]));
  }
  return {{std::min(first, second), std::max(first, second)}, backend_in(table, "backend"), steps_in(table)};
}

}  // namespace

std::size_t find_muscle(const Scene& scene, const std::string& name, const std::string& location) {
  std::vector<std::string> known;
  for (const Muscle& muscle : scene.muscles) {
    known.push_back(muscle.body.name);
  }
  const auto found = std::ranges::find(known, name);
  if (found == known.end()) {
    throw InputError(location, fmt::format("'{}' is not a muscle of this scene; did you mean '{}'?", name,
                                           nearest_word(name, known)));
  }
  return static_cast<std::size_t>(found - known.begin());
}

void read_response(const std::optional<TomlTable>& contact, Scene& scene) {
  if (!contact) {
    return;
  }
  contact->allow_only({"response", "steps", "muscle_contact", "muscle_backend"});
  scene.response = response_in(*contact);
  scene.response_steps = steps_in(*contact).value_or(default_projection_steps);
}

SceneBoneContact read_bone_contact(const TomlTable& bone) {
  SceneBackend backend = backend_in(bone, "backend");
  if (const auto parameters = bone.table("parameters")) {
    if (backend.name.empty()) {
      throw InputError(bone.location("parameters"), "are those of the bone's own backend; name it by `backend`");
    }
    backend.parameters = parameters->values();
    backend.parameters_location = bone.location("parameters");
  }
  return {std::move(backend), response_in(bone), steps_in(bone)};
}

void read_muscle_pairs(const TomlTable& root, const std::optional<TomlTable>& contact, Scene& scene) {
  const auto count = static_cast<int>(scene.muscles.size());
  const SceneBackend backend = contact ? backend_in(*contact, "muscle_backend") : SceneBackend{};
  if (contact && contact->flag_or("muscle_contact", false)) {
    if (count < 2) {
      throw InputError(contact->location("muscle_contact"), "needs two muscles, and the scene has one");
    }
    for (int first = 0; first < count; ++first) {
      for (int second = first + 1; second < count; ++second) {
        scene.muscle_pairs.push_back({{first, second}, backend});
      }
    }
  }
  std::vector<MusclePair> named;
  for (const TomlTable& table : root.tables("pair")) {
    SceneMusclePair pair = read_pair(table, scene);
    if (std::ranges::find(named, pair.muscles) != named.end()) {
      throw InputError(table.location("muscles"),
                       "names a pair that stands in an earlier [[pair]], too; leave one out");
    }
    named.push_back(pair.muscles);
    if (pair.backend.name.empty()) pair.backend = backend;
    const auto same = std::ranges::find(scene.muscle_pairs, pair.muscles, &SceneMusclePair::muscles);
    if (same == scene.muscle_pairs.end()) {
      scene.muscle_pairs.push_back(pair);
    } else {
      *same = pair;
    }
  }
  if (!backend.name.empty() && scene.muscle_pairs.empty()) {
    throw InputError(contact->location("muscle_backend"),
                     "detects nothing: no muscles touch; add muscle_contact = true or a [[pair]]");
  }
  std::ranges::sort(scene.muscle_pairs, {}, &SceneMusclePair::muscles);
  const std::string location = named.empty() && contact ? contact->location("muscle_contact") : root.location("pair");
  for (int muscle = 0; muscle < count; ++muscle) {
    if (std::ranges::any_of(scene.muscle_pairs, [&](const SceneMusclePair& pair) {
          return pair.muscles.first == muscle || pair.muscles.second == muscle;
        })) {
      require_closed(scene, muscle, location);
    }
  }
}

}  // namespace musclebench
