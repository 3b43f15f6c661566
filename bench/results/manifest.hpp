#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/cases/build_backend.hpp"
#include "core/base/machine_state.hpp"

namespace musclebench {

/// Keys keep the order in which they were written.
using Json = nlohmann::ordered_json;

/// `schema_version` of every run.json and of the columns beside it (results_schema.hpp).
inline constexpr int schema_version = 2;
/// Results of this version and later ones mean the same; versions after it only add columns, keys and statuses.
inline constexpr int oldest_readable_schema = 1;

/// Names that are no UTF-8 are written with replacement characters. `indent` < 0: on one line.
std::string text_of(const Json& json, int indent = -1);

/// Of two muscles.
Json names_of(const Scene& scene, const MusclePair& pair);

/// Scene, backend, response, parameters, threads, effects and loop. `mode` is how it was measured: coupled, replay,
/// probe.
Json json_of_case(const Case& resolved, std::string_view mode);

/// Keys "muscle" and "bones": meshes with their hashes, repairs, motions.
Json json_of_inputs(const Scene& scene);

Json json_of_build();

Json json_of(const MachineState& state);
/// `structures`, and where they were loaded `kept_build_ns`.
void add_origin(Json& json, const StructureOrigin& origin);
Json json_of(const std::vector<PrunedResult>& pruned, const Scene& scene);

/// What every run.json begins with: schema version, status, run id, case, inputs, build and machine.
Json manifest_head(std::string_view status, std::string_view status_detail, const Json& json_of_case,
                   const Case& resolved);

/// Hash of everything that a run's outcome depends on: the two JSON texts, which name what is run and on what, the
/// nodes and fibres that the scene resolved to, and the build. 16 hexadecimal digits.
std::string id_of(const Json& json_of_case, const Scene& scene);

/// Hash of what moves the muscle and of what it moves against, as resolved: meshes, repairs, motions, attachments,
/// fibres, loop and effects. It knows neither names of files nor the build. 64 hexadecimal digits.
std::string scene_hash(const Scene& scene);

}  // namespace musclebench
