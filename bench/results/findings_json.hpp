#pragma once

#include "bench/results/manifest.hpp"
#include "bench/trials/effect_search.hpp"
#include "core/scene/check/finding.hpp"
#include "core/scene/scene_warning.hpp"

namespace musclebench {

/// `id`, `kind`, `where`, `what`, `figures`, `add`, `remove`, `effect`.
Json json_of(const Finding& finding);

/// What `effects = "auto"` added: `effect`, `rule`, `reason`, in the order of the checker's rules.
Json json_of_added(const Scene& scene);

/// `rule`, `text` of each.
Json json_of(const std::vector<SceneWarning>& warnings);

/// What `check --json` prints of a scene: `obstacles` as texts, `warnings`,
/// `added_effects` and `findings` as objects.
Json json_of_check(const Scene& scene, const std::vector<SceneWarning>& warnings, const std::vector<Finding>& findings);

/// What `check --trial --json` prints of the search: `added_effects`, `needless`, `unmet`, `figures`, `tried`,
/// `cpu_ns`.
Json json_of(const EffectChoice& choice);

}  // namespace musclebench
