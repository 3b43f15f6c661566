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

/// By collider, in the order of the options.
std::map<std::string, std::string> parse(const std::vector<std::string>& options, const Scene& scene) {
  std::vector<std::string> known;
  for (const Bone& bone : scene.bones) known.push_back(bone.name);
  if (!scene.muscle_pairs.empty()) known.emplace_back(all_muscles);
  std::map<std::string, std::string> chosen;
  for (const std::string& text : options) {
    const std::string location = "--for " + text;
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
      throw InputError(location, "has to read COLLIDER=BACKEND, such as femur=bvh");
    }
    const std::string collider = text.substr(0, equals);
    if (std::ranges::find(known, collider) == known.end()) {
      throw InputError(location,
                       collider == all_muscles
                           ? std::string("no muscles of this scene touch; give it muscle_contact = true or a [[pair]]")
                           : fmt::format("'{}' is not a bone of this scene; did you mean '{}'?", collider,
                                         nearest_word(collider, known)));
    }
    if (!chosen.emplace(collider, text.substr(equals + 1)).second) {
      throw InputError(location, fmt::format("names '{}' twice; leave one out", collider));
    }
  }
  return chosen;
}

}  // namespace

ColliderBackends choose_collider_backends(const std::vector<std::string>& options, const Scene& scene,
                                          const BackendEntry& backend) {
  const std::map<std::string, std::string> chosen = parse(options, scene);
  ColliderBackends result;
  bool is_one_for_all = true;
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    const std::string& bone = scene.bones[i].name;
    const auto by_option = chosen.find(bone);
    const std::string by_scene = i < scene.bone_contacts.size() ? scene.bone_contacts[i].backend : "";
    const BackendEntry* entry = nullptr;
    if (by_option != chosen.end()) {
      entry = &find_backend(by_option->second, "--for " + bone + "=" + by_option->second);
    } else if (!by_scene.empty()) {
      entry = &find_backend(by_scene, fmt::format("{}: bone[{}].backend", scene.name, i + 1));
    }
    result.of_bones.push_back(entry == &backend ? nullptr : entry);
    is_one_for_all = is_one_for_all && result.of_bones.back() == nullptr;
  }
  if (is_one_for_all) result.of_bones.clear();
  const auto by_option = chosen.find(all_muscles);
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    const std::string names =
        fmt::format("{} and {}", scene.muscles[static_cast<std::size_t>(pair.muscles.first)].body.name,
                    scene.muscles[static_cast<std::size_t>(pair.muscles.second)].body.name);
    result.of_pairs.push_back(
        by_option != chosen.end() ? &muscle_backend(by_option->second, "--for muscles=" + by_option->second)
        : pair.backend.empty()
            ? &default_muscle_backend()
            : &muscle_backend(pair.backend, fmt::format("{}: backend of the pair {}", scene.name, names)));
  }
  return result;
}

std::unique_ptr<CollisionBackend> make_default(const BackendEntry& entry) {
  return entry.make(Parameters(entry.parameters, {}, entry.name));
}

std::unique_ptr<CollisionBackend> make_backend(const BackendEntry& backend, const Parameters& parameters,
                                               const ColliderBackends& colliders) {
  if (colliders.of_bones.empty()) {
    return backend.make(parameters);
  }
  std::vector<BackendsByBone::Part> parts;
  const BackendEntry* last = nullptr;
  for (const BackendEntry* own : colliders.of_bones) {
    const BackendEntry* entry = own == nullptr ? &backend : own;
    if (parts.empty() || entry != last) {
      parts.push_back({own == nullptr ? backend.make(parameters) : make_default(*own), 0});
    }
    ++parts.back().bones;
    last = entry;
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
