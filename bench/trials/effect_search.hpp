#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/trials/effect_trial.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// One run of a search, and what followed from it.
struct TriedSet {
  std::string change;   ///< "+ surface_contact", "- bending"; empty: the set as it was
  std::string verdict;  ///< what its figures say
  EffectTrial trial;
};

/// What a search found.
struct EffectChoice {
  std::vector<AddedEffect> added;       ///< what the scene takes beside its own
  std::vector<std::string> needless;    ///< own effects without which no figure changes, with figures
  std::vector<RequiredFigure> figures;  ///< of the scene with what was added
  std::vector<std::string> unmet;       ///< what does not hold, and what was tried
  std::vector<TriedSet> tried;          ///< in order
  Nanoseconds cpu_ns = 0;

  [[nodiscard]] bool holds() const { return unmet.empty(); }
};

/// Runs a scene, as `try_effects`.
using TryScene =
    std::function<EffectTrial(const Scene& scene, const ShowsEnough& shows_enough, const std::string& what)>;

struct SearchOptions {
  bool looks_for_needless = false;  ///< also runs the scene without each effect of its own
};

/// Looks for the effects that `scene` takes to hold what it wants (`[wanted]`), and adds them to it.
///
/// What the checker's rules about effects ask for is added at once. Then the scene is run. While it does not hold a
/// requirement, each effect with a remedy for it is tried, and contact between muscles that meet: first what the
/// checker's rules advise, then in the order of the registry, which is that of cost. The first with which the
/// requirement holds stays; where there is none, the one that halves the excess, if no other requirement suffers. In
/// the end each addition is left out once, and stays only if something then does not hold or, if a rule asked for it,
/// the shape is another. What the scene names stays, what it keeps out stays out. Deterministic: neither times nor
/// threads decide.
EffectChoice choose_effects(Scene& scene, const TryScene& try_scene, const SearchOptions& options = {});

}  // namespace musclebench
