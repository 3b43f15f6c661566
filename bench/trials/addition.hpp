#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/effects/requirement.hpp"
#include "core/scene/check/finding.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// What a search can add to a scene, as one: an effect, or contact between muscles.
struct Addition {
  std::string name;
  std::optional<AdvisedEffect> effect = {};
  std::vector<MusclePair> pairs = {};  ///< without an effect
};

/// What may help the scene to hold the requirement, and it neither has nor keeps out. First contact between muscles,
/// where that is about them: of the pairs that the checker advises, then of all. Then effects: those that the checker
/// advises, then the others in the order of the registry. What makes a run suspect may be anything: for that, all that
/// is a remedy of something. `advised`: findings of the checker.
std::vector<Addition> additions_for(const Scene& scene, Requirement requirement, const std::vector<Finding>& advised);

/// Adds it, with a reason.
void add(Scene& scene, const Addition& addition, const std::string& rule, const std::string& reason);

/// The scene with all that a search may add to it: what an option names there, it may name after a search.
Scene with_all_additions(const Scene& scene);

/// Why a scene with an addition should not be run: what the checker's quick rules find in it, and not in the scene
/// `without` it, of what cannot act or contradicts itself. Empty: nothing.
std::string refusal_by_rules(const Scene& with, const std::vector<Finding>& without);

/// What the quick rules find.
std::vector<Finding> quick_findings(const Scene& scene);

}  // namespace musclebench
