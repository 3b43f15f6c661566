#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "bench/cases/probe_case.hpp"
#include "core/base/column.hpp"

namespace musclebench {

/// Hash of the resolved case and the build.
std::string probe_id(const ProbeCase& what);

/// The columns of probe.csv. What nothing was measured of is empty.
std::span<const Column<ProbeRow>> probe_columns();

/// Makes `folder` a result folder with run.json and probe.csv. Throws InputError, with nothing left behind, when that
/// fails.
void write_probe(const std::filesystem::path& folder, const ProbeCase& what, const ProbeResult& result);

}  // namespace musclebench
