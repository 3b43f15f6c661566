#include "bench/cases/collider_backends.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/input_error.hpp"
#include "core/contact/backends_by_bone.hpp"

namespace musclebench {

namespace {

constexpr const char* all_muscles = "muscles";

const BackendEntry& muscle_backend(std::string_view name, const std::string& location) {
  const BackendEntry& entry = find_backend(name, location);
  if (!entry.make_muscle_detector) {
    std::vector<std::string> able;
    for (const BackendEntry& other : backend_registry()) {
      if (other.make_muscle_detector) able.push_back(other.name);
    }
    throw InputError(location, fmt::format("'{}' can't follow a surface that deforms; between muscles take {}", name,
                                           fmt::join(able, ", ")));
  }
  return entry;
}

const BackendEntry& default_muscle_backend() {
  const auto& entries = backend_registry();
  const auto found = std::ranges::find_if(
      entries, [](const BackendEntry& entry) { return entry.exact && entry.make_muscle_detector != nullptr; });
  if (found == entries.end()) {
    throw InputError("--for muscles", "this build has no exact backend for muscles that touch; name one");
  }
  return *found;
}

/// What `--for` says of one collider.
struct ColliderOption {
  std::string text;
  std::string backend;
  std::vector<std::string> parameters;  ///< key=value

  [[nodiscard]] std::string location() const { return "--for " + text; }
};

std::vector<std::string> split(std::string_view text, char at) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(at, begin), text.size());
    parts.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/// By collider.
std::map<std::string, ColliderOption> parse(const std::vector<std::string>& options, const Scene& scene) {
  std::vector<std::string> known;
  for (const Bone& bone : scene.bones) known.push_back(bone.name);
  if (!scene.muscle_pairs.empty()) known.emplace_back(all_muscles);
  std::map<std::string, ColliderOption> chosen;
  for (const std::string& text : options) {
    const std::size_t equals = text.find('=');
    const std::size_t colon = std::min(text.find(':'), text.size());
    ColliderOption option{text, "", {}};
    if (equals == std::string::npos || equals == 0 || equals + 1 >= colon || colon + 1 == text.size()) {
      throw InputError(
          option.location(),
          fmt::format("has to read COLLIDER=BACKEND or COLLIDER=BACKEND:key=value,key=value, such as {}={}",
                      known.front(), exact_backend().name));
    }
    const std::string collider = text.substr(0, equals);
    if (std::ranges::find(known, collider) == known.end()) {
      throw InputError(option.location(),
                       collider == all_muscles
                           ? std::string("no muscles of this scene touch; give it muscle_contact = true or a [[pair]]")
                           : fmt::format("'{}' is not a bone of this scene; did you mean '{}'?", collider,
                                         nearest_word(collider, known)));
    }
    option.backend = text.substr(equals + 1, colon - equals - 1);
    if (colon < text.size()) option.parameters = split(std::string_view(text).substr(colon + 1), ',');
    if (!option.parameters.empty() && collider == all_muscles) {
      throw InputError(option.location(), "between muscles a backend has its defaults; leave the parameters out");
    }
    if (!chosen.emplace(collider, std::move(option)).second) {
      throw InputError("--for " + text, fmt::format("names '{}' twice; leave one out", collider));
    }
  }
  return chosen;
}

/// Nothing: that of the case.
std::optional<BackendChoice> choose(const std::string& name, const std::string& location,
                                    const std::map<std::string, ParameterValue>& given,
                                    const std::string& parameters_location, const BackendEntry& of_case) {
  const BackendEntry& entry = find_backend(name, location);
  if (&entry == &of_case && given.empty()) {
    return std::nullopt;
  }
  BackendChoice choice{&entry, Parameters(entry.parameters, given, parameters_location)};
  (void)choice.make();  // refuses what does not go together, before anything is built
  return choice;
}

std::optional<BackendChoice> choose(const ColliderOption& option, const BackendEntry& of_case) {
  const BackendEntry& entry = find_backend(option.backend, option.location());
  return choose(option.backend, option.location(),
                parse_assignments(option.parameters, option.location(), entry.parameters), option.location(), of_case);
}

std::optional<BackendChoice> choose(const SceneBackend& named, const BackendEntry& of_case) {
  if (named.name.empty()) {
    return std::nullopt;
  }
  return choose(named.name, named.location, named.parameters, named.parameters_location, of_case);
}

const BackendEntry* backend_of_pair(const SceneMusclePair& pair, const std::map<std::string, ColliderOption>& chosen) {
  if (const auto option = chosen.find(all_muscles); option != chosen.end()) {
    return &muscle_backend(option->second.backend, option->second.location());
  }
  return pair.backend.name.empty() ? &default_muscle_backend()
                                   : &muscle_backend(pair.backend.name, pair.backend.location);
}

}  // namespace

