#include "bench/cases/advise_plan.hpp"

#include <fmt/format.h>

#include "backends/registry.hpp"
#include "core/base/input_error.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

namespace {

/// The parameter that `table` names, which has to be one with a range.
const ParameterSpec& named_parameter(const TomlTable& table, const BackendEntry& backend) {
  const std::string name = table.word("parameter");
  const ParameterSpec* spec = find_parameter(backend.parameters, name);
  if (spec == nullptr || !spec->has_range()) {
    throw InputError(table.location("parameter"), fmt::format("'{}' is no number of the backend", name));
  }
  return *spec;
}

Refinement read_refinement(const TomlTable& table, const BackendEntry& backend) {
  table.allow_only({"parameter", "from", "to", "factor", "interpolate"});
  const ParameterSpec& spec = named_parameter(table, backend);
  Refinement refine{spec.name,
                    spec.kind == ParameterKind::integer,
                    table.number("from", spec.minimum, spec.maximum),
                    table.number("to", spec.minimum, spec.maximum),
                    table.number("factor", 0.1, 10),
                    table.flag_or("interpolate", false)};
  if (refine.from <= 0 || refine.factor == 1 || (refine.factor > 1) != (refine.to > refine.from)) {
    throw InputError(table.location("factor"), "does not lead from `from` to `to`, which are above 0");
  }
  return refine;
}

WantedErrorSteps read_wanted_error(const TomlTable& table, const BackendEntry& backend) {
  table.allow_only({"parameter", "factor", "coarsest", "build_order"});
  const ParameterSpec& spec = named_parameter(table, backend);
  if (spec.unit != "m" && spec.unit != "mm") {
    throw InputError(table.location("parameter"), fmt::format("'{}' is no length in m or mm", spec.name));
  }
  const double per_metre = spec.unit == "mm" ? 1e3 : 1;
  return {spec.name, per_metre, table.number("factor", 1.01, 100),
          table.number("coarsest", spec.minimum, spec.maximum) / per_metre, table.number("build_order", 0, 10)};
}

Settings checked(const TomlTable& table, const BackendEntry& backend) {
  Settings settings = table.values();
  const Parameters parameters(backend.parameters, settings, table.location());
  (void)backend.make(parameters);  // refuses what does not go together
  return settings;
}

AdvisePlan read_plan(const TomlTable& table, const BackendEntry& backend) {
  table.allow_only({"points", "refine", "wanted_error", "unit_of_price"});
  AdvisePlan plan{backend.name, backend.exact};
  for (const TomlTable& point : table.tables("points")) {
    plan.points.push_back(checked(point, backend));
  }
  if (const auto refine = table.table("refine")) {
    plan.refine = read_refinement(*refine, backend);
  }
  if (const auto wanted_error = table.table("wanted_error")) {
    plan.wanted_error = read_wanted_error(*wanted_error, backend);
  }
  if (const auto unit = table.table("unit_of_price")) {
    plan.unit_of_price = checked(*unit, backend);
  }
  return plan;
}

}  // namespace

std::optional<AdvisePlan> read_advise_plan(const BackendEntry& backend) {
  const std::string file = fmt::format("{}/study.toml", backend.name);
  const toml::table text = parse_toml(backend.study, file);
  const auto table = TomlTable(text, file, "").table("advise");
  return table ? std::optional(read_plan(*table, backend)) : std::nullopt;
}

std::vector<AdvisePlan> advise_plans() {
  std::vector<AdvisePlan> plans;
  for (const BackendEntry& backend : backend_registry()) {
    if (std::optional<AdvisePlan> plan = read_advise_plan(backend)) {
      plans.push_back(*std::move(plan));
    }
  }
  return plans;
}

}  // namespace musclebench
