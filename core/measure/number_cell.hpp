#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>

namespace musclebench {

/// The cell of a number in a table: its shortest text that reads back to the same bits; empty unless it is finite.
inline std::string number_cell(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }
inline std::string number_cell(const std::optional<double>& value) { return value ? number_cell(*value) : ""; }

}  // namespace musclebench
