#include "bench/hard/hard_matrix.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "core/base/atomic_file.hpp"

namespace musclebench {

namespace {

std::string with_unit(double value, const std::string& unit) {
  return unit.empty() ? fmt::format("{:.3g}", value) : fmt::format("{:.3g} {}", value, unit);
}

std::string words_of(const HardFigure& figure) {
  return fmt::format("{}: {} (bar {})", figure.name, with_unit(figure.value, figure.unit),
                     with_unit(figure.bar, figure.unit));
}

/// What is to be said of a cell beyond its verdict.
std::string explanation(const HardCell& cell) {
  if (cell.verdict == Verdict::not_applicable) return cell.detail;
  const HardFigure* worst = worst_figure(cell);
  std::string words = worst == nullptr ? "" : words_of(*worst);
  if (!cell.detail.empty()) words += (words.empty() ? "" : "; ") + cell.detail;
  return words;
}

std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char letter : text) result += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return result + '"';
}

/// Without what a table of Markdown would take for its own.
std::string for_table(std::string text) {
  std::ranges::replace(text, '|', '/');
  std::ranges::replace(text, '\n', ' ');
  return text;
}

template <typename Visit>
void for_each_cell(const HardMatrix& matrix, const Visit& visit) {
  for (std::size_t row = 0; row < matrix.cells.size(); ++row) {
    for (std::size_t column = 0; column < matrix.cells[row].size(); ++column) visit(row, column);
  }
}

std::string totals(const HardMatrix& matrix) {
  return fmt::format("{} hold, {} break, {} refused, {} not applicable", matrix.count(Verdict::holds),
                     matrix.count(Verdict::breaks), matrix.count(Verdict::refused),
                     matrix.count(Verdict::not_applicable));
}

}  // namespace

std::string column_of(const BackendEntry& entry) {
  const bool finds_contacts = entry.make(HardRequest{.backend = entry}.parameters())->capabilities().finds_contacts;
  return finds_contacts ? entry.name : "loop";
}

int HardMatrix::count(Verdict verdict) const {
  int found = 0;
  for (const std::vector<HardCell>& row : cells) {
    found += static_cast<int>(std::ranges::count(row, verdict, &HardCell::verdict));
  }
  return found;
}

std::string text_of(const HardMatrix& matrix) {
  std::size_t width = 0;
  for (const HardCase& each : matrix.cases) width = std::max(width, each.id.size());
  std::string text = fmt::format("{:<{}}", "", width);
  for (const std::string& backend : matrix.backends) text += fmt::format("  {:<11}", backend);
  text += '\n';
  for (std::size_t row = 0; row < matrix.cells.size(); ++row) {
    text += fmt::format("{:<{}}", matrix.cases[row].id, width);
    for (const HardCell& cell : matrix.cells[row]) {
      text += fmt::format("  {:<11}", cell.verdict == Verdict::not_applicable ? "-"
                                      : cell.verdict == Verdict::breaks       ? "BREAKS"
                                                                              : name_of(cell.verdict));
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  for (const Verdict verdict : {Verdict::breaks, Verdict::refused}) {
    if (matrix.count(verdict) > 0) text += fmt::format("\n{}:\n", name_of(verdict));
    for_each_cell(matrix, [&](std::size_t row, std::size_t column) {
      const HardCell& cell = matrix.cells[row][column];
      if (cell.verdict != verdict) return;
      text += fmt::format("  {}, {}: {}\n", matrix.cases[row].id, matrix.backends[column], explanation(cell));
    });
  }
  return text + fmt::format("\n{}\n", totals(matrix));
}

std::string markdown_of(const HardMatrix& matrix) {
  std::string text = "# Hard cases\n\n| case |";
  for (const std::string& backend : matrix.backends) text += fmt::format(" {} |", backend);
  text += "\n| --- |";
  for (std::size_t i = 0; i < matrix.backends.size(); ++i) text += " --- |";
  text += '\n';
  for (std::size_t row = 0; row < matrix.cells.size(); ++row) {
    text += fmt::format("| {} |", matrix.cases[row].id);
    for (const HardCell& cell : matrix.cells[row]) {
      const HardFigure* worst = worst_figure(cell);
      if (cell.verdict == Verdict::not_applicable) {
        text += " - |";
      } else if (cell.verdict == Verdict::holds || worst == nullptr) {
        text += fmt::format(" {} |", name_of(cell.verdict));
      } else {
        text += fmt::format(" **{}**: {} ({}) |", name_of(cell.verdict), with_unit(worst->value, worst->unit),
                            with_unit(worst->bar, worst->unit));
      }
    }
    text += '\n';
  }
  text += fmt::format("\n{}.\n", totals(matrix));
  for (std::size_t row = 0; row < matrix.cells.size(); ++row) {
    const HardCase& each = matrix.cases[row];
    text += fmt::format("\n## {}\n\n{} {} Bar: {}.\n\n", each.id, each.what, each.why, each.bar);
    if (!each.left_out_because.empty()) text += fmt::format("Sane figures left out: {}.\n\n", each.left_out_because);
    text += "| backend | | figure farthest beyond its bar, or nearest to it |\n| --- | --- | --- |\n";
    for (std::size_t column = 0; column < matrix.cells[row].size(); ++column) {
      const HardCell& cell = matrix.cells[row][column];
      text += fmt::format("| {} | {} | {} |\n", matrix.backends[column], name_of(cell.verdict),
                          for_table(explanation(cell)));
    }
  }
  return text;
}

std::string csv_of(const HardMatrix& matrix) {
  std::string text = "case,backend,verdict,figure,value,bar,unit,detail,seconds,scene\n";
  for_each_cell(matrix, [&](std::size_t row, std::size_t column) {
    const HardCell& cell = matrix.cells[row][column];
    const std::string head =
        fmt::format("{},{},{}", matrix.cases[row].id, matrix.backends[column], name_of(cell.verdict));
    const std::string tail = fmt::format("{},{:.3f},{}", in_quotes(cell.detail), cell.seconds, matrix.cases[row].scene);
    if (cell.figures.empty()) text += fmt::format("{},,,,,{}\n", head, tail);
    for (const HardFigure& figure : cell.figures) {
      text +=
          fmt::format("{},{},{},{},{},{}\n", head, in_quotes(figure.name), figure.value, figure.bar, figure.unit, tail);
    }
  });
  return text;
}

void write_matrix(const HardMatrix& matrix, const std::filesystem::path& folder) {
  write_atomically(folder / "matrix.csv", [&](std::ostream& out) { out << csv_of(matrix); });
  write_atomically(folder / "matrix.md", [&](std::ostream& out) { out << markdown_of(matrix); });
}

}  // namespace musclebench
