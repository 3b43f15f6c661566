#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/base/column.hpp"
#include "core/measure/outcome.hpp"

namespace musclebench {

/// The largest value of a figure with which a run still counts as `ok`.
struct OutcomeLimit {
  ColumnInfo info;
  double limit;
};

/// All limits, one row each. They are generous: a run beyond one of them is not to be trusted without a look at it, and
/// one within them may still be poor.
std::span<const OutcomeLimit> outcome_limits();

/// What is beyond its limit, in words, in the order of the table. What was not measured is beyond none.
std::vector<std::string> suspicions(const Outcome& outcome, const MuscleAtRest& rest);

}  // namespace musclebench