ColliderBackends choose_collider_backends(const std::vector<std::string>& options, const Scene& scene,
                                          const BackendEntry& backend) {
  const std::map<std::string, ColliderOption> chosen = parse(options, scene);
  ColliderBackends result;
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    const auto option = chosen.find(scene.bones[i].name);
    const SceneBackend by_scene = i < scene.bone_contacts.size() ? scene.bone_contacts[i].backend : SceneBackend{};
    result.of_bones.push_back(option != chosen.end() ? choose(option->second, backend) : choose(by_scene, backend));
  }
  if (std::ranges::none_of(result.of_bones, &std::optional<BackendChoice>::has_value)) {
    result.of_bones.clear();
  }
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    result.of_pairs.push_back(backend_of_pair(pair, chosen));
  }
  return result;
}

ColliderBackends bone_backends(const std::vector<std::string>& options, const Scene& scene,
                               const BackendEntry& backend) {
  for (const std::string& text : options) {
    if (text.starts_with(fmt::format("{}=", all_muscles))) {
      throw InputError("--for " + text,
                       "asks for contact between muscles, whose positions are given here; leave it out");
    }
  }
  ColliderBackends colliders = choose_collider_backends(options, scene, backend);
  colliders.of_pairs.clear();
  return colliders;
}

BackendChoice backend_of_bone(std::size_t bone, const BackendEntry& backend, const Parameters& parameters,
                              const ColliderBackends& colliders) {
  if (bone < colliders.of_bones.size() && colliders.of_bones[bone]) {
    return *colliders.of_bones[bone];
  }
  return {&backend, parameters};
}

std::unique_ptr<CollisionBackend> make_backend(const BackendEntry& backend, const Parameters& parameters,
                                               const ColliderBackends& colliders) {
  if (colliders.of_bones.empty()) {
    return backend.make(parameters);
  }
  std::vector<BackendsByBone::Part> parts;
  std::optional<BackendChoice> last;
  for (std::size_t bone = 0; bone < colliders.of_bones.size(); ++bone) {
    const BackendChoice choice = backend_of_bone(bone, backend, parameters, colliders);
    if (!last || !(choice == *last)) {
      parts.push_back({choice.make(), 0});
    }
    ++parts.back().bones;
    last = choice;
  }
  return std::make_unique<BackendsByBone>(std::move(parts));
}

std::vector<std::unique_ptr<MuscleContactDetector>> make_muscle_detectors(const Scene& scene,
                                                                          const ColliderBackends& colliders,
                                                                          int threads) {
  std::vector<std::unique_ptr<MuscleContactDetector>> detectors;
  std::vector<const BackendEntry*> seen;
  for (const BackendEntry* entry : colliders.of_pairs) {
    if (std::ranges::find(seen, entry) != seen.end()) {
      continue;
    }
    seen.push_back(entry);
    TouchingMuscles muscles{scene.muscle_mesh, scene.bodies(), {}};
    for (std::size_t i = 0; i < colliders.of_pairs.size(); ++i) {
      if (colliders.of_pairs[i] == entry) muscles.pairs.push_back(scene.muscle_pairs[i].muscles);
    }
    detectors.push_back(entry->make_muscle_detector(Parameters(entry->parameters, {}, entry->name), muscles, threads));
  }
  return detectors;
}

}  // namespace musclebench
