#pragma once

#include <filesystem>
#include <string>

#include "bench/cases/probe_case.hpp"

namespace musclebench {

/// Hash of the resolved case and the build.
std::string probe_id(const ProbeCase& what);

/// Makes `folder` a result folder with run.json and probe.csv. Throws InputError, with nothing left behind, when that
/// fails.
void write_probe(const std::filesystem::path& folder, const ProbeCase& what, const ProbeResult& result);

}  // namespace musclebench
