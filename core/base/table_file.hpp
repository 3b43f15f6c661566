#pragma once

#include <filesystem>
#include <span>

#include "core/base/column.hpp"
#include "core/base/output_file.hpp"

namespace musclebench {

/// Writes a CSV file whole. Throws InputError where that fails (a full disk, say).
template <typename Row>
void write_table_file(const std::filesystem::path& path, std::span<const Column<Row>> columns,
                      std::span<const Row> rows) {
  OutputFile file(path);
  write_table(file.stream(), columns, rows);
  file.close();
}

}  // namespace musclebench
