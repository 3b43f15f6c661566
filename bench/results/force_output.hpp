#pragma once

#include <filesystem>
#include <string>

#include "bench/cases/run_case.hpp"
#include "bench/results/manifest.hpp"

namespace musclebench {

/// The path of a snapshot's table of bones in the run's folder.
std::string bone_pressure_file(const Snapshot& snapshot);

/// Writes forces.csv and the tables of bones.
void write_forces(const std::filesystem::path& folder, const RunResult& result);

/// "forces": the number of rows, what is left out, the largest torques and pressure.
Json json_of_forces(const RunResult& result);

/// For people: the torque of each joint, the largest contact force and pressure. Empty without forces.
std::string force_summary(const RunResult& result);

}  // namespace musclebench
