#pragma once

#include <ostream>
#include <span>
#include <string>
#include <string_view>

namespace musclebench {

/// Describes a column of a table of results, or a key of a manifest.
struct ColumnInfo {
  std::string_view name;
  std::string_view unit;  ///< empty for counts, ratios, words and flags
  std::string_view help;
};

/// A column of a CSV file over rows of type `Row`. The file is written from the same table as its documentation, so the
/// two can't differ. An unknown figure is an empty cell.
template <typename Row>
struct Column {
  ColumnInfo info;
  std::string (*cell)(const Row& row);
};

template <typename Row>
void write_table(std::ostream& out, std::span<const Column<Row>> columns, std::span<const Row> rows) {
  const char* separator = "";
  for (const Column<Row>& column : columns) {
    out << separator << column.info.name;
    separator = ",";
  }
  out << '\n';
  for (const Row& row : rows) {
    separator = "";
    for (const Column<Row>& column : columns) {
      out << separator << column.cell(row);
      separator = ",";
    }
    out << '\n';
  }
}

}  // namespace musclebench
