#pragma once

#include <span>
#include <string_view>

#include "bench/results/manifest.hpp"
#include "core/base/column.hpp"

namespace musclebench {

/// How a measurement was made; each has columns and keys of its own.
enum class ResultKind { run, replay, probe };
inline constexpr ResultKind result_kinds[] = {ResultKind::run, ResultKind::replay, ResultKind::probe};
std::string_view name_of(ResultKind kind);

/// A key of run.json, by its path: `.` goes into an object, `[]` into each element of a list, `*` stands for any name.
struct ManifestKey {
  ColumnInfo info;
  bool in_run = true;
  bool in_replay = true;
  bool in_probe = true;

  [[nodiscard]] bool is_in(ResultKind kind) const;
};

/// Every key that a run.json may have. A test holds what is written against it.
std::span<const ManifestKey> manifest_keys();

/// Columns and keys of all results, for tools and documentation: {"results_schema": .., "run": {"columns": [{"name",
/// "unit", "help"}]}, "replay": .., "probe": .., "run_json": {"run": [{"name", "unit", "help"}], ..},
/// "limits": [{"name", "unit", "help", "limit", "why"}]}.
Json results_schema_json();

}  // namespace musclebench
