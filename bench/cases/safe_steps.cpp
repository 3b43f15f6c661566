#include "bench/cases/safe_steps.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/input_error.hpp"
#include "core/base/input_file.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

namespace {

using Json = nlohmann::json;

constexpr int known_schema = 1;
constexpr const char* guard_effect = "tunnelling_guard";

/// A number, 0 for none that is right; infinite where none was seen to be wrong.
double largest_of(const Json& row, const std::string& key, const std::string& wrong_key) {
  if (row.at(wrong_key).is_null()) return std::numeric_limits<double>::infinity();
  return row.at(key).is_null() ? 0 : row.at(key).get<double>();
}

SafeSteps safe_steps_of(const Json& json, const std::string& file) {
  if (json.at("schema") != known_schema) {
    throw InputError(file, fmt::format("has schema {}; this program reads {}", json.at("schema").dump(), known_schema));
  }
  SafeSteps known{file, json.at("scene").get<std::string>(), {}};
  for (const Json& row : json.at("steps")) {
    if (row.at("turn_wrong_deg").is_null() && row.at("turn_deg").is_null()) continue;  // could not be run so
    known.steps.push_back({row.at("backend").get<std::string>(), row.at("response").get<std::string>(),
                           row.at("guard").get<bool>(), largest_of(row, "turn_deg", "turn_wrong_deg"),
                           largest_of(row, "time_step_s", "time_step_wrong_s")});
  }
  return known;
}

/// The largest turn of a frame, as frames.csv has it.
double turn_deg(const Scene& scene) {
  double largest_rad = 0;
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    largest_rad = std::max(largest_rad, std::abs(scene.angle_rad(frame) - scene.angle_rad(frame - 1)));
  }
  return largest_rad * degrees_per_radian;
}

double longest_time_step_s(const Scene& scene) {
  double longest_s = 0;
  for (int frame = 1; frame <= scene.loop.frames; ++frame) {
    longest_s = std::max(longest_s, scene.loop.time_step_of_s(frame));
  }
  return longest_s;
}

constexpr double same = 1 + 1e-6;

std::optional<std::string> excess(const SafeStep& step, const Scene& scene) {
  if (const double turned_deg = turn_deg(scene); turned_deg > same * step.turn_deg) {
    return fmt::format("bones turn by {:.3g} degrees a frame, and runs stay right up to {:.3g}", turned_deg,
                       step.turn_deg);
  }
  if (const double step_s = longest_time_step_s(scene); step_s > same * step.time_step_s) {
    return fmt::format("the time step is {:.3g} ms, and runs stay right up to {:.3g} ms", 1e3 * step_s,
                       1e3 * step.time_step_s);
  }
  return std::nullopt;
}

void require_same_scene(const SafeSteps& known, const Scene& scene) {
  if (known.scene == scene.name) return;
  throw InputError(known.file,
                   fmt::format("is of scene '{}', not '{}'; run tools/safe-step on this one", known.scene, scene.name));
}

}  // namespace

SafeSteps read_safe_steps(const std::filesystem::path& file) {
  constexpr std::uintmax_t most_bytes = 1 << 24;
  const std::string text = InputFile(file).text(most_bytes);
  try {
    return safe_steps_of(Json::parse(text), file.string());
  } catch (const Json::exception& damage) {
    throw InputError(file.string(), fmt::format("is not what tools/safe-step writes: {}", damage.what()));
  }
}

std::optional<std::string> why_unsafe(const SafeSteps& known, const Scene& scene, const std::string& backend,
                                      const std::string& response) {
  require_same_scene(known, scene);
  const bool guard = has_effect(scene, guard_effect);
  for (const SafeStep& step : known.steps) {
    if (step.backend != backend || step.response != response || step.guard != guard) continue;
    if (const std::optional<std::string> beyond = excess(step, scene)) return beyond;
  }
  return std::nullopt;
}

Findings safe_step_findings(const SafeSteps& known, const Scene& scene, const std::string& only) {
  require_same_scene(known, scene);
  const bool guard = has_effect(scene, guard_effect);
  Findings findings;
  for (const SafeStep& step : known.steps) {
    if (step.guard != guard || (!only.empty() && step.backend != only)) continue;
    const std::optional<std::string> beyond = excess(step, scene);
    if (!beyond) continue;
    Finding finding;
    finding.id = "step_beyond_safe";
    finding.place = known.file;
    finding.where = fmt::format("{} with response {}", step.backend, step.response);
    finding.what = *beyond;
    finding.figures = {{"turn_deg", turn_deg(scene)}, {"time_step_s", longest_time_step_s(scene)}};
    if (std::isfinite(step.turn_deg)) finding.figures.push_back({"safe_turn_deg", step.turn_deg});
    if (std::isfinite(step.time_step_s)) finding.figures.push_back({"safe_time_step_s", step.time_step_s});
    const auto guarded = std::ranges::find_if(known.steps, [&](const SafeStep& other) {
      return other.guard && other.backend == step.backend && other.response == step.response;
    });
    if (!guard && guarded != known.steps.end() && !excess(*guarded, scene)) {
      finding.add = {fmt::format("[effects.{}]", guard_effect)};
    } else if (step.turn_deg > 0 && turn_deg(scene) > same * step.turn_deg) {
      finding.add = {"[loop]",
                     fmt::format("frames = {:.0f}", std::ceil(scene.loop.frames * turn_deg(scene) / step.turn_deg))};
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

}  // namespace musclebench
