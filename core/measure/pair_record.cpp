#include "core/measure/pair_record.hpp"

#include <array>
#include <vector>

#include <fmt/format.h>

namespace musclebench {

namespace {

constexpr std::array<Column<PairRow>, 7> of_a_pair{{
    {{"frame", "", "1 for the first"}, [](const PairRow& r) { return fmt::format("{}", r.step.frame); }},
    {{"angle_deg", "deg", "of the bone that turns most"},
     [](const PairRow& r) { return fmt::format("{}", r.step.angle_deg); }},
    {{"muscle", "", "its name"}, [](const PairRow& r) { return r.record.muscle; }},
    {{"other", "", "the bone, or the muscle that it touches"}, [](const PairRow& r) { return r.record.other; }},
    {{"contacts", "", "nodes in the bone, or of either muscle in the other, answered in the frame's last detection"},
     [](const PairRow& r) { return fmt::format("{}", r.record.contacts); }},
    {{"detect_ns", "ns",
      "asking the nodes of the pair; sum over the frame's steps and over threads; empty: the backend does not say"},
     [](const PairRow& r) { return r.record.detect_ns ? fmt::format("{}", *r.record.detect_ns) : std::string(); }},
    {{"crossing_triangles", "", "of the muscle that pass through the other; empty: not tested in this frame"},
     [](const PairRow& r) { return r.record.crossings ? fmt::format("{}", *r.record.crossings) : std::string(); }},
}};

}  // namespace

std::span<const Column<PairRow>> pair_columns() { return of_a_pair; }

void write_pairs_csv(std::ostream& out, std::span<const StepRecord> records) {
  std::vector<PairRow> rows;
  for (const StepRecord& step : records) {
    for (const PairRecord& pair : step.pairs) rows.push_back({step, pair});
  }
  write_table(out, std::span<const Column<PairRow>>(of_a_pair), std::span<const PairRow>(rows));
}

}  // namespace musclebench
