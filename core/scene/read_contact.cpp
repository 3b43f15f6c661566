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
    throw InputError(location, fmt::format("muscle '{}' is open, so it has no inside; close its surface, or "
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

SceneBackend backend_with_parameters(const TomlTable& table) {
  SceneBackend backend = backend_in(table, "backend");
  if (const auto parameters = table.table("parameters")) {
    if (backend.name.empty()) {
      throw InputError(table.location("parameters"), "need a backend in the same table; name it by `backend`");
    }
    backend.parameters = parameters->values();
    backend.parameters_location = table.location("parameters");
  }
  return backend;
}

/// `[[pair]]`: two muscles that touch, and who detects that.
SceneMusclePair read_muscle_pair(const TomlTable& table, const Scene& scene) {
  table.allow_only({"muscles", "backend", "parameters", "steps"});
  const std::vector<std::string> names = table.words("muscles");
  const std::string location = table.location("muscles");
  if (names.size() != 2) {
    throw InputError(location, "has to name two muscles [\"a\", \"b\"]");
  }
  const auto first = static_cast<int>(find_muscle(scene, names[0], location));
  const auto second = static_cast<int>(find_muscle(scene, names[1], location));
  if (first == second) {
    throw InputError(location, fmt::format("'{}' stands there twice; name two different muscles", names[0]));
  }
  return {{std::min(first, second), std::max(first, second)}, backend_with_parameters(table), steps_in(table)};
}

/// `[[pair]]`: what is other than for the bone's other muscles.
void read_bone_pair(const TomlTable& table, Scene& scene, std::vector<std::size_t>& named) {
  table.allow_only({"muscle", "bone", "backend", "parameters", "response", "steps"});
  const std::size_t muscle = find_muscle(scene, table.word("muscle"), table.location("muscle"));
  const std::size_t pair = scene.bone_pair(muscle, find_bone(scene, table.word("bone"), table.location("bone")));
  if (std::ranges::find(named, pair) != named.end()) {
    throw InputError(table.location("bone"), "is paired with that muscle in an earlier [[pair]], too; leave one out");
  }
  named.push_back(pair);
  SceneBoneContact own = read_bone_contact(table);
  if (own.backend.name.empty() && !own.response && !own.response_steps) {
    throw InputError(table.location(), "says nothing of the muscle and the bone; add backend, response or steps");
  }
  SceneBoneContact& contact = scene.bone_contacts[pair];
  if (!own.backend.name.empty()) contact.backend = std::move(own.backend);
  if (own.response) {
    contact.response = own.response;
    contact.response_location = std::move(own.response_location);
  }
  if (own.response_steps) contact.response_steps = own.response_steps;
}

/// All that `[[pair]]` tables say: of muscles and bones at once into the scene, of two muscles as they stand there.
std::vector<SceneMusclePair> read_pair_tables(const TomlTable& root, Scene& scene) {
  std::vector<SceneMusclePair> of_muscles;
  std::vector<std::size_t> of_bones;
  for (const TomlTable& table : root.tables("pair")) {
    const bool with_bone = table.has("muscle") || table.has("bone");
    if (with_bone == table.has("muscles")) {
      throw InputError(table.location(),
                       "has to be of two muscles (muscles = [\"a\", \"b\"]), or of a muscle and a bone (muscle = "
                       "\"a\", bone = \"c\")");
    }
    if (with_bone) {
      read_bone_pair(table, scene, of_bones);
      continue;
    }
    SceneMusclePair pair = read_muscle_pair(table, scene);
    if (std::ranges::find(of_muscles, pair.muscles, &SceneMusclePair::muscles) != of_muscles.end()) {
      throw InputError(table.location("muscles"), "repeats an earlier [[pair]]; leave one out");
    }
    of_muscles.push_back(std::move(pair));
  }
  return of_muscles;
}

void add_all_muscle_pairs(Scene& scene, const SceneBackend& backend) {
  const auto count = static_cast<int>(scene.muscles.size());
  for (int first = 0; first < count; ++first) {
    for (int second = first + 1; second < count; ++second) {
      scene.muscle_pairs.push_back({{first, second}, backend});
    }
  }
}

/// What is said of a bone holds for each of the muscles.
void repeat_for_muscles(Scene& scene) {
  const std::vector<SceneBoneContact> of_bones = scene.bone_contacts;
  for (std::size_t muscle = 1; muscle < scene.muscles.size(); ++muscle) {
    scene.bone_contacts.insert(scene.bone_contacts.end(), of_bones.begin(), of_bones.end());
  }
}

std::size_t index_of(const std::string& name, const std::vector<std::string>& known, std::string_view what,
                     const std::string& location) {
  const auto found = std::ranges::find(known, name);
  if (found == known.end()) {
    throw InputError(location, fmt::format("'{}' is not a {} of this scene; did you mean '{}'?", name, what,
                                           nearest_word(name, known)));
  }
  return static_cast<std::size_t>(found - known.begin());
}

}  // namespace

std::size_t find_muscle(const Scene& scene, const std::string& name, const std::string& location) {
  std::vector<std::string> known;
  for (const Muscle& muscle : scene.muscles) {
    known.push_back(muscle.body.name);
  }
  return index_of(name, known, "muscle", location);
}

std::size_t find_bone(const Scene& scene, const std::string& name, const std::string& location) {
  std::vector<std::string> known;
  for (const Bone& bone : scene.bones) {
    known.push_back(bone.name);
  }
  return index_of(name, known, "bone", location);
}

void read_response(const std::optional<TomlTable>& contact, Scene& scene) {
  if (!contact) {
    return;
  }
  contact->allow_only({"response", "steps", "muscle_contact", "muscle_backend"});
  scene.response = response_in(*contact);
  scene.response_steps = steps_in(*contact).value_or(default_projection_steps);
  if (contact->has("steps")) scene.response_steps_location = contact->location("steps");
}

SceneBoneContact read_bone_contact(const TomlTable& table) {
  return {backend_with_parameters(table), response_in(table), table.location("response"), steps_in(table)};
}

void read_pairs(const TomlTable& root, const std::optional<TomlTable>& contact, Scene& scene) {
  const auto count = static_cast<int>(scene.muscles.size());
  const SceneBackend backend = contact ? backend_in(*contact, "muscle_backend") : SceneBackend{};
  if (contact && contact->flag_or("muscle_contact", false)) {
    if (count < 2) {
      throw InputError(contact->location("muscle_contact"), "needs two muscles, and the scene has one");
    }
    add_all_muscle_pairs(scene, backend);
  }
  repeat_for_muscles(scene);
  std::vector<SceneMusclePair> named = read_pair_tables(root, scene);
  for (SceneMusclePair& pair : named) {
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
