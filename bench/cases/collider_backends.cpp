#include "bench/cases/collider_backends.hpp"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/input_error.hpp"
#include "core/contact/backends_by_pair.hpp"

namespace musclebench {

namespace {

constexpr const char* all_muscles = "muscles";
constexpr const char* all_faces = "faces";

template <typename Maker>
std::vector<std::string> backends_that_have(Maker BackendEntry::*maker) {
  std::vector<std::string> able;
  for (const BackendEntry& entry : backend_registry()) {
    if (entry.*maker) able.push_back(entry.name);
  }
  return able;
}

void require_follows_muscles(const BackendEntry& entry, const std::string& location) {
  if (entry.make_muscle_detector) {
    return;
  }
  throw InputError(location,
                   fmt::format("'{}' can't follow a surface that deforms; between muscles take {}", entry.name,
                               fmt::join(backends_that_have(&BackendEntry::make_muscle_detector), ", ")));
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

/// What `--for` says of some colliders.
struct ColliderOption {
  std::string text;
  std::string backend;
  std::vector<std::string> parameters;  ///< key=value

  [[nodiscard]] std::string location() const { return "--for " + text; }
};

/// By colliders.
using ColliderOptions = std::map<std::string, ColliderOption>;

std::vector<std::string> split(std::string_view text, char at) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(at, begin), text.size());
    parts.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

std::string pair_name(const std::string& muscle, const std::string& other) { return muscle + '/' + other; }

std::string name_of(const Scene& scene, int muscle) {
  return scene.muscles[static_cast<std::size_t>(muscle)].body.name;
}

bool has_face_contact(const Scene& scene) {
  return std::ranges::find(scene.effects, "surface_contact", &SceneEffect::name) != scene.effects.end();
}

/// All that `--for` may name.
std::vector<std::string> known_colliders(const Scene& scene) {
  std::vector<std::string> known;
  for (const Bone& bone : scene.bones) known.push_back(bone.name);
  if (!scene.muscle_pairs.empty()) known.emplace_back(all_muscles);
  if (has_face_contact(scene)) known.emplace_back(all_faces);
  for (const Muscle& muscle : scene.muscles) {
    for (const Bone& bone : scene.bones) known.push_back(pair_name(muscle.body.name, bone.name));
  }
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    const std::string first = name_of(scene, pair.muscles.first);
    const std::string second = name_of(scene, pair.muscles.second);
    known.push_back(pair_name(first, second));
    known.push_back(pair_name(second, first));
  }
  return known;
}

/// Two of one pair are one, in the order of the scene.
std::string ordered(const std::string& colliders, const Scene& scene) {
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    const std::string first = name_of(scene, pair.muscles.first);
    const std::string second = name_of(scene, pair.muscles.second);
    if (colliders == pair_name(second, first)) return pair_name(first, second);
  }
  return colliders;
}

std::string refusal_of(const std::string& colliders, const std::vector<std::string>& known) {
  if (colliders == all_faces) return "nothing asks about faces in this scene; give it [effects.surface_contact]";
  return colliders == all_muscles
             ? std::string("no muscles of this scene touch; give it muscle_contact = true or a [[pair]]")
             : fmt::format(
                   "'{}' is not a bone of this scene, nor a pair MUSCLE/BONE or of muscles that touch; did you "
                   "mean '{}'?",
                   colliders, nearest_word(colliders, known));
}

ColliderOptions parse(const std::vector<std::string>& options, const Scene& scene) {
  const std::vector<std::string> known = known_colliders(scene);
  ColliderOptions chosen;
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
    const std::string colliders = text.substr(0, equals);
    if (std::ranges::find(known, colliders) == known.end()) {
      throw InputError(option.location(), refusal_of(colliders, known));
    }
    option.backend = text.substr(equals + 1, colon - equals - 1);
    if (colon < text.size()) option.parameters = split(std::string_view(text).substr(colon + 1), ',');
    if (!chosen.emplace(ordered(colliders, scene), std::move(option)).second) {
      throw InputError("--for " + text, fmt::format("names '{}' twice; leave one out", colliders));
    }
  }
  return chosen;
}

