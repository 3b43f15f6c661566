#include "bench/hard/run_figures.hpp"

#include <fmt/format.h>

namespace musclebench {

void RunFigures::add_bare_run(const MovedScene& run, const std::string& words, std::vector<HardFigure> figures) {
  const std::string said = run.said();
  for (HardFigure& figure : figures) {
    if (!words.empty() && !figure.name.starts_with(words)) figure.name = fmt::format("{}: {}", words, figure.name);
    if (!figure.holds() && said.empty()) m_silent = true;
    if (!figure.holds() && m_said.empty()) m_said = said;
    m_figures.push_back(std::move(figure));
  }
}

void RunFigures::add_run(const MovedScene& run, const std::string& words, std::vector<HardFigure> figures,
                         const SaneBars& bars) {
  add_bare_run(run, words, with_sane_figures(std::move(figures), run, m_request, words, bars));
}

void RunFigures::add_tight_run(const MovedScene& run, const std::string& words, std::vector<HardFigure> figures) {
  constexpr double promised_m = 1e-4;
  const PassingTriangles passing = passing_triangles(run, declared_missed_m(run, m_request));
  figures.push_back({"triangles through the muscle itself", static_cast<double>(passing.itself), 0, "triangles"});
  if (run.scene.muscles.size() > 1) {
    figures.push_back({"triangles through other muscles", static_cast<double>(passing.muscles), 0, "triangles"});
  }
  add_run(run, words, std::move(figures), {.depth_m = promised_m, .depth_share = 0, .passing = false});
}

bool RunFigures::add_if_diverged(const MovedScene& run, const std::string& words) {
  if (run.result.status != "diverged") return false;
  add_bare_run(run, words, {{"runs that diverge", 1, 0}});
  return true;
}

HardCell RunFigures::judged(MayRefuse may_refuse) const {
  return musclebench::judged(m_figures, m_request, m_silent ? "" : m_said, may_refuse);
}

HardCell without(HardCell cell, const std::string& left_out) {
  if (!cell.detail.empty()) cell.detail += "; ";
  cell.detail += left_out;
  return cell;
}

}  // namespace musclebench
