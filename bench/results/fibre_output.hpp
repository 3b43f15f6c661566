#pragma once

#include <filesystem>
#include <string>

#include "bench/cases/run_case.hpp"
#include "bench/results/manifest.hpp"

namespace musclebench {

/// The fibres of a snapshot within a result folder.
std::string fibre_file(const Snapshot& snapshot);

/// Writes fibres.csv and fibre_lengths.csv, and the fibres of each snapshot as lines in legacy VTK (m), which ParaView
/// and 3D Slicer read: with each its muscle's index and its length over that at rest.
void write_fibres(const std::filesystem::path& folder, const RunCase& run, const RunResult& result);

/// "fibres": [{muscle, asked, followed}].
Json json_of_fibres(const RunResult& result);

/// For people: lengths and moment arms of each muscle.
std::string fibre_summary(const RunCase& run, const RunResult& result);

}  // namespace musclebench
