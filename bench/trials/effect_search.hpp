#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/trials/effect_trial.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// One run of a search, and what followed from it.
struct TriedSet {
  std::string change;  ///< "as it is", "+ surface_contact", "- bending"
  std::string verdict;
  std::vector<RequiredFigure> figures = {};
  bool was_stopped = false;
  int frames = 0;
  Nanoseconds cpu_ns = 0;
};

/// A requirement that does not hold in the end.
struct Unmet {
  std::string what;                     ///< the figure, or why nothing could be run
  std::vector<std::string> tried = {};  ///< what each addition left

  [[nodiscard]] std::string text() const;
};

/// What a search found.
struct EffectChoice {
  std::vector<AddedEffect> added;       ///< what the scene takes beside its own
  std::vector<std::string> needless;    ///< own effects that together change nothing, with figures
  std::vector<RequiredFigure> figures;  ///< of the scene with what was added
  std::vector<Unmet> unmet;             ///< in the scene with what was added
  std::vector<TriedSet> tried;          ///< in order
  bool was_refused = false;             ///< the scene could not be run; `unmet` says why
  bool judged_all_frames = false;       ///< of the scene with what was added
  Nanoseconds cpu_ns = 0;

  [[nodiscard]] bool holds() const { return unmet.empty(); }
};

/// Whether the effects of the scene are left to trial runs: it asks for effects and says what it wants.
bool waits_for_trials(const Scene& scene);

/// Throws InputError for such a scene: `what` would not have the effects that a run has.
void require_named_effects(const Scene& scene, const std::string& what);

/// Runs a scene, as `try_effects`; `what` is for progress.
using TryScene = std::function<EffectTrial(const Scene& scene, const TrialRequest& request, const std::string& what)>;

struct SearchOptions {
  bool looks_for_needless = false;  ///< also runs the scene without each effect of its own
  bool judges_the_end = false;      ///< judges all frames of what was found, and goes on if they show more
};

/// Looks for the effects that `scene` takes to hold what it wants (`[wanted]`), and adds them to it.
///
/// What the checker's quick rules ask for is added at once; what the checker added before is taken away. Then the scene
/// is run. While it does not hold a requirement, each addition that may help is tried (additions_for). The first that
/// holds it and spoils nothing stays. If there is none, that stays which gains most: it has to halve the excess, and
/// may spoil others by half of that at most. In the end each addition is left out once, and stays only if something
/// then is worse or, if a rule asked for it, the shape is another. What the scene names stays, what it keeps out stays
/// out. Deterministic: neither times nor threads decide.
EffectChoice choose_effects(Scene& scene, const TryScene& try_scene, const SearchOptions& options = {});

}  // namespace musclebench
