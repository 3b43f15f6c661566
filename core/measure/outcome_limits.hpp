#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/column.hpp"

namespace musclebench {

struct Outcome;
struct MuscleAtRest;

/// The largest value of a figure with which a run still counts as `ok`.
struct OutcomeLimit {
  ColumnInfo info;
  double limit;
  std::string_view why;  ///< there is such a limit, and it is where it is
};

/// All limits, one row each: what makes a run `suspect`. They hold whatever the backend promises. A run beyond one of
/// them is not to be trusted without a look at it, and one within them may still be poor.
std::span<const OutcomeLimit> outcome_limits();

/// The limit of that name, which is in the table.
double outcome_limit(std::string_view name);

/// What is beyond its limit, in the order of the table: each a sentence that says what, how much, where, when and,
/// where one is known, a cure. What was not measured is beyond none.
std::vector<std::string> suspicions(const Outcome& outcome, const MuscleAtRest& rest);

/// What a reader should know of a run and what makes it not suspect.
std::vector<std::string> outcome_notes(const Outcome& outcome);

}  // namespace musclebench
