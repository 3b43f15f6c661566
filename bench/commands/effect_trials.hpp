#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "bench/cases/scene_source.hpp"
#include "bench/trials/effect_search.hpp"

namespace musclebench {

/// Adds the option `--wanted`.
void add_wanted_option(CLI::App& command, std::vector<std::string>& wanted);
/// Its values. Throws InputError.
std::map<std::string, ParameterValue> wanted_overrides(const std::vector<std::string>& wanted);

/// Searches with progress on standard error.
EffectChoice choose_effects_with_progress(Scene& scene, const SearchOptions& options);

struct WantedEffectsOptions {
  bool searches_again = false;  ///< even where an earlier search is known
  bool judges_the_end = false;  ///< as SearchOptions; an earlier search has to have, too
  std::function<void(const Scene& widest)> before_search = {};  ///< of the scene with all that may be added
};

/// Adds to a scene that asks for effects and says what it wants those that it takes, and tells them and its warnings on
/// standard error; what does not hold becomes a warning, too. Takes them from an earlier search of the same scene, or
/// searches. Leaves other scenes alone. Throws InputError where no trial can be run. Returns whether the search called
/// all held without a look at all frames, so that the run may show more.
bool add_wanted_effects(const SceneChoice& choice, Scene& scene, const WantedEffectsOptions& options = {});

/// What was found, in lines: wanted, each run, what was added, what is needless, what does not hold.
std::vector<std::string> lines_of(const Scene& scene, const EffectChoice& choice);

}  // namespace musclebench
