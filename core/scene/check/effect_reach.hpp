#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.hpp"

namespace musclebench {

/// What an effect of contact acts on, in a scene with its other effects.
struct EffectReach {
  std::string_view effect;
  bool nodes = false;    ///< nodes of muscles against bones
  bool surface = false;  ///< faces and edges of muscles against bones
  bool muscles = false;  ///< muscles against each other
  bool itself = false;   ///< each muscle against itself

  [[nodiscard]] bool is_inert() const { return !nodes && !surface && !muscles && !itself; }
  /// In words: "nodes and faces against bones, muscles against each other", or "nothing".
  [[nodiscard]] std::string text() const;
};

/// Of each effect of contact that the scene has, in the order of the registry.
std::vector<EffectReach> effect_reaches(const Scene& scene);

}  // namespace musclebench
