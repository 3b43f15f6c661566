#pragma once

#include <ostream>
#include <span>
#include <string>

#include "core/base/column.hpp"
#include "core/measure/step_record.hpp"

namespace musclebench {

/// Of one pair in one frame: a row of pairs.csv.
struct PairRow {
  const StepRecord& step;
  const PairRecord& record;
};

/// The columns of a run's pairs.csv.
std::span<const Column<PairRow>> pair_columns();

/// Writes the header and, for each frame, a line a pair.
void write_pairs_csv(std::ostream& out, std::span<const StepRecord> records);

}  // namespace musclebench
