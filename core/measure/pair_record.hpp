#pragma once

#include <ostream>
#include <span>
#include <string>

#include "core/base/column.hpp"
#include "core/measure/step_record.hpp"

namespace musclebench {

/// Of one pair of muscles that touch in one frame: a row of pairs.csv.
struct PairRow {
  const StepRecord& step;
  const std::string& muscle;
  const std::string& other;
  const PairRecord& record;
};

/// The columns of a run's pairs.csv.
std::span<const Column<PairRow>> pair_columns();

/// Writes the header and, for each frame, a line a pair. `names`: of all muscles.
void write_pairs_csv(std::ostream& out, std::span<const std::string> names, std::span<const StepRecord> records);

}  // namespace musclebench
