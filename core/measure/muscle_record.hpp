#pragma once

#include <ostream>
#include <span>
#include <string>

#include "core/base/column.hpp"
#include "core/measure/step_record.hpp"

namespace musclebench {

/// Of one muscle of several in one frame: a row of muscles.csv. Times are the whole loop's and stand in frames.csv.
struct MuscleRow {
  const StepRecord& step;
  const std::string& muscle;
  const MuscleRecord& record;
};

/// The columns of a run's muscles.csv.
std::span<const Column<MuscleRow>> muscle_columns();

/// Writes the header and, for each frame, a line a muscle. `names` are in the order of `StepRecord::muscles`.
void write_muscles_csv(std::ostream& out, std::span<const std::string> names, std::span<const StepRecord> records);

}  // namespace musclebench
