#include "bench/cases/case.hpp"

#include <algorithm>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

/// For messages: the location, where it is known, else the scene's file or name.
std::string place_of(const Scene& scene, const std::string& location) {
  if (!location.empty()) return location;
  return scene.file.empty() ? scene.name : scene.file;
}

}  // namespace

std::string refusal_of_threads(long threads) {
  const long cores = std::max(1U, std::thread::hardware_concurrency());
  if (threads < 1) return fmt::format("{} is not a number of threads; give at least 1", threads);
  if (threads <= cores) return "";
  return fmt::format("{} threads are more than the {} cores of this machine; use at most {}", threads, cores, cores);
}

Case resolve_case(const Scene& scene, const BackendEntry& backend, const Parameters& parameters,
                  const CaseChoice& choice) {
  Case resolved{scene, backend, parameters, choice.threads, choice.repetition};
  resolved.colliders = choose_collider_backends(choice.colliders, scene, backend);
  resolved.responses = choose_responses(choice.response, scene, backend, parameters, resolved.colliders);
  require_what_effects_need(scene, backend, parameters, resolved.responses, resolved.colliders);
  return resolved;
}

std::vector<ResponseKind> choose_responses(const std::string& option, const Scene& scene, const BackendEntry& backend,
                                           const Parameters& parameters, const ColliderBackends& colliders) {
  std::optional<ResponseKind> for_all = scene.response;
  if (!option.empty()) {
    for_all = find_response(option, "--response");
  }
  std::vector<ResponseKind> kinds;
  std::vector<Capabilities> can;
  const SceneBoneContact left_open;
  for (std::size_t pair = 0; pair < std::max<std::size_t>(scene.bone_pairs(), 1); ++pair) {
    const BackendChoice choice = backend_of_pair(pair, backend, parameters, colliders);
    const BackendEntry& entry = *choice.entry;
    const SceneBoneContact& contact = pair < scene.bone_contacts.size() ? scene.bone_contacts[pair] : left_open;
    const std::optional<ResponseKind> own = contact.response;
    kinds.push_back(own ? *own : for_all.value_or(entry.default_response));
    can.push_back(choice.make()->capabilities());
    const std::string_view lacking = lacks_for(kinds.back(), can.back());
    if (!lacking.empty()) {
      const std::string location = own               ? contact.response_location
                                   : !option.empty() ? "--response " + option
                                                     : fmt::format("{}: contact.response", place_of(scene, {}));
      throw InputError(location, fmt::format("'{}' has no {}; take '{}', or another backend", entry.name, lacking,
                                             name_of(entry.default_response)));
    }
  }
  // Backtracking queries the backends of all bones at positions between p and x, a node at a time.
  const auto mute = std::ranges::find(can, false, &Capabilities::point_queries);
  if (mute != can.end() && std::ranges::find(kinds, ResponseKind::backtrack) != kinds.end()) {
    throw InputError(
        fmt::format("{}: bone '{}'", place_of(scene, {}),
                    scene.bones[static_cast<std::size_t>(mute - can.begin()) % scene.bones.size()].name),
        "its backend cannot answer for single nodes, and 'backtrack' at another bone needs such answers of all bones; "
        "take 'project' there, or another backend here");
  }
  if (std::ranges::count(kinds, kinds.front()) == std::ssize(kinds)) {
    kinds.resize(1);
  }
  return kinds;
}

std::vector<std::string> effects_without_contacts(const Scene& scene, const BackendEntry& backend,
                                                  const Parameters& parameters, const ColliderBackends& colliders) {
  for (std::size_t pair = 0; pair < std::max<std::size_t>(scene.bone_pairs(), 1); ++pair) {
    if (backend_of_pair(pair, backend, parameters, colliders).make()->capabilities().finds_contacts) return {};
  }
  std::vector<std::string> lines;
  for (const SceneEffect& effect : scene.effects) {
    if (!find_effect(effect.name)->needs_normals) continue;
    lines.push_back(fmt::format("{}: effects.{}: looks at contacts with bones, and '{}' finds none: it changes nothing",
                                place_of(scene, effect.location), effect.name, backend.name));
  }
  return lines;
}

void require_what_effects_need(const Scene& scene, const BackendEntry& backend, const Parameters& parameters,
                               const std::vector<ResponseKind>& responses, const ColliderBackends& colliders) {
  for (const SceneEffect& effect : scene.effects) {
    const EffectEntry& needs = *find_effect(effect.name);
    const auto refuse = [&](std::string_view reason) {
      throw InputError(fmt::format("{}: effects.{}", place_of(scene, effect.location), effect.name),
                       fmt::format("{}; or write `{} = false`", reason, effect.name));
    };
    for (std::size_t pair = 0; needs.needs_normals && pair < std::max<std::size_t>(scene.bone_pairs(), 1); ++pair) {
      const BackendChoice choice = backend_of_pair(pair, backend, parameters, colliders);
      if (!choice.make()->capabilities().depth) {
        refuse(fmt::format("needs the normals of contacts, and '{}' tells none; take another backend",
                           choice.entry->name));
      }
    }
    if (needs.needs_projection && std::ranges::find(responses, ResponseKind::backtrack) != responses.end()) {
      refuse("needs a response that moves nodes by their depths; take 'project'");
    }
  }
}

}  // namespace musclebench