/// What is named there, by an option or by the scene.
struct NamedBackend {
  const BackendEntry* entry;
  std::map<std::string, ParameterValue> given;
  std::string location;             ///< of the name, for messages
  std::string parameters_location;  ///< of the parameters

  [[nodiscard]] BackendChoice choice() const {
    return {entry, Parameters(entry->parameters, given, parameters_location)};
  }
};

NamedBackend named_by(const ColliderOption& option) {
  const BackendEntry& entry = find_backend(option.backend, option.location());
  return {&entry, parse_assignments(option.parameters, option.location(), entry.parameters), option.location(),
          option.location()};
}

/// Nothing: it is left open.
std::optional<NamedBackend> named_by(const SceneBackend& named) {
  if (named.name.empty()) {
    return std::nullopt;
  }
  return NamedBackend{&find_backend(named.name, named.location), named.parameters, named.location,
                      named.parameters_location};
}

/// By the first of these colliders that an option names, else by the scene.
std::optional<NamedBackend> find_named(const ColliderOptions& options, std::initializer_list<std::string> colliders,
                                       const SceneBackend& by_scene) {
  for (const std::string& each : colliders) {
    if (const auto option = options.find(each); option != options.end()) {
      return named_by(option->second);
    }
  }
  return named_by(by_scene);
}

/// Nothing: that of the case.
std::optional<BackendChoice> choose_with_bone(const std::optional<NamedBackend>& named, const BackendEntry& of_case) {
  if (!named || (named->entry == &of_case && named->given.empty())) {
    return std::nullopt;
  }
  BackendChoice choice = named->choice();
  (void)choice.make();  // refuses what does not go together, before anything is built
  return choice;
}

BackendChoice choose_between_muscles(const std::optional<NamedBackend>& named) {
  if (!named) {
    const BackendEntry& entry = default_muscle_backend();
    return {&entry, Parameters(entry.parameters, {}, entry.name)};
  }
  require_follows_muscles(*named->entry, named->location);
  BackendChoice choice = named->choice();
  const TriangleMesh nothing;
  try {
    (void)choice.entry->make_muscle_detector(choice.parameters, {nothing, {}, {}}, 1);
  } catch (const InputError& error) {  // what does not go together, before anything is built
    throw InputError(named->parameters_location, error.what());
  }
  return choice;
}

std::optional<BackendChoice> choose_for_faces(const std::optional<NamedBackend>& named, std::span<const Bone> bones) {
  if (!named) return std::nullopt;
  for (const auto& [name, value] : named->given) {
    const ParameterSpec* spec = find_parameter(named->entry->parameters, name);
    if (name == "cull" || spec->role == ParameterRole::clearance_cache || spec->role == ParameterRole::storage) {
      throw InputError(named->parameters_location, fmt::format("'{}' changes nothing for faces; leave it out", name));
    }
  }
  if (!named->entry->make_surface_queries) {
    throw InputError(named->location,
                     fmt::format("'{}' does not answer for faces; take {}", named->entry->name,
                                 fmt::join(backends_that_have(&BackendEntry::make_surface_queries), ", ")));
  }
  BackendChoice choice = named->choice();
  try {
    (void)choice.entry->make_surface_queries(choice.parameters, bones);  // refuses before anything is built
  } catch (const InputError& error) {
    throw InputError(named->parameters_location, error.what());
  }
  return choice;
}

}  // namespace

ColliderBackends choose_collider_backends(const std::vector<std::string>& options, const Scene& scene,
                                          const BackendEntry& backend) {
  const ColliderOptions chosen = parse(options, scene);
  ColliderBackends result;
  for (const Muscle& muscle : scene.muscles) {
    for (const Bone& bone : scene.bones) {
      const SceneBackend by_scene = result.with_bones.size() < scene.bone_contacts.size()
                                        ? scene.bone_contacts[result.with_bones.size()].backend
                                        : SceneBackend{};
      result.with_bones.push_back(
          choose_with_bone(find_named(chosen, {pair_name(muscle.body.name, bone.name), bone.name}, by_scene), backend));
    }
  }
  if (std::ranges::none_of(result.with_bones, &std::optional<BackendChoice>::has_value)) {
    result.with_bones.clear();
  }
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    const std::string name = pair_name(name_of(scene, pair.muscles.first), name_of(scene, pair.muscles.second));
    result.of_muscle_pairs.push_back(choose_between_muscles(find_named(chosen, {name, all_muscles}, pair.backend)));
  }
  result.of_faces = choose_for_faces(find_named(chosen, {all_faces}, {}), scene.bones);
  return result;
}

