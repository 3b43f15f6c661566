#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/hard/hard_case.hpp"

namespace musclebench {

/// Cases down, backends across.
struct HardMatrix {
  std::vector<std::string> backends;
  std::vector<HardCase> cases;
  std::vector<std::vector<HardCell>> cells = {};  ///< by case, by backend

  [[nodiscard]] int count(Verdict verdict) const;
};

/// The column of a backend: its name, or `loop` for one that finds no contacts and so can fail in no case that asks a
/// backend.
std::string column_of(const BackendEntry& entry);

/// For a terminal: the matrix, then a line for each cell that breaks or was refused, with its figure and its bar.
std::string text_of(const HardMatrix& matrix);
/// The same as a page, with what happens in each case, why it is hard and what its bar is.
std::string markdown_of(const HardMatrix& matrix);
/// One row a figure: case, backend, verdict, figure, value, bar, unit, detail, seconds, scene.
std::string csv_of(const HardMatrix& matrix);

/// matrix.csv and matrix.md in `folder`, which is made; each is whole or not there. Throws InputError where they can't
/// be written.
void write_matrix(const HardMatrix& matrix, const std::filesystem::path& folder);

}  // namespace musclebench