BackendChoice backend_of_pair(std::size_t pair, const BackendEntry& backend, const Parameters& parameters,
                              const ColliderBackends& colliders) {
  if (pair < colliders.with_bones.size() && colliders.with_bones[pair]) {
    return *colliders.with_bones[pair];
  }
  return {&backend, parameters};
}

namespace {

/// Who is asked about which muscles; none: about all.
using Assignments = std::vector<std::pair<BackendChoice, std::vector<int>>>;

/// Of one bone, in the order of the muscles.
Assignments assignments_of(std::size_t bone, const Scene& scene, const BackendEntry& backend,
                           const Parameters& parameters, const ColliderBackends& colliders) {
  Assignments assignments;
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    const BackendChoice choice = backend_of_pair(scene.bone_pair(muscle, bone), backend, parameters, colliders);
    auto same = std::ranges::find(assignments, choice, &Assignments::value_type::first);
    if (same == assignments.end()) {
      same = assignments.insert(same, {choice, {}});
    }
    same->second.push_back(static_cast<int>(muscle));
  }
  if (assignments.size() == 1) assignments.front().second.clear();  // all of them
  return assignments;
}

}  // namespace

std::unique_ptr<CollisionBackend> make_backend(const Scene& scene, const BackendEntry& backend,
                                               const Parameters& parameters, const ColliderBackends& colliders) {
  if (colliders.with_bones.empty()) {
    return backend.make(parameters);
  }
  std::vector<BackendsByPair::Part> parts;
  Assignments last;
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    Assignments assignments = assignments_of(bone, scene, backend, parameters, colliders);
    if (bone > 0 && assignments == last) {
      for (std::size_t i = parts.size() - last.size(); i < parts.size(); ++i) ++parts[i].bones;
      continue;
    }
    for (const auto& [choice, muscles] : assignments) {
      BackendsByPair::Part& part = parts.emplace_back(BackendsByPair::Part{choice.make(), bone});
      for (const int muscle : muscles) part.muscles.push_back(scene.muscles[static_cast<std::size_t>(muscle)].body);
    }
    last = std::move(assignments);
  }
  return std::make_unique<BackendsByPair>(std::move(parts));
}

std::vector<std::unique_ptr<MuscleContactDetector>> make_muscle_detectors(const Scene& scene,
                                                                          const ColliderBackends& colliders,
                                                                          int threads) {
  std::vector<std::unique_ptr<MuscleContactDetector>> detectors;
  std::vector<BackendChoice> seen;
  for (const BackendChoice& choice : colliders.of_muscle_pairs) {
    if (std::ranges::find(seen, choice) != seen.end()) {
      continue;
    }
    seen.push_back(choice);
    TouchingMuscles muscles{scene.muscle_mesh, scene.bodies(), {}};
    for (std::size_t i = 0; i < colliders.of_muscle_pairs.size(); ++i) {
      if (colliders.of_muscle_pairs[i] == choice) muscles.pairs.push_back(scene.muscle_pairs[i].muscles);
    }
    detectors.push_back(choice.entry->make_muscle_detector(choice.parameters, muscles, threads));
  }
  return detectors;
}

ContactMethods make_contact_methods(const Scene& scene, const ColliderBackends& colliders, int threads) {
  ContactMethods methods{make_muscle_detectors(scene, colliders, threads)};
  if (const auto& choice = colliders.of_faces) {
    methods.make_surface_queries = choice->entry->make_surface_queries(choice->parameters, scene.bones);
  }
  return methods;
}

}  // namespace musclebench
